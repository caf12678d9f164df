/* SPDX-License-Identifier: Apache-2.0
 *
 * The inner loop of a co-simulation, over flat tables that Python has filled in: cosim/engine/loop/_tables.py holds the same
 * structures. Times are in seconds. All memory belongs to the caller and stays where it is during a run, except for
 * texts; nothing is shared between two engines, so that runs in several threads do not disturb each other.
 *
 * It must give the same numbers as the loop in cosim/engine/loop/_loop.py, bit for bit: compile it without contraction of
 * a * b + c and without any other licence to change what floating point gives.
 */
#ifndef COSIM_ENGINE_H
#define COSIM_ENGINE_H

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
#define OFTEN static inline __attribute__((always_inline))
#define RARE static __attribute__((noinline, cold)) /* kept out of the way of what happens in every step */

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SAME_INSTANT 1e-9 /* two instants closer than this are one */
#define MOST_UPDATES 100  /* of discrete states, in one event */
#define MOST_ROUNDS 100   /* of discrete components setting each other off, at one instant */

typedef uint32_t ValueReference;
typedef int Status; /* of FMI: OK, Warning, Discard, Error, Fatal, Pending */
#define FAILED 2    /* from this status on, a call has failed */
#define FATAL 4     /* nothing can be done any more with the instance that returns it */

/* Any FMI function; it is converted to its own type before it is called. */
typedef void (*Function)(void);

/* How a variable lies in the memory that an FMI function takes. */
typedef enum { FLOAT64, FLOAT32, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, TEXT, BINARY } Type;

/* target = factor * source + offset, or what the table has in the place of that, as pairs of both; the source is a
 * signal, the target the input of the wire's place in its group. */
typedef struct {
    double factor, offset;
    int64_t source;
    const double *table;
    int64_t pairs;
} Wire;

/* How many value references and values a call has: an array has one reference for all its elements. */
typedef struct {
    int64_t references, values;
} Extent;

/* Indices: what is read between rows, since it drives something, and for a row. Of inputs all are always set. */
enum { CONNECTED, WHOLE };

/* A function of an FMU by its number among all that are called, and the component by its place in the system. */
typedef struct {
    int32_t component, function;
} Call;

/* Variables of one component and one FMI type, set or read by one call. */
typedef struct {
    Function access;
    const ValueReference *references;
    void *memory;       /* what the FMU reads or fills: the doubles themselves if they are Float64 */
    size_t *sizes;      /* of Binary variables, which lie where memory points to */
    const size_t *limits; /* and how many bytes each may have */
    double *doubles;    /* the same variables in the tables of the engine */
    const Wire *wires;  /* one per variable; inputs only */
    Extent extents[2];  /* connected variables come first */
    int32_t type;
    int32_t number;     /* its place among all groups, for the record of a failure */
    Call call;          /* for the position */
} Group;

typedef enum { OVERRIDE, BIAS, SCALE, FREEZE, DELAY, DROP, QUANTISE, NOISE } SignalFaultKind;

typedef struct {
    double time, value;
} Point;

/* What changes of a fault while a run goes on. */
typedef struct {
    double kept;            /* the value that a frozen or dropped signal keeps */
    double next;            /* instant at which it does something */
    int64_t period;         /* the present one of its random numbers, -1 before it looks at the signal */
    int64_t first, count;   /* of the points in use, the first, and the first behind them */
    int64_t jump;           /* no step of the signal before this point is still to come out of the delay */
    int32_t active, passing; /* passing: a value arrives at this instant */
} FaultState;

/* What is done to a signal from start to stop. draws[0] is for the time before boundary * every, each of the others
 * for a period. */
typedef struct {
    double amount, start, stop;
    double watch;           /* it looks at the signal from here on: what it keeps is the value at its start, or, where
                             * values are lost, at the last instant before at which one arrives */
    double every;
    const double *draws;
    Point *points;          /* of a delayed signal, whose history is a line through them; two of one time are a step */
    FaultState *state;
    int64_t boundary, capacity;
    int32_t kind;
    int32_t stepwise;       /* the signal keeps its value between communication points */
} SignalFault;

typedef struct Line Line;

/* An input with faults reads the signal `slot`. What drives it is at `at` at a communication point, at `held` in a step
 * between two; both differ for a linear channel and a linked input. */
