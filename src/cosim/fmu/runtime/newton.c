/* SPDX-License-Identifier: MIT-0
 *
 * The step is damped until it makes progress by one of two measures: the next simplified Newton correction is shorter
 * (Deuflhard's natural monotonicity test, which does not depend on how the equations are scaled), or the residuals are
 * smaller (which gets past points where the Jacobian is nearly singular, and corrections therefore are long).
 */
#include "newton.h"

#include <math.h>
#include <string.h>

#include "lu.h"

enum { MAX_ITERATIONS = 100 };
static const double SHORTEST_STEP = 1e-9;
/* Relative to the unknowns: an angle must not be thrown over several turns from a nearly singular point, and a solution
 * that is larger than its nominal value is still reached in few iterations, since the step grows with the unknown. */
static const double LONGEST_STEP = 1.0;
static const double CONVERGED = 1e-12; /* the last correction still gets applied, so the result is better than this */
static const double QUADRATIC = 1e-7;  /* a full step this short leaves an error of the order of its square */
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

static double residual_norm(const Newton *w, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += w->r[i] * w->r[i];
    return sqrt(sum);
}

static void correction(Newton *w, int n, double *result)
{
    for (int i = 0; i < n; i++) result[i] = -w->r[i];
    if (n == MODEL_NZ)
        lu_solve(MODEL_NZ, w->J, w->pivots, result);
    else
        lu_solve(n, w->J, w->pivots, result);
}

NewtonOutcome newton_solve(Newton *w, int n, NewtonSystem system, void *context, const double *nominal, double *y)
{
    if (n == 0) return NEWTON_SOLVED;
    int most = w->most_iterations > 0 ? w->most_iterations : MAX_ITERATIONS;
    for (int iteration = 0; iteration < most; iteration++) {
        system(context, y, w->r, w->J);
        /* The algebraic equations are solved for every published row: let the compiler know their number. */
        int singular =
            n == MODEL_NZ ? lu_factor(MODEL_NZ, w->J, w->pivots) : lu_factor(n, w->J, w->pivots);
        if (singular) {
            w->worst = singular - 1;
            return NEWTON_SINGULAR;
        }
        double residual = residual_norm(w, n);
        correction(w, n, w->step);
        double length = size(w, n, w->step, y, nominal);
        if (!isfinite(length)) return NEWTON_DIVERGED;
        if (length <= QUADRATIC) {
            for (int i = 0; i < n; i++) y[i] += w->step[i];
            return NEWTON_SOLVED;
        }

        double damping = fmin(1.0, LONGEST_STEP / length), next;
        for (;;) {
            for (int i = 0; i < n; i++) w->trial[i] = y[i] + damping * w->step[i];
            system(context, w->trial, w->r, NULL);
            correction(w, n, w->next);
            next = size(w, n, w->next, w->trial, nominal);
            double less = 1.0 - damping / 4.0;
            if (next <= less * length || next <= CONVERGED) break;
            if (length > STAGNATED && residual_norm(w, n) <= less * residual) break;
            if (length <= STAGNATED && next <= STAGNATED) return NEWTON_SOLVED;
            damping *= 0.5;
            if (damping * length < SHORTEST_STEP) {
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
