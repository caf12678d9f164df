/* SPDX-License-Identifier: MIT-0
 *
 * Simulation of one model instance: initialisation, continuous integration, state and time events.
 *
 * Functions that can fail return 0 for failure, with the reason in message.
 */
#ifndef COSIM_SIMULATION_H
#define COSIM_SIMULATION_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "calls.h"
#include "model.h"
#include "newton.h"
#include "rodas.h"

/* Two instants closer than this are one (in seconds). */
#define SAME_INSTANT 1e-9

#if defined(__GNUC__)
#define PRINTF_LIKE(text, first) __attribute__((format(printf, text, first)))
#else
#define PRINTF_LIKE(text, first)
#endif

/* The solver may be ahead of the time that the importer knows: in a step that goes beyond it. As long as no input
 * changes, the solution is read off that step; else the step is given up. */
typedef struct {
    int active;
    int ends_in_event; /* a state event is at `end`, else the step just ends there */
    double end, theta_end; /* in seconds and as a part of the step */
    RodasStep step;
} Ahead;

/* How a relation's events follow each other: the last one, the time from the one before to it, and how many times in
 * a row that time was shorter than the time before. */
typedef struct {
    double last, interval;
    int64_t shorter;
} Accumulation;

/* Where the solver was when its progress was last looked at, and what has happened since. */
typedef struct {
    double t, v[MODEL_ROOM(MODEL_NV)];
    int64_t attempts, events;
} Window;

/* What Model Exchange remembers: how far the importer may go back, and how the relations' indicators are to be shown. */
typedef struct {
    double event, completed[2]; /* when the last event was, the last completed step, and the one before */
    double size[MODEL_ROOM(MODEL_NG)], shift[MODEL_ROOM(MODEL_NG)]; /* see indicators.c */
    int measured;      /* size is known */
    int reinitialised; /* states have new values that the importer has not been told of */
} Watched;

/* The points of Model Exchange at which v was last solved for and kept, since the last event, the last one first; its
 * algebraic unknowns are those of the state. See predict.c. */
typedef struct {
    double t[2], x[2][MODEL_ROOM(MODEL_NX)], z_before[MODEL_ROOM(MODEL_NZ)];
    int known; /* of the two */
} Settled;

typedef enum { TANGENT_UNKNOWN, TANGENT_FOUND, NO_TANGENT } Tangent;

/* The determinant of one set of constraints: mantissa * 2^exponent, as a product of many pivots leaves the range. */
typedef struct {
    double mantissa;
    int exponent;
} Determinant;

/* The last two completed steps in Model Exchange, as far as known: see reflection.c. */
typedef struct {
    int points, told;  /* how many of them are known; the importer has been warned */
    double t[2]; /* the last one comes first */
    Determinant determinant[2][MODEL_ROOM(MODEL_NCONSTRAINTS)];
    double v[MODEL_ROOM(MODEL_NV)], f[MODEL_ROOM(MODEL_NV)]; /* at the last one */
} Trend;

/* All that determines the future of an instance, and nothing else: saving it is copying it. */
typedef struct {
    double t, stop, tolerance;
    double v[MODEL_ROOM(MODEL_NV)];
    double u[MODEL_ROOM(MODEL_NU)];
    double u_waiting[MODEL_ROOM(MODEL_NU)]; /* if inputs_wait: what u becomes when the next step begins (FMI 2.0) */
    double p[MODEL_ROOM(MODEL_NP)];
    double d[MODEL_ROOM(MODEL_ND)]; /* between events also pre(d) */
    double c[MODEL_ROOM(MODEL_NG)];
    double d_kept[MODEL_ROOM(MODEL_ND)]; /* if kept: d and c as the importer still sees them */
    double c_kept[MODEL_ROOM(MODEL_NG)];
    double clock_start[MODEL_ROOM(MODEL_NS)];
    double clock_interval[MODEL_ROOM(MODEL_NS)];
    int64_t tick[MODEL_ROOM(MODEL_NS)]; /* number of the next tick */
    double relation_due; /* when the next relation of time changes, INFINITY if none does */
    StepControl control;
    Ahead ahead;
    double grid_end;     /* where the present fixed step ends, and how many events it has had */
    int64_t grid_events;
    double burst_start; /* when the present burst of state events began, and how many there were since */
    int64_t burst_events;
    Accumulation accumulation[MODEL_ROOM(MODEL_NG)];
    Window window;
    Watched watched;
    Settled settled;
    Trend trend;
    uint64_t counters[COUNTERS];
    signed char selection_sign[MODEL_ROOM(MODEL_NCONSTRAINTS)]; /* of the constraints' determinants; 0 if not known */
    InterfaceType type; /* of the FMI shell, as is the mode */
    int mode;
    int inputs_wait;
    int keeping; /* an event from now on is to keep d and c as they are for the importer, who has not seen it yet */
    int kept;
    int initialised; /* v, d, c solve the initial equations for the present u, p, t */
    int event_due;   /* inputs have changed or a relation has: an event iteration must come before integrating on */
    int terminate;   /* the model has called terminate(), with message terminate - 1 */
    unsigned char warned[MODEL_ROOM(MODEL_NA)];
} State;

