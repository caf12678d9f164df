/* SPDX-License-Identifier: MIT-0
 *
 * What the runtime needs to know of one compiled model.
 *
 * The compiler writes "model_sizes.h" (the MODEL_* sizes) and "model.c" (everything declared here); the runtime is the
 * same for every model. All quantities are SI and all are stored as double, whatever their Modelica type: Boolean as
 * 0/1, Integer and enumeration as their value.
 *
 * The continuous unknowns are v = [x; z]: MODEL_NX states, then MODEL_NZ implicit (torn) unknowns, which satisfy
 *
 *     dx/dt = f_x(t, v, u, p, d, c),     0 = f_z(t, v, u, p, d, c),     det(df_z/dz) != 0 (index 1).
 *
 * d are the discrete variables and c the truth values of the relations; both change at events only.
 */
#ifndef COSIM_MODEL_H
#define COSIM_MODEL_H

#include "model_sizes.h" /* MODEL_NX NZ NU NP ND NG NS NY NL NA NE NVARIABLES, MODEL_TOKEN, MODEL_NAME */

/* 1 if the model is discrete and nothing changes but when a sample clock ticks: one pass settles an event. */
#ifndef MODEL_ALL_CLOCKED
#define MODEL_ALL_CLOCKED 0
#endif

/* 1 if there are relations of time alone: model_relation_slope is not always 0. */
#ifndef MODEL_HAS_TIME_RELATIONS
#define MODEL_HAS_TIME_RELATIONS 0
#endif

/* The sample clock that ticks once, when the simulation ends: terminal(). */
#ifndef MODEL_TERMINAL
#define MODEL_TERMINAL (-1)
#endif

/* 1 if there is a model_sweep: the blocks of the algebraic equations are small enough for a closed form. */
#ifndef MODEL_HAS_SWEEP
#define MODEL_HAS_SWEEP 0
#endif

/* 1 if steps have the fixed length MODEL_FIXED_STEP [s], and the work in each is bounded. */
#ifndef MODEL_HAS_FIXED_STEP
#define MODEL_HAS_FIXED_STEP 0
#endif

/* 1 if there are the functions of directional and adjoint derivatives. */
#ifndef MODEL_HAS_DERIVATIVES
#define MODEL_HAS_DERIVATIVES 0
#endif

#define MODEL_NV (MODEL_NX + MODEL_NZ)
/* C has no arrays of length zero. */
#define MODEL_ROOM(n) ((n) > 0 ? (n) : 1)

/* For functions that are to be small rather than fast. */
#if defined(__clang__)
#define MODEL_COLD __attribute__((cold, minsize))
#elif defined(__GNUC__)
#define MODEL_COLD __attribute__((cold))
#else
#define MODEL_COLD
#endif

/* Where the value of a variable lives. */
typedef enum {
    STORE_TIME,       /* the independent variable */
    STORE_UNKNOWN,    /* v[index] */
    STORE_DERIVATIVE, /* dx/dt [index] */
    STORE_INPUT,      /* u[index] */
    STORE_PARAMETER,  /* p[index] */
    STORE_DISCRETE,   /* d[index] */
    STORE_OUTPUT,     /* model_outputs, y[index] */
    STORE_LOCAL,      /* model_locals, l[index] */
    STORE_INDICATOR,  /* the event indicator of relation `index` */
    STORE_COUNTER     /* what the solver has done so far: a ModelCounter, read as UInt64 */
} ModelStore;

/* FMI types, in this order: Float64, Int32, Boolean, Int64, UInt64 (for STORE_COUNTER only). */
typedef enum { TYPE_REAL, TYPE_INTEGER, TYPE_BOOLEAN, TYPE_ENUMERATION, TYPE_COUNTER } ModelType;

/* Indices of STORE_COUNTER. */
typedef enum {
    COUNTER_STEPS,      /* accepted steps */
    COUNTER_REJECTED,   /* rejected steps */
    COUNTER_RHS,        /* evaluations of the equations, whole or their algebraic part */
    COUNTER_JACOBIANS,  /* and of their derivatives */
    COUNTER_STATE_EVENTS,
    COUNTER_TIME_EVENTS, /* instants known beforehand: a sample clock ticked, or a relation of time changed */
    COUNTERS             /* how many there are */
} ModelCounter;

