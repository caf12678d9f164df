/* SPDX-License-Identifier: Apache-2.0
 *
 * Model Exchange: a step of RODAS5P for dx/dt = f(t, x), as the solver of this project's FMUs takes it
 * (cosim/fmu/runtime/rodas.c), with whatever f an FMU has.
 */
#include <float.h>
#include <string.h>

#include "exchange.h"
#include "lu.h"

/* Of a step in a difference quotient: it errs by as much in rounding as in curvature. */
#define SMALL_STEP 1.5e-8
#define CHECKED 64 /* Jacobians, of which one is made without believing what the FMU's description says */

/* The part of the Jacobian that the states of one colour make: those that no rate depends on together. */
static Answer differentiate(Exchange *x, const int32_t *owners, double sign) {
    const int n = (int)x->fmu.n_states;
    for (int j = 0; j < n; j++) x->seed[j] = 0.0;
    memcpy(x->trial, x->start, (size_t)n * sizeof(double));
    for (int i = 0; i < n; i++) {
        const int j = owners[i];
        if (j < 0 || x->seed[j] != 0.0) continue;
        x->trial[j] += sign * SMALL_STEP * (fabs(x->start[j]) + x->nominal[j]);
        x->seed[j] = x->trial[j] - x->start[j];
    }
    const Answer answer = rates_at(x, x->m.t, x->trial, x->rates);
    if (answer != ANSWERED) return answer;
    for (int i = 0; i < n; i++) {
        if (owners[i] >= 0) x->J[owners[i] * n + i] = (x->rates[i] - x->f[i]) / x->seed[owners[i]];
    }
    return ANSWERED;
}

static Answer ask_for_derivatives(Exchange *x, const int32_t *owners) {
    const int n = (int)x->fmu.n_states;
    size_t n_seeded = 0;
    for (int j = 0; j < n; j++) x->moving[j] = false;
    for (int i = 0; i < n; i++) {
        const int j = owners[i];
        if (j < 0 || x->moving[j]) continue;
        x->moving[j] = true;
        x->seeded[n_seeded] = x->fmu.states[j];
        x->seed[n_seeded++] = 1.0;
    }
    if (n_seeded == 0) return ANSWERED;
    const Answer answer = gain_along(x, n_seeded);
    if (answer != ANSWERED) return answer;
    for (int i = 0; i < n; i++) {
        if (owners[i] >= 0) x->J[owners[i] * n + i] = x->gain[i];
    }
    return ANSWERED;
}

/* By a difference of second order, forwards if there is time left: an FMU need not go back beyond an event. Stiffness
 * makes much of an error here, so that a difference of first order would not do for tight tolerances. */
static Answer differentiate_by_time(Exchange *x) {
    const int n = (int)x->fmu.n_states;
    const double noise = 1e-9, limit = fmin(x->m.next, x->m.stop), t = x->m.t;
    const double unit = fmax(1.0, fabs(t));
    const double size = x->m.control.h > 0.0 ? fmax(1e-4 * x->m.control.h, 1e-14 * unit) : SMALL_STEP * unit;
    const double h = (t + 2.0 * size <= limit ? size : -size), t1 = t + h, t2 = t + 2.0 * h;
    const double h1 = t1 - t, h2 = t2 - t; /* as they are in floating point */
    Answer answer = rates_at(x, t1, x->start, x->rates);
    if (answer == ANSWERED) answer = rates_at(x, t2, x->start, x->trial);
    if (answer != ANSWERED) return answer;
    for (int i = 0; i < n; i++) {
        const double slope1 = (x->rates[i] - x->f[i]) / h1, slope2 = (x->trial[i] - x->f[i]) / h2;
        x->f_t[i] = slope1 + (slope1 - slope2) * h1 / (h2 - h1);
        if (x->fmu.autonomous && fabs(x->rates[i] - x->f[i]) > noise * fabs(x->f[i])) x->m.mistrusted = true;
    }
    return ANSWERED;
}

static Answer add_colour(Exchange *x, const int32_t *owners) {
    if (x->fmu.states) return ask_for_derivatives(x, owners);
    const Answer answer = differentiate(x, owners, 1.0);
    return answer == DISCARDED ? differentiate(x, owners, -1.0) : answer;
}

