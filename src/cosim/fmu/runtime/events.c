/* SPDX-License-Identifier: MIT-0
 *
 * What happens at one instant: initial equations, discrete equations, clocks.
 */
#include <math.h>
#include <string.h>

#include "elementary.h"
#include "simulation.h"

enum {
    MAX_PASSES = 100,       /* of an event iteration */
    FEW_PASSES = 20,        /* once it runs, with a fixed step */
    SIMULTANEOUS_PASSES = 10 /* after so many, relations change one at a time: Murty's rule against cycling */
};

static void initial_system(void *context, const double *v, double *r, double *J)
{
    State *s = context;
    model_initial_residual(s->t, v, s->u, s->p, s->d, s->c, r);
    if (J) model_initial_jacobian(s->t, v, s->u, s->p, s->d, s->c, J);
}

/* Elimination leaves rounding errors in what was known beforehand, and the sign of a zero decides relations. */
static void keep_start_values(Simulation *m)
{
    double v[MODEL_ROOM(MODEL_NV)], d[MODEL_ROOM(MODEL_ND)];
    model_start(m->s.p, v, d);
    for (int i = 0; i < MODEL_NV; i++)
        if (model_start_kept[i]) m->s.v[i] = v[i];
}

static int solve_initial(Simulation *m)
{
    Newton *w = &m->newton;
    double *v = m->s.v;
    w->most_iterations = 0;
    NewtonOutcome outcome = newton_solve(w, MODEL_NV, initial_system, &m->s, model_nominal, v);
    if (outcome == NEWTON_SINGULAR) {
        /* Start values of zero are often a singular point, as for a linkage: stretched out. */
        double stuck[MODEL_ROOM(MODEL_NV)];
        memcpy(stuck, v, sizeof stuck);
        for (int i = 0; i < MODEL_NV; i++) v[i] += 0.01 * (1 + i % 3) * model_nominal[i];
        outcome = newton_solve(w, MODEL_NV, initial_system, &m->s, model_nominal, v);
        if (outcome == NEWTON_SINGULAR) {
            memcpy(v, stuck, sizeof stuck);
            initial_system(&m->s, v, w->r, NULL);
        }
    }
    if (outcome == NEWTON_SOLVED) {
        keep_start_values(m);
        return 1;
    }
    return simulation_blame_initial(m, outcome);
}

static int most_passes(const State *s)
{
    return MODEL_HAS_FIXED_STEP && s->initialised ? FEW_PASSES : MAX_PASSES;
}

/* Bring c up to date; returns how many relations changed. */
static int update_relations(Simulation *m, int one_at_a_time)
{
    State *s = &m->s;
    double g[MODEL_ROOM(MODEL_NG)];
    int changes = 0;
    simulation_relations(m, s->t, s->v, g);
    for (int k = 0; k < MODEL_NG; k++) {
        int truth = simulation_truth(m, k, g[k]);
        m->changing[k] = truth != (s->c[k] != 0.0) && !(one_at_a_time && changes);
        if (m->changing[k]) {
            s->c[k] = truth;
            changes++;
        }
    }
    return changes;
}

static int not_a_number(Simulation *m, const double *d)
{
    int i = 0;
    while (!isnan(d[i])) i++;
    return simulation_fail(m,
                           "At t = %.9g s the discrete variable %s is not a number. Check what it is computed from for "
                           "a division by zero, the root or logarithm of a negative number, and for parameters out of "
                           "range.",
                           m->s.t, model_discrete_names[i]);
}

/* Find v, d, c that satisfy all equations for the given pre and fired. */
static int settle(Simulation *m, const double *pre, const double *fired, int initial, double *x_new)
{
    State *s = &m->s;
    double d_new[MODEL_ROOM(MODEL_ND)];
    unsigned char unsettled[MODEL_ROOM(MODEL_NG)] = {0};
    int outcome = 0;
    for (int pass = 0; pass < most_passes(s); pass++) {
        if (!(initial ? solve_initial(m) : simulation_solve_algebraic(m, s->t, s->v, NULL))) return 0;
        int changes = update_relations(m, pass >= SIMULTANEOUS_PASSES);
        if (pass >= most_passes(s) / 2)
            for (int k = 0; k < MODEL_NG; k++) unsettled[k] |= m->changing[k];
        memcpy(d_new, pre, MODEL_ND * sizeof *d_new);
        memcpy(x_new, s->v, MODEL_NX * sizeof *x_new);
        if (MODEL_ND > 0 || MODEL_NX > 0 || MODEL_NG > 0)
            outcome = model_discrete(s->t, s->v, s->u, s->p, s->d, s->c, pre, fired, initial, d_new, x_new);
        /* Start values have not been assigned by anything that looks at them. */
        if (outcome == MODEL_NOT_A_NUMBER || (initial && model_has_nan(d_new, MODEL_ND)))
            return not_a_number(m, d_new);
        for (int i = 0; i < MODEL_ND; i++) {
            if (s->d[i] != d_new[i]) changes++;
            s->d[i] = d_new[i];
        }
        if (!changes) {
            if (outcome) s->terminate = outcome;
            return 1;
        }
    }
    char text[512];
    memcpy(m->changing, unsettled, sizeof unsettled);
    simulation_changing_relations(m, text, sizeof text);
    return simulation_fail(m, "At t = %.9g s the event iteration finds no consistent state: %s%s keep changing.", s->t,
                           text[0] ? "the relations " : "the discrete variables", text);
}

