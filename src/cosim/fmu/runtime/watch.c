/* SPDX-License-Identifier: MIT-0
 *
 * Whether a simulation gets anywhere: chattering, events that accumulate, discontinuities hidden from the solver.
 */
#include <math.h>
#include <string.h>

#include "simulation.h"

/* A model that changes direction faster than this many times in this many seconds is chattering. */
enum { BURST_EVENTS = 1000 };
static const double BURST_DURATION = 1e-5;
/* Intervals between events of one relation that shrink so often in a row, and have come to this, go to zero. */
enum { SHRINKING = 5 };
static const double SHORTEST_INTERVAL = 1e-8;
/* In Model Exchange events are as exact as the importer's search. */
static const double SHORTEST_INTERVAL_OF_IMPORTER = 1e-6;
/* The solver is stuck if in each of so many steps that it chose itself, with hardly an event to blame, nothing moves by
 * more than a few tolerances. A smooth solution moves by far more: by tolerance^(1/4), as the method is of order 4. */
enum { ATTEMPTS = 10000, EVENTS = ATTEMPTS / 100 };
static const double TOLERANCES = 2.0;

static void open_window(State *s)
{
    s->window.t = s->t;
    s->window.attempts = s->window.events = 0;
    memcpy(s->window.v, s->v, sizeof s->v);
}

void simulation_start_watching(Simulation *m)
{
    State *s = &m->s;
    s->burst_start = s->t;
    s->burst_events = 0;
    for (int k = 0; k < MODEL_NG; k++) s->accumulation[k] = (Accumulation){-INFINITY, INFINITY, 0};
    open_window(s);
}

/* Relation k becomes true now. */
static int accumulates(State *s, int k)
{
    Accumulation *a = &s->accumulation[k];
    double interval = s->t - a->last;
    a->shorter = interval < a->interval ? a->shorter + 1 : 0;
    a->last = s->t;
    a->interval = interval;
    double shortest = s->type == MODEL_EXCHANGE ? SHORTEST_INTERVAL_OF_IMPORTER : SHORTEST_INTERVAL;
    return a->shorter >= SHRINKING && interval < shortest;
}

int simulation_count_event(Simulation *m)
{
    State *s = &m->s;
    s->counters[COUNTER_STATE_EVENTS]++;
    if (MODEL_HAS_FIXED_STEP) return 1; /* there are not more of them than a step may have */
    for (int k = 0; k < MODEL_NG; k++)
        if (m->changing[k] && s->c[k] == 0.0 && accumulates(s, k))
            return simulation_fail(m,
                                   "At t = %.9g s the events of '%s' accumulate: each follows the one before after a "
                                   "shorter time, the last after %.2g s, so that there is no time after them all. Let "
                                   "the model come to rest before, for instance below a speed, or let a spring and "
                                   "damper do what reinit() does.",
                                   s->t, model_relation_texts[k], s->accumulation[k].interval);
    if (s->t - s->burst_start > BURST_DURATION) {
        s->burst_start = s->t;
        s->burst_events = 0;
    }
    if (++s->burst_events <= BURST_EVENTS) return 1;
    char text[512];
    return simulation_fail(m,
                           "At t = %.9g s the model chatters: %d state events within %.2g s, the last one in the "
                           "relation %s. Smooth the discontinuity or give it a hysteresis.",
                           s->t, (int)BURST_EVENTS, BURST_DURATION,
                           simulation_changing_relations(m, text, sizeof text));
}

/* How much of its size anything has moved since the window was opened, or would have at the rate it has now. */
static double movement(const Simulation *m)
{
    const State *s = &m->s;
    double largest = 0.0;
    for (int i = 0; i < MODEL_NV; i++) {
        double moved = fabs(s->v[i] - s->window.v[i]);
        if (i < MODEL_NX) moved = fmax(moved, fabs(m->rodas.f[i]) * (s->t - s->window.t));
        largest = fmax(largest, moved / (fabs(s->v[i]) + model_nominal[i]));
    }
    return largest;
}

int simulation_check_progress(Simulation *m)
{
    State *s = &m->s;
    if (++s->window.attempts < ATTEMPTS) return 1;
    if (s->window.events > EVENTS || movement(m) > ATTEMPTS * TOLERANCES * s->tolerance) {
        open_window(s);
        return 1;
    }
    return simulation_fail(m,
                           "At t = %.9g s the solver makes no progress: its last %d steps have covered %.2g s, the "
                           "largest error is in %s. Check for a discontinuity that changes sides again and again "
                           "without an event, as in sign(), abs(), noEvent() and smooth(): smooth it, or write it as an "
                           "if-expression with a hysteresis.",
                           s->t, (int)ATTEMPTS, s->t - s->window.t, model_unknown_names[m->rodas.worst]);
}