static bool is_claimed(const Exchange *x, int rate, int state) {
    for (int64_t colour = 0; colour < x->fmu.n_colours; colour++) {
        if (x->fmu.owners[colour * x->fmu.n_states + rate] == state) return true;
    }
    return false;
}

/* Whether the Jacobian has entries only where the FMU's description says so. Not all do. */
static bool is_as_claimed(const Exchange *x) {
    const double noise = 1e-5;
    const int n = (int)x->fmu.n_states;
    for (int i = 0; i < n; i++) {
        double largest = 0.0;
        for (int j = 0; j < n; j++) largest = fmax(largest, fabs(x->J[j * n + i]) * x->nominal[j]);
        for (int j = 0; j < n; j++) {
            if (fabs(x->J[j * n + i]) * x->nominal[j] > noise * largest && !is_claimed(x, i, j)) return false;
        }
    }
    return true;
}

/* Each state by itself. */
static Answer add_all(Exchange *x) {
    const int n = (int)x->fmu.n_states;
    Answer answer = ANSWERED;
    for (int j = 0; j < n && answer == ANSWERED; j++) {
        for (int i = 0; i < n; i++) x->alone[i] = j;
        answer = add_colour(x, x->alone);
    }
    return answer;
}

/* The Jacobian and the derivative by time at the beginning of a step, where the FMU is. The states are taken by
 * colours, now and then by themselves, to see whether that is right. */
static Answer linearise(Exchange *x) {
    const int n = (int)x->fmu.n_states;
    Answer answer = ANSWERED;
    const bool coloured = x->fmu.n_colours < n && !x->m.mistrusted, checking = x->m.counts[JACOBIANS]++ % CHECKED == 0;
    memset(x->J, 0, (size_t)(n * n) * sizeof(double));
    if (coloured && !checking) {
        for (int64_t colour = 0; colour < x->fmu.n_colours && answer == ANSWERED; colour++) {
            answer = add_colour(x, x->fmu.owners + colour * n);
        }
    } else {
        answer = add_all(x);
        if (coloured && answer == ANSWERED) x->m.mistrusted = !is_as_claimed(x);
    }
    for (int i = 0; i < n; i++) x->f_t[i] = 0.0;
    if (answer != ANSWERED || (x->fmu.autonomous && !x->m.mistrusted && !checking)) return answer;
    return differentiate_by_time(x);
}

/* Evaluate at the front all that does not depend on the length of the step that begins there. */
static Answer begin_step(Exchange *x) {
    Moment *m = &x->m;
    Answer answer = ANSWERED;
    if (!m->placed) answer = put(x, m->front, x->x);
    if (answer == ANSWERED && !m->rated) answer = rates_here(x, x->f);
    m->t = m->front;
    memcpy(x->start, x->x, (size_t)x->fmu.n_states * sizeof(double));
    return answer == ANSWERED ? linearise(x) : answer;
}

/* The solution at t + theta h, 0 <= theta <= 1; exact at the ends. */
static void interpolate(const Exchange *x, double theta, double *states) {
    const double rest = 1.0 - theta;
    for (int i = 0; i < (int)x->fmu.n_states; i++) {
        const double bend = x->dense[0][i] + theta * (x->dense[1][i] + theta * x->dense[2][i]);
        states[i] = x->start[i] * rest + theta * (x->end[i] + rest * bend);
    }
}

/* The largest of these errors relative to the tolerance; infinite if one is not a number. */
static double norm_of(Exchange *x, const double *error) {
    double largest = 0.0;
    for (int i = 0; i < (int)x->fmu.n_states; i++) {
        const double size = x->nominal[i] + fmax(fabs(x->start[i]), fabs(x->end[i]));
        const double ratio = fabs(error[i]) / (x->m.tolerance * size);
        if (!(ratio <= largest)) {
            largest = ratio;
            x->worst = i;
            if (!isfinite(ratio)) return INFINITY;
        }
    }
    return largest;
}