typedef struct {
    Wire at, held;
    int64_t slot;
    const Line *line;
    const SignalFault *faults;
    int64_t n_faults;
    int64_t linked; /* its component is stepped together with what drives it */
} FaultyInput;

/* Of all faulty inputs. */
typedef struct {
    double time;      /* for which they are asked */
    double until;     /* the end of a step */
    double next;      /* instant at which a fault does something */
    int32_t stepping; /* in a step, of which `time` is the middle */
    int32_t full;     /* a history needs more memory before the next macro step */
    int32_t changed;  /* a fault has done something to a linked input */
    int32_t unused;
} FaultClock;

/* A change of this signal is an event for the component, even between its own events. */
typedef struct {
    Wire wire;
    const double *input;
} Trigger;

typedef enum { CONTINUOUS, EVENT, SAMPLED } Role;

typedef struct {
    void *instance;
    Function do_step, enter_event_mode, enter_step_mode, update_discrete_states;
    const Group *inputs, *outputs;
    const Trigger *triggers;
    const FaultyInput *faulty;
    int64_t n_inputs, n_triggers, n_faulty;
    int64_t n_outputs[2]; /* those with a connected variable come first */
    double period;    /* of a sampled component, or of a continuous one with steps of one length; else infinite */
    double due;       /* its next event or sample, or the end of its fixed step, infinite if there is none */
    double time;      /* up to which it has been stepped; not for continuous components with steps of any length */
    int64_t ticks;    /* samples or fixed steps taken */
    int64_t steps;    /* doStep calls */
    int64_t events;   /* instants with an event */
    int32_t fmi;      /* 1, 2 or 3 */
    int32_t role;
    int32_t number;   /* its place in the system */
    int32_t in_event_mode;
    int32_t event_needed; /* doStep has said so */
    int32_t stale;    /* outputs that are only recorded have not been read since it was computed */
    int32_t plain_step; /* do_step takes no flags, as in FMI 1.0 and 2.0 */
    int32_t no_return;  /* it will never be put back to a state of before its last step */
} Component;

/* Signal `slot` takes `value` at `time`; slot -1: nothing changes, but a linear channel has a corner there. */
typedef struct {
    double time, value;
    int64_t slot;
} Change;

/* A linear channel: its signal `slot` holds the value at an instant, `middle` that in the middle of a step. */
struct Line {
    const double *times, *values;
    int64_t count;
    double start; /* before its first entry */
    int64_t slot, middle;
};

/* A power connection: signals of effort and flow, and the inputs that hold factor * signal + offset; `watts` is what a
 * product of 1 is, with its sign. `start` are both signals where the macro step begins, `energies` those given, taken
 * and exchanged. */
typedef struct {
    int64_t effort, flow;
    const double *held_effort, *held_flow;
    double effort_factor, effort_offset, flow_factor, flow_offset, watts;
    double *start, *energies;
} Bond;

/* A text or a Binary that a component has put out. Its signal counts how often it has changed. */
typedef struct {
    char *bytes; /* allocated here, and a zero behind them; null if it has never been read */
    size_t size, room;
} Text;

typedef enum {
    NONE,
    CALL_FAILED,          /* a function returned `status` */
    ASKS_TO_END,
    RETURNED_EARLY,
    NEVER_SETTLES,        /* an event needs ever more updates */
    ANNOUNCES_THE_PAST,   /* as its next event */
    WITHOUT_END,          /* events of several components set each other off */
    NOT_A_NUMBER,
    OUT_OF_RANGE,         /* `value` does not fit an integer input of `group`, or as many bytes no Binary one */
    OUT_OF_MEMORY,        /* for a text or a Binary */
    DISAGREEMENT,         /* of coupled components at the end of a macro step, at `value` [s] */
    LOST                  /* what coupled components give each other is no finite number any more */
} FailureKind;

typedef enum { DO_STEP, ENTER_EVENT_MODE, ENTER_STEP_MODE, UPDATE_DISCRETE_STATES, ACCESS, SAVE, RESTORE, DERIVE } CalledFunction;

typedef struct {
    double value;
    int32_t kind, component, function, status, group, unused;
} Failure;

