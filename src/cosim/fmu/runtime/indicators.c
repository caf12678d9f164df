/* SPDX-License-Identifier: MIT-0
 *
 * Event indicators: what an importer watches in Model Exchange in place of simulation_find_event.
 *
 * The indicator z of a relation is its g, or -g, so that z > 0 and z <= 0 are the two domains that FMI tells apart, and
 * each is one truth value of the relation. An event that leaves g at zero, where the truth value is a matter of rounding,
 * would leave z there, too. So if g is next to zero after an event, z is moved away from it, to the side of the relation's
 * truth value, until the next event: a hysteresis far smaller than the error of any solver.
 */
#include <math.h>
#include <string.h>

#include "simulation.h"

/* Of a relation's size: nearer to zero than this, the sign of g means nothing. */
static const double NEXT_TO_ZERO = 1e-13;

/* How much g moves if one unknown moves by its nominal value, the most of all; 1 if none moves it. */
static void measure(Simulation *m)
{
    State *s = &m->s;
    double g[MODEL_ROOM(MODEL_NG)], moved[MODEL_ROOM(MODEL_NG)], v[MODEL_ROOM(MODEL_NV)];
    simulation_relations(m, s->t, s->v, g);
    memset(s->watched.size, 0, sizeof s->watched.size);
    for (int i = 0; i < MODEL_NV; i++) {
        memcpy(v, s->v, sizeof v);
        v[i] += model_nominal[i];
        simulation_relations(m, s->t, v, moved);
        for (int k = 0; k < MODEL_NG; k++) {
            double change = fabs(moved[k] - g[k]);
            if (isfinite(change)) s->watched.size[k] = fmax(s->watched.size[k], change);
        }
    }
    for (int k = 0; k < MODEL_NG; k++)
        if (!(s->watched.size[k] > 0.0)) s->watched.size[k] = 1.0;
}

void simulation_arm_indicators(Simulation *m, const double *v)
{
    State *s = &m->s;
    double g[MODEL_ROOM(MODEL_NG)];
    if (!s->watched.measured) measure(m);
    s->watched.measured = 1;
    simulation_relations(m, s->t, v, g);
    for (int k = 0; k < MODEL_NG; k++) {
        double least = NEXT_TO_ZERO * s->watched.size[k];
        s->watched.shift[k] = fabs(g[k]) < least ? least : 0.0;
    }
    m->have = 0;
}

int simulation_note_state_event(Simulation *m)
{
    State *s = &m->s;
    double g[MODEL_ROOM(MODEL_NG)];
    int changes = 0;
    simulation_relations(m, s->t, s->v, g);
    for (int k = 0; k < MODEL_NG; k++) changes += m->changing[k] = (unsigned char)simulation_changed_state(m, k, g[k]);
    if (!changes) return 1;
    simulation_log_state_event(m);
    return simulation_count_event(m);
}

void simulation_indicators(const Simulation *m, const double *v, double *z)
{
    const State *s = &m->s;
    double g[MODEL_ROOM(MODEL_NG)];
    simulation_relations(m, s->t, v, g);
    for (int k = 0; k < MODEL_NG; k++) {
        int truth = s->c[k] != 0.0;
        /* Where the relation has no value, it does not change. */
        double shifted = isnan(g[k])   ? (truth ? 1.0 : -1.0)
                         : truth ? g[k] + s->watched.shift[k]
                                 : g[k] - s->watched.shift[k];
        z[k] = model_relation_strict[k] ? shifted : -shifted;
    }
}
