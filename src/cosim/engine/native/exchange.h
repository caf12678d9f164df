/* SPDX-License-Identifier: Apache-2.0
 *
 * A Model Exchange FMU together with a solver is an instance that steps. All functions named cosim_exchange_... take
 * such an instance where FMI's function of that name takes one, so that whoever steps FMUs need not know which kind it
 * is; those that differ in FMI 2.0 and 3.0 are named cosim_exchange2_... and cosim_exchange3_... Times are in seconds.
 *
 * All memory is allocated when the instance is made; what a copy of its state takes, when that is made.
 */
#ifndef COSIM_EXCHANGE_H
#define COSIM_EXCHANGE_H

#include "engine.h"
#include "rodas_table.h"
#include "step_control.h"

/* The types of variables in both versions of FMI. */
#define VARIABLE_TYPES(X)                                                                                          \
    X(Real) X(Integer) X(Boolean) X(String) X(Binary) X(Float64) X(Float32) X(Int8) X(UInt8) X(Int16) X(UInt16)    \
        X(Int32) X(UInt32) X(Int64) X(UInt64)

/* Functions of the FMU; cosim/engine/exchange/_exchange_native.py has the same order. */
#define ACCESSED(Type) FMU_GET_##Type, FMU_SET_##Type,
typedef enum {
    FMU_SET_TIME, FMU_SET_STATES, FMU_GET_STATES, FMU_GET_NOMINALS, FMU_GET_RATES, FMU_GET_INDICATORS,
    FMU_GET_DIRECTIONAL_DERIVATIVE, FMU_ENTER_EVENT_MODE, FMU_ENTER_CONTINUOUS_TIME_MODE, FMU_UPDATE, FMU_COMPLETE_STEP,
    FMU_GET_STATE, FMU_SET_STATE, FMU_FREE_STATE, FMU_STATE_SIZE, FMU_SERIALIZE, FMU_DESERIALIZE,
    VARIABLE_TYPES(ACCESSED) FMU_FUNCTIONS
} FmuFunction;
#undef ACCESSED

/* What is known of the FMU before it is stepped. */
typedef struct {
    void *instance;                     /* the FMU's own */
    Position *at;                       /* where its calls are noted */
    Function functions[FMU_FUNCTIONS];  /* null where it has none */
    const ValueReference *states, *rates; /* null: it gives no directional derivatives */
    const int32_t *owners;              /* of [colour][rate]: the state of this colour that it depends on, or -1 */
    int64_t n_states, n_indicators, n_colours;
    int32_t numbers[FMU_FUNCTIONS];     /* of the functions, for the position */
    int32_t number;                     /* of the component */
    int32_t fmi;                        /* 2 or 3 */
    int32_t own_events;                 /* the loop leads the FMU through the events at the ends of steps */
    int32_t completes;                  /* it is to be told of each step of the solver */
    int32_t autonomous;                 /* its rates do not depend on time */
    int32_t unused;
} Known;

enum { STEPS, REJECTED_STEPS, RHS_EVALUATIONS, JACOBIANS, STATE_EVENTS, TIME_EVENTS, STEP_EVENTS, COUNTERS };

typedef enum {
    NO_TROUBLE,
    FUNCTION_FAILED,     /* `function` returned `status` at time t */
    NOT_FINITE,          /* the rate of `state`, whatever the step */
    STEP_TOO_SMALL,      /* `h`; the largest error is in `state` */
    SINGULAR,            /* the equations of a step's stages, whatever the step */
    NO_PROGRESS,         /* the last steps have covered `h`; the largest error is in `state` */
    EVENTS_WITHOUT_END,  /* at one instant */
    UPDATES_WITHOUT_END, /* of the discrete states */
    EVENT_IN_THE_PAST,   /* `value` is announced for the next one */
    WANTS_TO_END
} TroubleKind;

typedef struct {
    double t, h, value;
    int32_t kind, function, status, state;
} Trouble;

/* All that determines the future but the FMU and the arrays. */
typedef struct {
    double now;        /* where the FMU is */
    double front;      /* where the solver's last step ends */
    double next;       /* the event that the FMU has announced, infinite if none */
    double last_event; /* when it was */
    double t, h;       /* the solver's last step; it ends before t + h if a root has ended it */
    double tolerance;
    double stop;       /* no step goes beyond; infinite if that is not known */
    double longest;    /* step of the solver */
    StepControl control;
    int64_t repeated;  /* events at one instant */
    double watched;    /* from when on it is watched whether the steps get anywhere, after how many */
    int64_t attempts, events;
    int64_t counts[COUNTERS];
    int32_t initialized, in_event_mode;
    int32_t dirty;     /* its discrete states are to be updated */
    int32_t open;      /* the last step is not accepted yet */
    int32_t at_root;   /* it has ended at a root */
    int32_t placed;    /* the FMU is at the front, as the solver has it */
    int32_t rated;     /* and the rates there are known */
    int32_t moved;     /* an event has given states new values, and what was known of the step size is in doubt */
    int32_t renominal; /* nominal values are to be asked for */
    int32_t mistrusted; /* more rates depend on more states than the FMU's description says */
} Moment;

typedef struct {
    Known fmu;
    Moment m;
    Trouble trouble;
    size_t n_kept;      /* doubles that determine the future, too: those of the next line */
    double *kept;
    double *x;          /* states at the front */
    double *f;          /* their rates there, if rated */
    double *nominal;
    double *start, *end, *dense[RODAS_DENSE]; /* the solver's last step */
    double *was;        /* the states since it is watched whether the steps get anywhere */
    double *side;       /* of zero each indicator is since the last event: 1, -1, or 0 while that is not known */
    /* Scratch, of no meaning between two calls. */
    double *K[RODAS_STAGES], *J, *W, *f_t, *trial, *rates, *seed, *gain;
    double *looks;
    ValueReference *seeded;
    int32_t *moving, *alone;
    int *pivots;
    double until;       /* where the step that is tried ends */
    int worst;          /* state with the largest share of the error */
    bool no_return;     /* nobody will go back to a state of before the step */
} Exchange;

typedef enum { ANSWERED, DISCARDED, ENDED } Answer; /* of the FMU: a shorter step may help, or nothing does */

#endif