/* A connection between two components that are stepped together; see cosim/engine/coupling/_coupling.py for all of this. */
typedef struct {
    Wire wire;        /* gives the value of the input from the signals */
    int64_t slot;     /* of the signal that the target gets in its place, */
    const FaultyInput *faulty; /* or what faults make of that */
    int32_t ahead;    /* the source is stepped before the target */
    int32_t holds_end; /* the target holds the value at the end of a step, not the mean */
    int32_t observed; /* all states of the source are compared */
    int32_t unused;
} Link;

/* Outputs that depend directly on linked inputs; of the slots, as many are needed between rows, and for one. */
typedef struct {
    Function derivative;
    const ValueReference *inputs, *outputs;
    const int64_t *links, *slots;
    double *seed, *slope, *raw;
    int64_t n_links;
    int64_t n_slots[2];
} Correction;

/* A component that is stepped together with others. Without states that are known, `n_observed` is 0. */
typedef struct {
    Component *component;
    const int64_t *links; /* those that it is the target of */
    const Correction *correction;
    const Group *reads; /* into `observed` */
    double *observed, *full, *scale;
    Function save, restore;
    void **states;
    int64_t n_links, n_observed;
    int32_t numbers[4]; /* of the functions that save, restore, and derive, for the position */
} Member;

typedef enum { EXTRAPOLATED, ITERATED, ADAPTIVE } Method;
enum { OUTER, INNER }; /* places for what is to be gone back to */

typedef struct {
    const Link *links;
    const Member *members;
    Component *const *others; /* continuous components beside the members */
    const int64_t *cut, *steady;
    double *start, *end, *last, *before, *full, *magnitudes, *times; /* by link, but for the last */
    double *was, *matrix, *inputs;
    double *residual, *change, *probed, *scratch; /* by cut link, of as many rows; the last a matrix and the ends */
    double *energies, *powers; /* of the power connections */
    double *kept[2];
    int64_t n_links, n_members, n_others, n_cut, n_steady, n_numbers, n_inputs;
    int64_t known, known_then[2];
    int64_t macro_steps, rejected, repeated, forced;
    double tolerance, stop, wanted, usual, error, divisor;
    double allowed; /* part of the tolerance, where intervals are divided */
    double front;    /* where the members are within an interval, which may take longer than a call is to last */
    double deadline; /* of this call, by the wall clock */
    int64_t number;  /* of the macro steps of one length that were taken in it */
    int64_t earlier; /* macro steps before it */
    int32_t method, order, loops, has_matrix;
    int32_t under_way;   /* within an interval */
    int32_t out_of_time; /* the call ends there, to go on later */
} Coupling;

/* Where the run is. It may lie in memory that another process reads, which wants to know where this one has died. */
typedef struct {
    double now;          /* the last communication point that was reached */
    int64_t row;         /* recorded so far */
    int64_t exchanges;
    int64_t calls;       /* of functions of FMUs, so far, outside of this loop */
    Call call;           /* the last one, also of this loop, if it is watched; written in one piece */
} Position;

typedef struct {
    Position at;
    double *values;      /* the signals; the first n_recorded are the columns of the result */
    const double *grid;  /* times of the rows; the last is the end of the run */
    double *rows;        /* column i begins at rows + i * n_rows */
    Component *discrete, *continuous;
    const Change *changes;
    const Line *lines;
    Coupling *coupling;  /* null if continuous components hold what they are given */
    Text *texts;         /* of the signals from first_text on */
    const FaultyInput *faulty;
    FaultClock *fault_clock;
    const Bond *bonds;
    int64_t n_values, n_recorded, n_rows, first_text;
    int64_t n_discrete, n_continuous, n_changes, n_lines, n_faulty, n_bonds;
    int64_t change;      /* the first that was not yet applied */
    double step;         /* macro step; fixed-step algorithm only */
    double longest;      /* macro step of the others, infinite if there is none */
    double pause;        /* the first communication point at or after it is where to return */
    int32_t coupled;     /* every communication point is an exchange */
    int32_t started;
    int32_t not_a_number; /* an output that has been read is none */
    int32_t parts;       /* steps of the continuous components from instant to instant; not for the fixed-step algorithm */
    Failure failure;
} Engine;

typedef enum { NO_FAULT, WRONG_ADDRESS, STACK_OVERFLOW } FaultKind;

/* What has ended the process. */
typedef struct {
    uint64_t address;
    int32_t kind, unused;
} Fault;

typedef enum { UNFINISHED, FINISHED, BROKEN, PAUSED } Outcome;

#endif
