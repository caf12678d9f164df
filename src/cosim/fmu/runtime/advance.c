/* SPDX-License-Identifier: MIT-0
 *
 * The way from one instant to another: integration, and what stops it.
 */
#include "simulation.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void simulation_reset(Simulation *m)
{
    State *s = &m->s;
    memset(s, 0, sizeof *s);
    s->tolerance = 1e-6;
    s->stop = s->relation_due = INFINITY;
    for (int i = 0; i < MODEL_NU; i++) s->u[i] = model_start_inputs[i];
    for (int i = 0; i < MODEL_NP; i++) s->p[i] = model_start_parameters[i];
    model_parameters(s->p);
    m->have = 0;
}

void simulation_changed(Simulation *m, int parameters)
{
    if (parameters) model_parameters(m->s.p);
    m->s.event_due = 1;
    m->tangent = TANGENT_UNKNOWN;
    m->have = 0;
}

#if !MODEL_HAS_FIXED_STEP
static Held held(const State *s)
{
    Held h = {s->u, s->p, s->d, s->c};
    return h;
}

static double smallest_step(const State *s)
{
    return 1e-14 * fmax(1.0, fabs(s->t));
}

static int step_is_too_small(Simulation *m, double h, int not_a_number)
{
    const State *s = &m->s;
    if (h >= smallest_step(s)) return 0;
    const char *name = model_unknown_names[m->rodas.worst];
    if (not_a_number)
        simulation_fail(m,
                        "At t = %.9g s the equations give no finite number, whatever the step size; the first unknown "
                        "concerned is %s. Check for a division by zero, the root or logarithm of a negative number, "
                        "and for inputs and parameters out of range.",
                        s->t, name);
    else
        simulation_fail(m,
                        "At t = %.9g s the step size had to be reduced to %.2g s without reaching the tolerance %.2g; "
                        "the largest error is in %s. Try a looser tolerance; check for a solution that grows beyond "
                        "bounds, a discontinuity hidden in noEvent() or smooth(), and parameters out of range.",
                        s->t, h, s->tolerance, name);
    simulation_blame_selection(m, s->v);
    return 1;
}

/* One accepted step from s.t, not beyond `limit`, left in m->rodas. */
static int take_step(Simulation *m, double limit)
{
    State *s = &m->s;
    Held constant = held(s);
    double rest = limit - s->t;
    int unsolved = 0;
    s->counters[COUNTER_RHS]++;
    s->counters[COUNTER_JACOBIANS]++;
    if (!rodas_begin(&m->rodas, s->t, s->v, &constant)) {
        simulation_fail(m, "At t = %.9g s the algebraic equations are singular; the unknown concerned is %s.", s->t,
                        model_unknown_names[m->rodas.worst]);
        return simulation_blame_selection(m, s->v);
    }
    if (!(s->control.h > 0.0)) s->control.h = rodas_first_step(&m->rodas, s->tolerance);
    for (;;) {
        double wanted = s->control.h;
        if (step_is_too_small(m, wanted, 0)) return 0;
        /* Two steps of equal length rather than a full one and a remainder. */
        double h = wanted >= rest ? rest : wanted > 0.5 * rest ? 0.5 * rest : wanted;
        double error = rodas_attempt(&m->rodas, h, s->tolerance, &constant);
        s->counters[COUNTER_RHS] += RODAS_STAGES;
        if (error <= 1.0 && !simulation_solve_algebraic(m, s->t + h, m->rodas.step.v_new, NULL)) {
            error = INFINITY;
            unsolved = 1;
        }
        if (error <= 1.0) {
            control_accept(&s->control, h, error);
            s->counters[COUNTER_STEPS]++;
            return h < wanted || simulation_check_progress(m);
        }
        control_reject(&s->control, h, error);
        s->counters[COUNTER_REJECTED]++;
        if (h == wanted && !simulation_check_progress(m)) return 0;
        /* The reason why the algebraic equations have no solution says more than that there is no step. */
        if (unsolved && s->control.h < smallest_step(s)) return 0;
        if (step_is_too_small(m, s->control.h, !isfinite(error))) return 0;
    }
}