/* Of a model that changes with clocks and inputs only, one pass over the discrete equations is the whole event. It
 * overwrites them where they are: a long filter would cost more to copy than to compute. */
static int tick(Simulation *m, const double *fired)
{
    State *s = &m->s;
    double unused[MODEL_ROOM(MODEL_NX)];
    int outcome = model_discrete(s->t, s->v, s->u, s->p, s->d, s->c, s->d, fired, 0, s->d, unused);
    if (outcome == MODEL_NOT_A_NUMBER) return not_a_number(m, s->d);
    if (outcome) s->terminate = outcome;
    return 1;
}

/* Events until nothing follows from the last one; fired is used up. */
static int iterate(Simulation *m, double *fired, int *discontinuous, int *reinitialised)
{
    State *s = &m->s;
    double pre[MODEL_ROOM(MODEL_ND)], x_new[MODEL_ROOM(MODEL_NX)];
    for (int pass = 0; pass < most_passes(s); pass++) {
        int again = 0;
        memcpy(pre, s->d, sizeof pre);
        if (!settle(m, pre, fired, 0, x_new)) return 0;
        for (int i = 0; i < MODEL_NX; i++)
            if (!isfinite(x_new[i])) {
                return simulation_fail(m, "At t = %.9g s reinit() sets %s to %g.", s->t, model_unknown_names[i],
                                       x_new[i]);
            } else if (x_new[i] != s->v[i]) {
                s->v[i] = x_new[i];
                again = *reinitialised = 1;
            }
        for (int i = 0; i < MODEL_ND; i++)
            if (pre[i] != s->d[i]) again = *discontinuous = 1;
        for (int k = 0; k < MODEL_NS; k++) fired[k] = 0.0;
        if (!again) return 1;
    }
    char text[512];
    simulation_changing_relations(m, text, sizeof text);
    return simulation_fail(m,
                           "At t = %.9g s one event causes the next without end%s%s. Check for reinit() and for "
                           "discrete variables that depend on their own pre() without a condition.",
                           s->t, text[0] ? "; the relations that changed last: " : "", text);
}

static double next_tick(const Simulation *m)
{
    const State *s = &m->s;
    double next = INFINITY;
    for (int k = 0; k < MODEL_NS; k++)
        next = fmin(next, s->clock_start[k] + (double)s->tick[k] * s->clock_interval[k]);
    return next;
}

double simulation_next_time_event(const Simulation *m)
{
    return fmin(next_tick(m), m->s.relation_due);
}

int simulation_tick_is_due(const Simulation *m)
{
    return next_tick(m) <= m->s.t + SAME_INSTANT;
}

int simulation_time_event_is_due(const Simulation *m)
{
    return simulation_next_time_event(m) <= m->s.t + SAME_INSTANT;
}

/* When the first relation of time changes, as it is from now to the next event. */
static void schedule_relations(Simulation *m)
{
    State *s = &m->s;
    s->relation_due = INFINITY;
    if (!MODEL_HAS_TIME_RELATIONS) return;
    double g[MODEL_ROOM(MODEL_NG)];
    simulation_relations(m, s->t, s->v, g);
    for (int k = 0; k < MODEL_NG; k++) {
        double slope = RELATION_SLOPE(k);
        if (slope == 0.0) continue;
        double rest = -g[k] / slope;
        if (rest > SAME_INSTANT) s->relation_due = fmin(s->relation_due, s->t + rest);
    }
}

