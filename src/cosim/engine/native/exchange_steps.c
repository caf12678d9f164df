/* SPDX-License-Identifier: Apache-2.0
 *
 * Model Exchange: the solver's steps from one event to the next, and what ends them.
 */
#include <string.h>

#include "exchange.h"

#define MANY 10000 /* steps, as in the FMUs' own solver */
#define FEW_TOLERANCES 2.0

/* Beyond this no step goes. */
static double limit_of(const Exchange *x) { return fmin(x->m.next, x->m.stop); }

/* Start from the states that the FMU has now. */
static Answer start_solver(Exchange *x) {
    Moment *m = &x->m;
    const int64_t n = x->fmu.n_states;
    Answer answer = ANSWERED;
    m->front = m->now;
    m->open = m->at_root = m->rated = false;
    m->placed = true;
    if (n > 0) answer = exchange_vector(x, FMU_GET_STATES, x->x, n);
    if (answer == ANSWERED && n > 0 && m->renominal) {
        answer = exchange_vector(x, FMU_GET_NOMINALS, x->nominal, n);
        for (int64_t i = 0; i < n; i++) x->nominal[i] = x->nominal[i] != 0.0 ? fabs(x->nominal[i]) : 1.0;
        m->renominal = false;
    }
    control_restart(&m->control);
    return answer == ANSWERED ? find_sides(x) : answer;
}

static Answer too_small(Exchange *x, double h, Answer last) {
    if (last == DISCARDED) return ENDED; /* for the reason that is kept */
    fail_with(x, STEP_TOO_SMALL);
    x->trouble.t = x->m.t;
    x->trouble.h = h;
    x->trouble.state = x->worst;
    return ENDED;
}

static int64_t events_of(const Moment *m) {
    return m->counts[STATE_EVENTS] + m->counts[TIME_EVENTS] + m->counts[STEP_EVENTS];
}

static void watch_from_here(Exchange *x) {
    x->m.watched = x->m.front;
    x->m.attempts = 0;
    x->m.events = events_of(&x->m);
    memcpy(x->was, x->x, (size_t)x->fmu.n_states * sizeof(double));
}

/* After a step of the solver's own choice was accepted or rejected: refuse to go on where ever so many of them, with
 * hardly an event to blame, move nothing by more than a few tolerances. A smooth solution moves by far more. */
static bool gets_anywhere(Exchange *x) {
    Moment *m = &x->m;
    if (++m->attempts < MANY) return true;
    const double passed = m->front - m->watched;
    double moved = 0.0;
    for (int i = 0; i < (int)x->fmu.n_states; i++) {
        const double way = fmax(fabs(x->x[i] - x->was[i]), fabs(x->f[i]) * passed);
        moved = fmax(moved, way / (fabs(x->x[i]) + x->nominal[i]));
    }
    if (events_of(m) - m->events > MANY / 100 || moved > MANY * FEW_TOLERANCES * m->tolerance) {
        watch_from_here(x);
        return true;
    }
    fail_with(x, NO_PROGRESS);
    x->trouble.t = m->front;
    x->trouble.h = passed;
    x->trouble.state = x->worst;
    return false;
}

/* What the solver's step says of the step h that was tried: whether it and its indicators can be had. */
static Answer try_step(Exchange *x, double h, double *error, double *theta) {
    Answer answer = attempt_step(x, h, error);
    if (answer != ANSWERED || *error > 1.0) return answer;
    answer = find_root(x, theta);
    if (answer != ANSWERED || *theta <= 1.0) return answer;
    return rates_here(x, x->rates); /* with which the next step begins */
}

/* One accepted step from the front, not beyond limit. */
static Answer integrate(Exchange *x, double limit, double *theta) {
    Moment *m = &x->m;
    StepControl *control = &m->control;
    const double smallest = 1e-14 * fmax(1.0, fabs(m->front));
    const Answer begun = begin_step(x);
    if (begun != ANSWERED) return ENDED;
    if (!(control->h > 0.0) || m->moved) {
        const double careful = first_step(x);
        control->h = control->h > 0.0 ? fmin(control->h, careful) : careful;
        m->moved = false;
    }
    for (;;) {
        control->h = fmin(control->h, m->longest);
        const double wanted = control->h, rest = limit - m->t;
        /* two steps of equal length rather than a full one and a remainder */
        const double h = wanted >= rest ? rest : wanted > 0.5 * rest ? 0.5 * rest : wanted;
        double error = INFINITY;
        x->until = h < rest ? m->t + h : limit;
        const Answer answer = try_step(x, h, &error, theta);
        if (answer == ENDED) return ENDED;
        if (answer == DISCARDED) error = INFINITY;
        if (error <= 1.0) {
            control_accept(control, h, error);
            m->counts[STEPS]++;
            return h < wanted || gets_anywhere(x) ? ANSWERED : ENDED;
        }
        control_reject(control, h, error);
        m->counts[REJECTED_STEPS]++;
        if (h == wanted && !gets_anywhere(x)) return ENDED;
        if (control->h < smallest) return too_small(x, control->h, answer);
    }
}

/* Without states there is nothing to integrate, but indicators may change with time. */
static Answer pass_time(Exchange *x, double to, double *theta) {
    Moment *m = &x->m;
    m->t = m->front;
    m->h = fmin(to - m->t, m->longest);
    x->until = m->h < to - m->t ? m->t + m->h : to;
    m->counts[STEPS] += x->fmu.n_indicators > 0;
    const Answer answer = find_root(x, theta);
    return answer == ANSWERED ? ANSWERED : ENDED;
}

/* Take one step of the solver, towards target; what is known beyond it stays valid as long as no input changes. */
static bool take_step(Exchange *x, double target) {
    Moment *m = &x->m;
    const double limit = limit_of(x);
    double theta = 2.0;
    m->open = true;
    m->at_root = false;
    if (limit - m->front <= SAME_INSTANT) {
        m->front = limit;
        m->placed = m->rated = false;
        return true;
    }
    const Answer answer = x->fmu.n_states > 0 ? integrate(x, limit, &theta) : pass_time(x, fmin(limit, target), &theta);
    if (answer != ANSWERED) return false;
    m->at_root = theta <= 1.0;
    if (m->at_root) {
        m->front = fmin(m->t + theta * m->h, x->until);
        m->placed = m->rated = false;
        interpolate(x, theta, x->x);
        return true;
    }
    m->front = x->until;
    m->placed = true;
    m->rated = x->fmu.n_states > 0;
    memcpy(x->x, x->end, (size_t)x->fmu.n_states * sizeof(double));
    memcpy(x->f, x->rates, (size_t)x->fmu.n_states * sizeof(double));
    keep_last_look(x);
    return true;
}

/* Put the FMU to t, within the solver's last step. */
static bool show_within(Exchange *x, double t) {
    interpolate(x, (t - x->m.t) / x->m.h, x->trial);
    return put(x, t, x->trial) == ANSWERED;
}

/* Put the FMU to the front, from where it goes on. */
static bool show_front(Exchange *x) {
    if (x->m.placed) return true;
    if (put(x, x->m.front, x->x) != ANSWERED) return false;
    x->m.placed = true;
    return true;
}