#endif

/* Without continuous unknowns there is nothing to integrate, but relations of time may still change. */
static void take_empty_step(Simulation *m, double to)
{
    m->rodas.step.t = m->s.t;
    m->rodas.step.h = to - m->s.t;
}

#if MODEL_HAS_FIXED_STEP
#define TAKE_STEP simulation_take_fixed_step
#define FIND_EVENT simulation_find_event_in_fixed_step
#else
#define TAKE_STEP take_step
#define FIND_EVENT simulation_find_event
#endif

/* Take a step into the future and note up to where it holds. */
static int look_ahead(Simulation *m, double to, double limit)
{
    Ahead *ahead = &m->s.ahead;
    if (MODEL_NV == 0) {
        take_empty_step(m, limit = to);
    } else if (!TAKE_STEP(m, limit)) {
        return 0;
    }
    const RodasStep *step = &m->rodas.step;
    ahead->theta_end = 1.0;
    ahead->ends_in_event = FIND_EVENT(m, &ahead->theta_end);
    /* The end of a step that was cut to reach the limit is the limit, whatever the sum says. */
    double end = step->h >= limit - step->t ? limit : step->t + step->h;
    ahead->end = ahead->theta_end < 1.0 ? fmin(step->t + ahead->theta_end * step->h, end) : end;
    ahead->step = *step;
    ahead->active = 1;
    return 1;
}

static void move_to(Simulation *m, double t, double theta)
{
    m->s.t = t;
    rodas_dense(&m->s.ahead.step, theta, m->s.v);
    m->have = 0;
}

void simulation_log_state_event(const Simulation *m)
{
    if (!m->log_events || !m->log) return;
    char relations[512], text[600];
    simulation_changing_relations(m, relations, sizeof relations);
    snprintf(text, sizeof text, "State event at t = %.12g s: %s", m->s.t, relations);
    m->log(m->log_context, LOG_EVENT, text);
}

/* After an event a relation of time may change sooner than was known before. */
static void keep_to_time_relations(const State *s, double *to, double *limit)
{
    if (s->relation_due < *to - SAME_INSTANT) *to = s->relation_due;
    *limit = fmin(*limit, s->relation_due);
    if (*limit < *to + SAME_INSTANT) *limit = *to;
}

Advance simulation_advance(Simulation *m, double to, double limit, int stop_at_events)
{
    State *s = &m->s;
    Ahead *ahead = &s->ahead;
    if (s->event_due && !simulation_event(m, 0, NULL)) return ADVANCE_FAILED;
    if (MODEL_HAS_FIXED_STEP) limit = to;
    keep_to_time_relations(s, &to, &limit);
    while (s->t < to) {
        if (s->terminate) return ADVANCE_TERMINATED;
        if (!ahead->active && !look_ahead(m, to, limit)) return ADVANCE_FAILED;
        if (ahead->end > to) {
            move_to(m, to, (to - ahead->step.t) / ahead->step.h);
            if (!simulation_check_assertions(m)) return ADVANCE_FAILED;
            break;
        }
        move_to(m, ahead->end, ahead->theta_end);
        ahead->active = 0;
        if (!simulation_check_selection(m)) return ADVANCE_FAILED;
        if (ahead->ends_in_event) {
            simulation_log_state_event(m);
            if (!simulation_solve_algebraic(m, s->t, s->v, NULL) || !simulation_count_event(m)) return ADVANCE_FAILED;
            s->event_due = 1;
            if (stop_at_events) return ADVANCE_EVENT;
            if (!simulation_event(m, 0, NULL)) return ADVANCE_FAILED;
            keep_to_time_relations(s, &to, &limit);
        } else if (!simulation_check_assertions(m)) {
            return ADVANCE_FAILED;
        }
        if (m->intermediate && s->t < to) {
            m->intermediate(m->log_context);
            to = fmin(to, m->return_at);
        }
    }
    return s->terminate ? ADVANCE_TERMINATED : ADVANCE_REACHED;
}
