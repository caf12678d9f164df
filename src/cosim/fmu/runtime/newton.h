/* SPDX-License-Identifier: MIT-0
 *
 * Damped Newton iteration to full double accuracy, for the algebraic equations and for initialisation.
 */
#ifndef COSIM_NEWTON_H
#define COSIM_NEWTON_H

#include "model.h"

/* Compute the residuals r(y) and, unless J is NULL, the Jacobian (column-major). */
typedef void (*NewtonSystem)(void *context, const double *y, double *r, double *J);

typedef enum { NEWTON_SOLVED, NEWTON_SINGULAR, NEWTON_DIVERGED } NewtonOutcome;

/* Room for up to MODEL_NV unknowns; after a failure r holds the residuals at y, worst the unknown to blame. */
typedef struct {
    double r[MODEL_ROOM(MODEL_NV)];
    double step[MODEL_ROOM(MODEL_NV)];
    double next[MODEL_ROOM(MODEL_NV)];
    double trial[MODEL_ROOM(MODEL_NV)];
    double J[MODEL_ROOM(MODEL_NV * MODEL_NV)];
    int pivots[MODEL_ROOM(MODEL_NV)];
    int worst;
    int most_iterations; /* 0: as many as are of use */
} Newton;

/* Solve for the n values y, starting from y; nominal[i] is the size of y[i] that counts as one. */
NewtonOutcome newton_solve(Newton *w, int n, NewtonSystem system, void *context, const double *nominal, double *y);

#endif
