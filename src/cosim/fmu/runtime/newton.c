/* SPDX-License-Identifier: MIT-0
 *
 * The step is damped by Deuflhard's natural monotonicity test: the next simplified Newton correction must be shorter
 * than this one. Unlike a test on the residuals it does not depend on how the equations are scaled.
 */
#include "newton.h"

#include <math.h>
#include <string.h>

#include "lu.h"

enum { MAX_ITERATIONS = 50 };
static const double SMALLEST_DAMPING = 1e-6;
static const double CONVERGED = 1e-12; /* the last correction still gets applied, so the result is better than this */
static const double STAGNATED = 1e-8;  /* corrections this small that no longer shrink are rounding errors */

/* Largest correction relative to the unknowns; NaN if any of them is. */
static double size(Newton *w, int n, const double *correction, const double *y, const double *nominal)
{
    double largest = 0.0;
    for (int i = 0; i < n; i++) {
        double ratio = fabs(correction[i]) / (fabs(y[i]) + nominal[i]);
        if (!(ratio <= largest)) {
            largest = ratio;
            w->worst = i;
            if (isnan(ratio)) break;
        }
    }
    return largest;
}

static void correction(Newton *w, int n, double *result)
{
    for (int i = 0; i < n; i++) result[i] = -w->r[i];
    lu_solve(n, w->J, w->pivots, result);
}

NewtonOutcome newton_solve(Newton *w, int n, NewtonSystem system, void *context, const double *nominal, double *y)
{
    if (n == 0) return NEWTON_SOLVED;
    for (int iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
        system(context, y, w->r, w->J);
        int singular = lu_factor(n, w->J, w->pivots);
        if (singular) {
            w->worst = singular - 1;
            return NEWTON_SINGULAR;
        }
        correction(w, n, w->step);
        double length = size(w, n, w->step, y, nominal);
        if (!isfinite(length)) return NEWTON_DIVERGED;
        if (length == 0.0) return NEWTON_SOLVED;

        double damping = 1.0, next;
        for (;;) {
            for (int i = 0; i < n; i++) w->trial[i] = y[i] + damping * w->step[i];
            system(context, w->trial, w->r, NULL);
            correction(w, n, w->next);
            next = size(w, n, w->next, w->trial, nominal);
            if (next <= (1.0 - damping / 4.0) * length || next <= CONVERGED) break;
            if (length <= STAGNATED && next <= STAGNATED) return NEWTON_SOLVED;
            damping *= 0.5;
            if (damping < SMALLEST_DAMPING) {
                system(context, y, w->r, NULL);
                (void)size(w, n, w->step, y, nominal);
                return NEWTON_DIVERGED;
            }
        }
        memcpy(y, w->trial, (size_t)n * sizeof *y);
        if (next <= CONVERGED) {
            for (int i = 0; i < n; i++) y[i] += w->next[i];
            return NEWTON_SOLVED;
        }
    }
    return NEWTON_DIVERGED;
}
