/* SPDX-License-Identifier: MIT-0
 *
 * Steps of a fixed length, for importers that have to keep up with the wall clock: each costs about the same.
 *
 * A step is one attempt of the Rosenbrock method whatever its error is: one Jacobian, one factorisation, a fixed number
 * of evaluations. Within a step the first few events are located, by a bounded number of narrowings; what changes after
 * them is taken at the step's end.
 */
#include <math.h>

#include "simulation.h"

#if MODEL_HAS_FIXED_STEP

/* Events that are located in one step. */
enum { LOCATED = 3 };

/* The step's end: where one that began earlier and was cut by an event ends, else a whole step from here. */
static double end_of_step(State *s, double limit)
{
    if (!(s->grid_end > s->t + SAME_INSTANT)) {
        s->grid_end = s->t + MODEL_FIXED_STEP;
        s->grid_events = 0;
    }
    /* A communication point or a time event cuts the step; the remainder of an instant is no step of its own. */
    if (s->grid_end > limit - SAME_INSTANT) s->grid_end = limit;
    return s->grid_end;
}

int simulation_take_fixed_step(Simulation *m, double limit)
{
    State *s = &m->s;
    Held constant = {s->u, s->p, s->d, s->c};
    double h = end_of_step(s, limit) - s->t;
    s->counters[COUNTER_RHS] += 1 + RODAS_STAGES;
    s->counters[COUNTER_JACOBIANS]++;
    s->counters[COUNTER_STEPS]++;
    /* With this tolerance there is no error but what is not a number. */
    if (!rodas_begin(&m->rodas, s->t, s->v, &constant) || !isfinite(rodas_attempt(&m->rodas, h, INFINITY, &constant))) {
        simulation_fail(m, "At t = %.9g s a step of %.9g s gives no finite number; the first unknown concerned is %s. "
                        "Check inputs and parameters, or take a shorter fixed step.", s->t, h,
                        model_unknown_names[m->rodas.worst]);
        return simulation_blame_selection(m, s->v);
    }
    return simulation_solve_algebraic(m, s->t + h, m->rodas.step.v_new, NULL);
}

int simulation_find_event_in_fixed_step(Simulation *m, double *theta)
{
    if (!simulation_find_event(m, theta)) return 0;
    if (++m->s.grid_events > LOCATED) *theta = 1.0;
    return 1;
}

#endif