/* How far the dense output is from satisfying the equations where no stage looks, as in the FMUs' solver. */
static Answer defect(Exchange *x, double h, double *error) {
    static const double at = 0.2;
    static const double slopes[RODAS_DENSE] = {1.0 - 2.0 * 0.2, 2.0 * 0.2 - 3.0 * 0.04, 3.0 * 0.04 - 4.0 * 0.008};
    const int n = (int)x->fmu.n_states;
    interpolate(x, at, x->trial);
    const Answer answer = rates_at(x, x->m.t + at * h, x->trial, x->rates);
    if (answer != ANSWERED) return answer;
    for (int i = 0; i < n; i++) {
        double slope = x->end[i] - x->start[i];
        for (int k = 0; k < RODAS_DENSE; k++) slope += slopes[k] * x->dense[k][i];
        x->rates[i] = (x->rates[i] - slope / h) / RODAS_GAMMA;
    }
    lu_apply(n, x->W, x->pivots, x->rates, x->trial);
    *error = norm_of(x, x->trial);
    return ANSWERED;
}

/* K[stage] from the rates of that stage, which are spent. */
static void solve_stage(Exchange *x, int stage, double h, double *rates) {
    const int n = (int)x->fmu.n_states;
    for (int i = 0; i < n; i++) rates[i] += h * RODAS_D[stage] * x->f_t[i];
    for (int j = 0; j < stage; j++) {
        const double factor = RODAS_C[stage][j] / h;
        for (int i = 0; i < n; i++) rates[i] += factor * x->K[j][i];
    }
    lu_apply(n, x->W, x->pivots, rates, x->K[stage]);
}

static Answer factorise(Exchange *x, double h) {
    const int n = (int)x->fmu.n_states;
    for (int i = 0; i < n * n; i++) x->W[i] = -x->J[i];
    for (int i = 0; i < n; i++) x->W[i * n + i] += 1.0 / (RODAS_GAMMA * h);
    const int singular = lu_prepare(n, x->W, x->pivots);
    if (!singular) return ANSWERED;
    fail_with(x, SINGULAR);
    x->trouble.state = singular - 1;
    return DISCARDED;
}

/* Try the step h; may be repeated. The error is at most 1 if acceptable. */
static Answer attempt_step(Exchange *x, double h, double *error) {
    const int n = (int)x->fmu.n_states;
    const size_t size = (size_t)n * sizeof(double);
    x->m.h = h;
    *error = INFINITY;
    Answer answer = factorise(x, h);
    if (answer != ANSWERED) return answer;
    memcpy(x->rates, x->f, size);
    solve_stage(x, 0, h, x->rates);
    for (int stage = 1; stage < RODAS_STAGES; stage++) {
        if (stage < 6) {
            memcpy(x->end, x->start, size);
            for (int j = 0; j < stage; j++) {
                for (int i = 0; i < n; i++) x->end[i] += RODAS_A[stage][j] * x->K[j][i];
            }
        } else {
            for (int i = 0; i < n; i++) x->end[i] += x->K[stage - 1][i];
        }
        for (int i = 0; i < n; i++) {
            x->worst = i;
            if (!isfinite(x->end[i])) return ANSWERED; /* with an error beyond all bounds */
        }
        answer = rates_at(x, stage < 5 ? x->m.t + RODAS_ALPHA[stage] * h : x->until, x->end, x->rates);
        if (answer != ANSWERED) return answer;
        solve_stage(x, stage, h, x->rates);
    }
    for (int i = 0; i < n; i++) x->end[i] += x->K[RODAS_STAGES - 1][i];
    *error = norm_of(x, x->K[RODAS_STAGES - 1]);
    if (*error > 1.0) return ANSWERED;
    for (int k = 0; k < RODAS_DENSE; k++) {
        for (int i = 0; i < n; i++) {
            x->dense[k][i] = 0.0;
            for (int j = 0; j < RODAS_STAGES; j++) x->dense[k][i] += RODAS_BEND[k][j] * x->K[j][i];
        }
    }
    double between = 0.0;
    answer = defect(x, h, &between);
    *error = fmax(*error, between);
    return answer;
}

/* The local error is of order h^5 in units of the time in which the fastest state changes by its own size. */
static double first_step(const Exchange *x) {
    double rate = 0.0;
    for (int i = 0; i < (int)x->fmu.n_states; i++) {
        rate = fmax(rate, fabs(x->f[i]) / (fabs(x->start[i]) + x->nominal[i]));
    }
    const double h = 0.5 * pow(x->m.tolerance, 0.2) / rate;
    return fmax(isfinite(h) ? h : 1e-6, 1e-12 * fmax(1.0, fabs(x->m.t)));
}
