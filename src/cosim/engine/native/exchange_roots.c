/* SPDX-License-Identifier: Apache-2.0
 *
 * Model Exchange: where in a step of the solver the first event indicator changes its side of zero, z > 0 or z <= 0. As
 * in the FMUs' own solver (cosim/fmu/runtime/locate.c), but the FMU has to be put to each point that is looked at.
 */
#include <float.h>
#include <string.h>

#include "cubic.h"
#include "exchange.h"

#define MOST_NARROWINGS 200
static const double LOOK_AT[CUBIC_POINTS] = {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0};

/* Indicators at t + theta h. */
typedef struct {
    double theta, *z;
} Look;

/* The places for them: the points of the cubic, then these. */
enum { EARLIEST = CUBIC_POINTS, BEFORE, AFTER, MIDDLE, LOOKS };

static Look look_at(const Exchange *x, int which, double theta) {
    return (Look){theta, x->looks + which * x->fmu.n_indicators};
}

static void take_over(const Exchange *x, Look *to, const Look *from) {
    to->theta = from->theta;
    memcpy(to->z, from->z, (size_t)x->fmu.n_indicators * sizeof(double));
}

static Answer look_there(Exchange *x, const Look *at) {
    const bool ends = at->theta == 1.0;
    if (!ends) interpolate(x, at->theta, x->trial);
    const Answer answer = put(x, ends ? x->until : x->m.t + at->theta * x->m.h, ends ? x->end : x->trial);
    return answer == ANSWERED ? indicators_here(x, at->z) : answer;
}

static bool has_changed(const Exchange *x, const Look *at, int64_t k) {
    return x->side[k] != 0.0 && (at->z[k] > 0.0) != (x->side[k] > 0.0);
}

static bool any_has_changed(const Exchange *x, const Look *at) {
    for (int64_t k = 0; k < x->fmu.n_indicators; k++) {
        if (has_changed(x, at, k)) return true;
    }
    return false;
}

/* An indicator that was zero, and that nothing moved away from it, is on the side to which it goes first. */
static void take_sides(Exchange *x, const Look *at) {
    for (int64_t k = 0; k < x->fmu.n_indicators; k++) {
        if (x->side[k] == 0.0 && at->z[k] != 0.0) x->side[k] = at->z[k] > 0.0 ? 1.0 : -1.0;
    }
}

/* The sides after an event, with the FMU at the front. FMI wants no indicator to be zero then; one that is so all the
 * same is on the side to which it is about to move. */
static Answer find_sides(Exchange *x) {
    const int n = (int)x->fmu.n_states;
    const Look here = look_at(x, 0, 0.0), there = look_at(x, MIDDLE, 0.0);
    bool undecided = false;
    if (x->fmu.n_indicators == 0) return ANSWERED;
    Answer answer = indicators_here(x, here.z);
    if (answer != ANSWERED) return answer;
    for (int64_t k = 0; k < x->fmu.n_indicators; k++) x->side[k] = 0.0;
    take_sides(x, &here);
    for (int64_t k = 0; k < x->fmu.n_indicators; k++) undecided |= x->side[k] == 0.0;
    if (!undecided) return ANSWERED;
    if (n > 0) answer = rates_here(x, x->f);
    if (answer != ANSWERED) return answer;
    x->m.rated = true;
    double rate = 0.0;
    for (int i = 0; i < n; i++) rate = fmax(rate, fabs(x->f[i]) / (fabs(x->x[i]) + x->nominal[i]));
    const double h = fmax(1e-12 * fmax(1.0, fabs(x->m.front)), fmin(1e-6, sqrt(DBL_EPSILON) / rate));
    for (int i = 0; i < n; i++) x->trial[i] = x->x[i] + h * x->f[i];
    answer = put(x, x->m.front + h, x->trial);
    if (answer == ANSWERED) answer = indicators_here(x, there.z);
    if (answer == ANSWERED) take_sides(x, &there);
    return answer == ENDED ? ENDED : ANSWERED; /* what cannot be evaluated there stays undecided */
}