/* When an importer may set a variable. */
typedef enum {
    SET_NEVER,
    SET_BEFORE_INITIALIZATION_ENDS, /* fixed parameters, start values */
    SET_ALWAYS                      /* inputs and tunable parameters */
} ModelSettable;

typedef struct {
    unsigned char store;    /* ModelStore */
    unsigned char type;     /* ModelType */
    unsigned char settable; /* ModelSettable */
    unsigned index;         /* within its store */
} ModelVariable;

/* One entry per value reference: the value reference is the position. */
extern const ModelVariable model_variables[MODEL_ROOM(MODEL_NVARIABLES)];

/* Start values of what an importer may set. */
extern const double model_start_inputs[MODEL_ROOM(MODEL_NU)];
extern const double model_start_parameters[MODEL_ROOM(MODEL_NP)]; /* dependent ones: overwritten by model_parameters */

/* Sizes of the unknowns that count as "one" for absolute tolerances, and names for messages. */
extern const double model_nominal[MODEL_ROOM(MODEL_NV)];
extern const char *const model_unknown_names[MODEL_ROOM(MODEL_NV)];
extern const char *const model_discrete_names[MODEL_ROOM(MODEL_ND)];

/* Relation k is true where g[k] > 0 (strict) or g[k] >= 0 (not strict); the text is the Modelica source of it. */
extern const unsigned char model_relation_strict[MODEL_ROOM(MODEL_NG)];
/* dg[k]/dt where nothing in g[k] but time moves between events, at this constant rate; 0 elsewhere. */
#if MODEL_HAS_TIME_RELATIONS
extern const double model_relation_slope[MODEL_ROOM(MODEL_NG)];
#define RELATION_SLOPE(index) (model_relation_slope[index])
#else
#define RELATION_SLOPE(index) ((void)(index), 0.0)
#endif
extern const char *const model_relation_texts[MODEL_ROOM(MODEL_NG)];

/* Assertions: message, and whether a violation ends the simulation (else it is a warning). */
extern const char *const model_assertion_messages[MODEL_ROOM(MODEL_NA)];
extern const unsigned char model_assertion_is_error[MODEL_ROOM(MODEL_NA)];

/* What the model says when it calls terminate(). */
extern const char *const model_termination_messages[MODEL_ROOM(MODEL_NE)];

/* Equations of the initial system, in Modelica text, for messages. */
extern const char *const model_initial_texts[MODEL_ROOM(MODEL_NV)];

/* 1 for unknowns whose initial equation is that they have their start value. */
extern const unsigned char model_start_kept[MODEL_ROOM(MODEL_NV)];

/* Compute the dependent parameters from the independent ones, in place. */
void model_parameters(double *p);

/* Start values: fixed ones and guesses alike, for v and d. */
void model_start(const double *p, double *v, double *d);

/* Sample clocks: tick k of clock s is at start[s] + k * interval[s], k = 0, 1, ...; both infinite for MODEL_TERMINAL. */
void model_clocks(const double *p, double *start, double *interval);

#define MODEL_CONTINUOUS_ARGUMENTS \
    double t, const double *v, const double *u, const double *p, const double *d, const double *c

/* f[0..NX) = dx/dt, f[NX..NV) = residual of the algebraic equations. */
void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f);

/* f as model_rhs gives it, J[column * NV + row] = df[row]/dv[column], and ft = df/dt at constant v, u, p, d, c: at once,
 * since they share most of the work. Every entry is written. */
void model_linearise(MODEL_CONTINUOUS_ARGUMENTS, double *f, double *J, double *ft);

/* The algebraic equations alone: r = f_z, and J[column * NZ + row] = df_z[row]/dz[column]. */
void model_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r);
void model_linearise_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r, double *J);

/* Indicators of the relations; these do not depend on c's own entries for the same relation. */
void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g);

