/* SPDX-License-Identifier: MIT-0
 *
 * RODAS5P: a Rosenbrock method of order 5(4) for M dv/dt = f(t, v) with M = diag(1..1, 0..0), index 1. It is L-stable
 * and stiffly accurate, needs no Newton iteration, and has a dense output of order 4.
 */
#ifndef COSIM_RODAS_H
#define COSIM_RODAS_H

#include "model.h"
#include "rodas_table.h"
#include "step_control.h"

/* What does not change during a step. */
typedef struct {
    const double *u, *p, *d, *c;
} Held;

/* A step from t to t + h: its beginning, its end, and the dense output between them. */
typedef struct {
    double t, h;
    double v[MODEL_ROOM(MODEL_NV)];
    double v_new[MODEL_ROOM(MODEL_NV)];
    double dense[RODAS_DENSE][MODEL_ROOM(MODEL_NV)];
} RodasStep;

/* The stages' linear system (M / (gamma h) - J) k = b, with the algebraic unknowns eliminated. They are eliminated once
 * per step, since their part of the matrix does not depend on h. */
typedef struct {
    double xz[MODEL_ROOM(MODEL_NX * MODEL_NZ)]; /* df_x/dz */
    double zz[MODEL_ROOM(MODEL_NZ * MODEL_NZ)]; /* df_z/dz, prepared */
    double zx[MODEL_ROOM(MODEL_NZ * MODEL_NX)]; /* -dz/dx along f_z = 0: (df_z/dz)^-1 df_z/dx */
    double xx[MODEL_ROOM(MODEL_NX * MODEL_NX)]; /* df_x/dx along f_z = 0, the Jacobian of the state space form */
    double W[MODEL_ROOM(MODEL_NX * MODEL_NX)];  /* I / (gamma h) - xx, prepared */
    int pivots_z[MODEL_ROOM(MODEL_NZ)];
    int pivots_x[MODEL_ROOM(MODEL_NX)];
} StageSystem;

/* A step and what it is made with. */
typedef struct {
    RodasStep step;
    double f[MODEL_ROOM(MODEL_NV)];
    double f_t[MODEL_ROOM(MODEL_NV)];
    double J[MODEL_ROOM(MODEL_NV * MODEL_NV)];
    StageSystem system;
    double K[RODAS_STAGES][MODEL_ROOM(MODEL_NV)];
    int worst; /* unknown with the largest share of the error, or without a pivot */
} Rodas;

/* Evaluate f, its Jacobian and its time derivative at the beginning of a step. Returns 0 if the algebraic equations are
 * singular there. */
int rodas_begin(Rodas *r, double t, const double *v, const Held *held);

/* Try the step h; may be repeated. Returns the error, at most 1 if acceptable, infinite if f is not a number. */
double rodas_attempt(Rodas *r, double h, double tolerance, const Held *held);

/* The solution at t + theta h, 0 <= theta <= 1; exact at the ends. */
void rodas_dense(const RodasStep *step, double theta, double *v);

/* x = (df_z/dz)^-1 b where rodas_begin was called, and how fast the algebraic unknowns change with time, the states held. */
void rodas_solve_algebraic(const Rodas *r, const double *b, double *x);
void rodas_algebraic_rates(const Rodas *r, double *dz_dt);

/* A careful first step from where rodas_begin was called. */
double rodas_first_step(const Rodas *r, double tolerance);

#endif