/* An excursion that comes back between two points shows as an extremum of the cubic near zero. */
static Answer look_between(Exchange *x, const Look points[CUBIC_POINTS], Look *earliest) {
    for (int64_t k = 0; k < x->fmu.n_indicators; k++) {
        double z[CUBIC_POINTS], least = INFINITY, low = INFINITY, high = -INFINITY, at[2];
        for (int i = 0; i < CUBIC_POINTS; i++) {
            z[i] = points[i].z[k];
            least = fmin(least, fabs(z[i]));
            low = fmin(low, z[i]);
            high = fmax(high, z[i]);
        }
        if (!(least < high - low)) continue;
        const int n = cubic_extrema(z, at);
        for (int i = 0; i < n; i++) {
            const Look extremum = look_at(x, MIDDLE, at[i] / (CUBIC_POINTS - 1));
            if (extremum.theta >= earliest->theta) continue;
            const Answer answer = look_there(x, &extremum);
            if (answer != ANSWERED) return answer;
            if (any_has_changed(x, &extremum)) take_over(x, earliest, &extremum);
        }
    }
    return ANSWERED;
}

/* Where a secant has the first change, as a part of the way from before to after. */
static double guess_root(const Exchange *x, const Look *before, const Look *after, double weight_before,
                         double weight_after) {
    double fraction = 1.0;
    for (int64_t k = 0; k < x->fmu.n_indicators; k++) {
        if (!has_changed(x, after, k)) continue;
        const double left = weight_before * before->z[k], right = weight_after * after->z[k];
        const double root = left / (left - right);
        fraction = fmin(fraction, root >= 0.0 && root <= 1.0 ? root : 0.5);
    }
    return fraction;
}

/* Shrink (before, after) around the first change, by Illinois steps (Dowell and Jarratt, BIT 11, 1971) that are kept
 * inside by the accuracy sought, every fourth of them a bisection. */
static Answer narrow_down(Exchange *x, Look *before, Look *after) {
    const Look middle = look_at(x, MIDDLE, 0.0);
    double weight_before = 1.0, weight_after = 1.0;
    int moved = 0; /* the end that moved last: -1 before, 1 after */
    const double accuracy = fmax(1e-13, 8.0 * DBL_EPSILON * (fabs(x->m.t) + x->m.h)) / x->m.h;
    for (int i = 0; i < MOST_NARROWINGS && after->theta - before->theta > accuracy; i++) {
        const double fraction = i % 4 == 3 ? 0.5 : guess_root(x, before, after, weight_before, weight_after);
        const double width = after->theta - before->theta, margin = fmin(0.4 * accuracy, 0.5 * width);
        const Look tried = {before->theta + fmin(width - margin, fmax(margin, fraction * width)), middle.z};
        const Answer answer = look_there(x, &tried);
        if (answer != ANSWERED) return answer;
        if (any_has_changed(x, &tried)) {
            take_over(x, after, &tried);
            weight_after = 1.0;
            if (moved == 1) weight_before *= 0.5;
            moved = 1;
        } else {
            take_over(x, before, &tried);
            weight_before = 1.0;
            if (moved == -1) weight_after *= 0.5;
            moved = -1;
        }
    }
    return ANSWERED;
}

/* Look through a step that is acceptable. `theta` is where it ends, above 1 if no indicator changes; then the FMU is at
 * its end. */
static Answer find_root(Exchange *x, double *theta) {
    *theta = 2.0;
    if (x->fmu.n_indicators == 0) return put(x, x->until, x->end);
    Look points[CUBIC_POINTS];
    Look earliest = look_at(x, EARLIEST, 2.0), before = look_at(x, BEFORE, 0.0), after = look_at(x, AFTER, 0.0);
    for (int i = 0; i < CUBIC_POINTS; i++) {
        points[i] = look_at(x, i, LOOK_AT[i]);
        if (i == 0) continue; /* it is the last one of the step before */
        const Answer answer = look_there(x, &points[i]);
        if (answer != ANSWERED) return answer;
        take_sides(x, &points[i]);
        if (earliest.theta > 1.0 && any_has_changed(x, &points[i])) take_over(x, &earliest, &points[i]);
    }
    Answer answer = look_between(x, points, &earliest);
    if (answer != ANSWERED) return answer;
    if (earliest.theta > 1.0) return x->m.now == x->until ? ANSWERED : put(x, x->until, x->end);
    take_over(x, &after, &earliest);
    take_over(x, &before, &points[0]);
    for (int i = 1; i < CUBIC_POINTS && points[i].theta < after.theta; i++) {
        if (!any_has_changed(x, &points[i])) take_over(x, &before, &points[i]);
    }
    answer = narrow_down(x, &before, &after);
    *theta = after.theta;
    return answer;
}

/* The indicators at the end of an accepted step are those of the beginning of the next. */
static void keep_last_look(Exchange *x) {
    const size_t size = (size_t)x->fmu.n_indicators * sizeof(double);
    memcpy(x->looks, x->looks + (CUBIC_POINTS - 1) * x->fmu.n_indicators, size);
}