typedef enum { LOG_EVENT, LOG_WARNING, LOG_DISCARD, LOG_ERROR } LogKind;

typedef struct {
    State s;
    /* Scratch, of no meaning between two calls. */
    Rodas rodas;
    Newton newton;
    Tangent tangent; /* of the settled point, in rodas */
    unsigned char changing[MODEL_ROOM(MODEL_NG)]; /* relations that changed last */
    /* Cache of values derived from s; bit (1 << ModelStore) of have says which are valid. */
    unsigned have;
    double shown_v[MODEL_ROOM(MODEL_NV)]; /* s.v with the algebraic unknowns solved to full accuracy */
    double shown_f[MODEL_ROOM(MODEL_NV)];
    double shown_y[MODEL_ROOM(MODEL_NY)];
    double shown_l[MODEL_ROOM(MODEL_NL)];
    double shown_g[MODEL_ROOM(MODEL_NG)];
    double kept_y[MODEL_ROOM(MODEL_NY)];
    double kept_l[MODEL_ROOM(MODEL_NL)];
    /* Warnings and event notes, and the errors of the FMI shell, go here, if not NULL. */
    void (*log)(void *log_context, LogKind kind, const char *text);
    void *log_context;
    int log_events;
    /* If not NULL, called at the end of each of the solver's steps inside a communication step; it may set return_at, at
     * which the communication step ends early. */
    void (*intermediate)(void *log_context);
    double return_at;
    char message[1024];
} Simulation;

typedef enum { ADVANCE_REACHED, ADVANCE_EVENT, ADVANCE_TERMINATED, ADVANCE_FAILED } Advance;

/* Start values of inputs and parameters; forget everything else. */
void simulation_reset(Simulation *m);

/* Inputs or parameters were set: what was derived from them is no longer valid. */
void simulation_changed(Simulation *m, int parameters);

/* Solve the initial equations at s.t. */
int simulation_initialise(Simulation *m);

/* Integrate to s.t = to exactly, at most up to the next state event if stop_at_events, and up to where a relation of time
 * changes. The solver may go beyond, up to `limit` >= to, where something is known to happen. Knows nothing of clocks. */
Advance simulation_advance(Simulation *m, double to, double limit, int stop_at_events);

/* One event at s.t and everything that follows from it. The clock ticks that are due take part only if with_ticks: those
 * at the end of a communication step have to wait for the importer's inputs.
 * reinitialised (may be NULL) tells whether a state was set. */
int simulation_event(Simulation *m, int with_ticks, int *reinitialised);

/* The last event, in which terminal() is true. */
int simulation_end(Simulation *m);

/* Time of the next time event, INFINITY if there is none: a clock tick, or the change of a relation of time. */
double simulation_next_time_event(const Simulation *m);
/* Whether a clock tick is at s.t, and whether a time event of either kind is. */
int simulation_tick_is_due(const Simulation *m);
int simulation_time_event_is_due(const Simulation *m);

/* The values of a store at s.t, NULL on failure. They satisfy the algebraic equations to rounding errors. */
const double *simulation_values(Simulation *m, ModelStore store);

/* The same for variables that change at events only, as they were before the events that are kept from the importer. */
const double *simulation_kept_values(Simulation *m, ModelStore store);