/* Initial system r(v) = 0 of MODEL_NV equations, solved for v at the start time, and its Jacobian (column-major). */
void model_initial_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r);
void model_initial_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J);

/* Outputs (y) and all other published variables that have no store of their own (l). */
void model_outputs(MODEL_CONTINUOUS_ARGUMENTS, double *y);
void model_locals(MODEL_CONTINUOUS_ARGUMENTS, double *l);

#if MODEL_HAS_SWEEP
/* One Newton step for each block of the algebraic equations in turn: dz, what it adds to z, and the outputs for z + dz.
 * Converges quadratically; entries are not finite where a block is singular. */
void model_sweep(MODEL_CONTINUOUS_ARGUMENTS, double *dz, double *y);
#endif

#if MODEL_HAS_DERIVATIVES
/* Forward: with its arguments at these rates (x_dot), the rates of f and y. p, d and c keep their values. */
void model_forward(MODEL_CONTINUOUS_ARGUMENTS, double t_dot, const double *v_dot, const double *u_dot, double *f_dot,
                   double *y_dot);
/* In reverse: with weights of f and y (x_bar), the weights of the arguments: what the transposed derivatives give. */
void model_reverse(MODEL_CONTINUOUS_ARGUMENTS, const double *f_bar, const double *y_bar, double *t_bar, double *v_bar,
                   double *u_bar, double *p_bar);
/* The same for the residuals of the initial system at constant v; model_initial_jacobian has their derivatives by v. */
void model_initial_reverse(MODEL_CONTINUOUS_ARGUMENTS, const double *r_bar, double *t_bar, double *u_bar,
                           double *p_bar);
/* The weights of the independent parameters from those of all; 0 for dependent ones. */
void model_parameters_reverse(const double *p, const double *p_bar, double *free_bar);
#endif

/* Index of the first violated assertion, or -1. Errors must come before warnings: a lasting warning would hide them. */
int model_violated_assertion(MODEL_CONTINUOUS_ARGUMENTS);

#define MODEL_NOT_A_NUMBER (-1)

/* One pass over the discrete equations at an event.
 *
 * pre   values of d before this pass (Modelica's pre()); of a model with MODEL_ALL_CLOCKED, d_new may be the same array
 * fired 1 for each sample clock that ticks in this pass
 * d_new the discrete variables: pre when called, then the new values
 * x_new the states: those of v when called, then with reinit() applied
 * Returns k + 1 if terminate() was called with message k, MODEL_NOT_A_NUMBER if a value it assigned is none, else 0. */
int model_discrete(MODEL_CONTINUOUS_ARGUMENTS, const double *pre, const double *fired, int initial, double *d_new,
                   double *x_new);

/* The constraints that the choice of states rests on. For each set, a matrix with `rows` rows and `columns` columns:
 * its first `rows` columns must be regular, for what is not a state is computed from what is. Rows stand in block lower
 * triangular order. The numbers of all sets' matrix entries that are not always zero are computed together. */
#ifndef MODEL_NCONSTRAINTS
#define MODEL_NCONSTRAINTS 0
#endif
#if MODEL_NCONSTRAINTS > 0
typedef struct {
    int rows, columns, entries; /* of this set; its own begin in the tables where those of the sets before it end */
} ModelConstraints;
extern const ModelConstraints model_constraints[MODEL_NCONSTRAINTS];
extern const unsigned short model_constraint_row[MODEL_CONSTRAINT_ENTRIES];
extern const unsigned short model_constraint_column[MODEL_CONSTRAINT_ENTRIES];
extern const unsigned short model_constraint_block[MODEL_CONSTRAINT_ROWS];
extern const char *const model_constraint_texts[MODEL_CONSTRAINT_ROWS];      /* for each row, its equation */
extern const char *const model_constraint_variables[MODEL_CONSTRAINT_COLUMNS]; /* for each column, the states it is for */
void model_constraint_entries(MODEL_CONTINUOUS_ARGUMENTS, double *entries);
#endif

#endif