static int take_ticks(State *s, double *fired)
{
    int ticks = 0;
    for (int k = 0; k < MODEL_NS; k++) {
        fired[k] = s->clock_start[k] + (double)s->tick[k] * s->clock_interval[k] <= s->t + SAME_INSTANT;
        if (fired[k] != 0.0) {
            s->tick[k]++;
            ticks++;
        }
    }
    return ticks;
}

/* After reinit() the old step size may be far too large; after anything else a rejection finds out cheaply. */
static void restart(Simulation *m, int reinitialised)
{
    State *s = &m->s;
    control_restart(&s->control);
    if (!reinitialised || !(s->control.h > 0.0)) return;
    model_rhs(s->t, s->v, s->u, s->p, s->d, s->c, m->rodas.f);
    memcpy(m->rodas.step.v, s->v, sizeof s->v);
    m->rodas.step.t = s->t;
    s->counters[COUNTER_RHS]++;
    s->control.h = fmin(s->control.h, rodas_first_step(&m->rodas, s->tolerance));
}

static void keep_discretes(State *s)
{
    memcpy(s->d_kept, s->d, sizeof s->d);
    memcpy(s->c_kept, s->c, sizeof s->c);
    s->kept = 1;
}

/* One event with these ticks. */
static int happen(Simulation *m, double *fired, int ticks, int *reinitialised)
{
    State *s = &m->s;
    int discontinuous = 0, reinit = 0;
    s->ahead.active = 0; /* what lies ahead was computed without this event */
    memset(s->selection_sign, 0, sizeof s->selection_sign);
    s->window.events++;
    if (ticks || s->relation_due <= s->t + SAME_INSTANT) s->counters[COUNTER_TIME_EVENTS]++;
    m->have = 0;
    if (MODEL_ALL_CLOCKED) {
        s->event_due = 0;
        return tick(m, fired) && simulation_check_assertions(m);
    }
    if (!iterate(m, fired, &discontinuous, &reinit)) return 0;
    s->event_due = 0;
    schedule_relations(m);
    restart(m, reinit);
    if (reinitialised) *reinitialised = reinit;
    return simulation_check_assertions(m);
}

int simulation_event(Simulation *m, int with_ticks, int *reinitialised)
{
    State *s = &m->s;
    if (s->keeping && !s->kept) keep_discretes(s);
    double fired[MODEL_ROOM(MODEL_NS)] = {0};
    int ticks = with_ticks ? take_ticks(s, fired) : 0;
    return happen(m, fired, ticks, reinitialised);
}

int simulation_end(Simulation *m)
{
#if MODEL_TERMINAL >= 0
    double fired[MODEL_ROOM(MODEL_NS)] = {0};
    fired[MODEL_TERMINAL] = 1.0;
    if (m->s.initialised && !happen(m, fired, 1, NULL)) return 0;
    m->s.kept = 0; /* what has changed now is to be seen */
#else
    (void)m;
#endif
    return 1;
}

static int start_clocks(Simulation *m)
{
    State *s = &m->s;
    if (MODEL_NS > 0) model_clocks(s->p, s->clock_start, s->clock_interval);
    for (int k = 0; k < MODEL_NS; k++) {
        double start = s->clock_start[k], interval = s->clock_interval[k];
        s->tick[k] = 0;
        if (k == MODEL_TERMINAL) continue;
        if (!isfinite(start) || !(interval > SAME_INSTANT) || !isfinite(interval))
            return simulation_fail(m, "Sample clock %d starts at %g s with the interval %g s, which must be positive.",
                                   k + 1, start, interval);
        double first = ceil((s->t - SAME_INSTANT - start) / interval);
        if (first > 0.0) s->tick[k] = (int64_t)first;
    }
    return 1;
}

int simulation_initialise(Simulation *m)
{
    State *s = &m->s;
    double pre[MODEL_ROOM(MODEL_ND)], x_new[MODEL_ROOM(MODEL_NX)], fired[MODEL_ROOM(MODEL_NS)] = {0};
    int ignored = 0;
    m->have = 0;
    s->terminate = 0;
    simulation_start_watching(m);
    memset(s->selection_sign, 0, sizeof s->selection_sign);
    if (!start_clocks(m)) return 0;
    model_start(s->p, s->v, s->d);
    memcpy(pre, s->d, sizeof pre);
    update_relations(m, 0);
    if (!settle(m, pre, fired, 1, x_new)) return 0;
    memcpy(s->v, x_new, MODEL_NX * sizeof *x_new);
    if (!iterate(m, fired, &ignored, &ignored) || !simulation_check_assertions(m)) return 0;
    schedule_relations(m);
    s->initialised = 1;
    s->event_due = 0;
    return 1;
}