/* For the runtime itself. */
int simulation_fail(Simulation *m, const char *format, ...) PRINTF_LIKE(2, 3);
int simulation_solve_algebraic(Simulation *m, double t, double *v, double *y); /* y, the outputs, may be NULL */
/* By a few Newton sweeps, from unknowns that are roughly right; 0 with v unchanged if they are not. */
int simulation_solve_nearby(Simulation *m, double t, double *v, double *y);
/* In Model Exchange v has been solved for at s.t and is kept: trial points are looked for from there. */
void simulation_settle(Simulation *m, const double *v, int after_event);
/* Move the algebraic unknowns of v, those of the settled point, to about s.t and the states of v; 0 if nothing is known. */
int simulation_predict(Simulation *m, double *v);
/* x = -(df_z/dz)^-1 x at the settled point, if that is where v is; else 0. */
int simulation_solve_at_settled(Simulation *m, const double *v, double *x);
/* The initial equations have no solution at s.v, where m->newton gave up: which of them, and for which unknowns. */
int simulation_blame_initial(Simulation *m, NewtonOutcome outcome);
/* Events and progress are watched from s.t on. */
void simulation_start_watching(Simulation *m);
/* The relations in m->changing have changed at s.t: refuse to follow events that come ever faster. */
int simulation_count_event(Simulation *m);
/* A step of the solver's own choice was accepted or rejected: refuse to go on where the solver makes no progress. */
int simulation_check_progress(Simulation *m);
/* If the choice of states is singular at s.t and v, say so instead of what the message says now. Returns 0. */
int simulation_blame_selection(Simulation *m, const double *v);
/* After a step: whether the choice of states has stayed regular, as far as looked at; 0 with a message if not. */
int simulation_check_selection(Simulation *m);
/* The determinants of all sets of constraints at t and v; and the message that the choice was singular at v, before s.t. */
void simulation_determinants(const Simulation *m, double t, const double *v, Determinant *determinant);
int simulation_blame_passed(Simulation *m, const double *v, int k);
/* After a step of an importer: warn, once, if it may have turned back where it should have passed a singular point. */
void simulation_watch_for_reflection(Simulation *m);
int simulation_check_assertions(Simulation *m);
void simulation_log_termination(Simulation *m, LogKind kind);
void simulation_log_state_event(const Simulation *m); /* of the relations in m->changing */
void simulation_relations(const Simulation *m, double t, const double *v, double *g);

/* Inline, as the search for events asks them of every relation at several points of every step. */
static inline int simulation_truth(const Simulation *m, int k, double g)
{
    if (isnan(g)) return m->s.c[k] != 0.0;
    double slope = RELATION_SLOPE(k);
    /* A relation of time has changed once its instant and the present one are the same. */
    if (slope != 0.0) return slope > 0.0 ? g >= -slope * SAME_INSTANT : g > -slope * SAME_INSTANT;
    return model_relation_strict[k] ? g > 0.0 : g >= 0.0;
}

/* Whether relation k has changed as the solver must find out: that of a relation of time is known beforehand. */
static inline int simulation_changed_state(const Simulation *m, int k, double g)
{
    return RELATION_SLOPE(k) == 0.0 && simulation_truth(m, k, g) != (m->s.c[k] != 0.0);
}

int simulation_find_event(Simulation *m, double *theta);
#if MODEL_HAS_FIXED_STEP
int simulation_take_fixed_step(Simulation *m, double limit);
int simulation_find_event_in_fixed_step(Simulation *m, double *theta);
#endif

/* Whether the importer is to watch a relation: not if it is known beforehand when it changes. */
static inline int simulation_is_watched(int k)
{
    return RELATION_SLOPE(k) == 0.0;
}

/* The relations' event indicators at s.t and v, NG of them, and what is left to do for them after an event; v is what
 * simulation_values gives. */
void simulation_indicators(const Simulation *m, const double *v, double *z);
void simulation_arm_indicators(Simulation *m, const double *v);
/* Which relations have changed when an importer comes with an event: count and log it, refuse to follow chattering. */
int simulation_note_state_event(Simulation *m);
const char *simulation_changing_relations(const Simulation *m, char *text, size_t size);

#endif
