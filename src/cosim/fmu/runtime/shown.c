/* SPDX-License-Identifier: MIT-0
 *
 * The values that an importer sees, derived from the state when they are asked for.
 */
#include <string.h>

#include "simulation.h"

const double *simulation_values(Simulation *m, ModelStore store)
{
    State *s = &m->s;
    if (!s->initialised && !simulation_initialise(m)) return NULL;
    if (!(m->have & 1u << STORE_UNKNOWN)) {
        /* Into a copy: whether somebody looks must not change the future. */
        memcpy(m->shown_v, s->v, sizeof s->v);
        if (!simulation_predict(m, m->shown_v) || !simulation_solve_nearby(m, s->t, m->shown_v, m->shown_y)) {
            memcpy(m->shown_v, s->v, sizeof s->v);
            if (!simulation_solve_algebraic(m, s->t, m->shown_v, m->shown_y)) return NULL;
        }
        m->have = 1u << STORE_UNKNOWN | 1u << STORE_OUTPUT;
    }
    if (store == STORE_UNKNOWN) return m->shown_v;
    int valid = (m->have & 1u << store) != 0;
    m->have |= 1u << store;
    switch (store) {
    case STORE_DERIVATIVE:
        if (!valid) model_rhs(s->t, m->shown_v, s->u, s->p, s->d, s->c, m->shown_f);
        return m->shown_f;
    case STORE_OUTPUT: return m->shown_y;
    case STORE_LOCAL:
        if (!valid) model_locals(s->t, m->shown_v, s->u, s->p, s->d, s->c, m->shown_l);
        return m->shown_l;
    case STORE_INDICATOR:
        if (!valid) simulation_indicators(m, m->shown_v, m->shown_g);
        return m->shown_g;
    case STORE_DISCRETE: return s->d;
    default: return NULL;
    }
}

const double *simulation_kept_values(Simulation *m, ModelStore store)
{
    State *s = &m->s;
    if (store == STORE_DISCRETE) return s->d_kept;
    const double *v = simulation_values(m, STORE_UNKNOWN);
    if (!v) return NULL;
    double *kept = store == STORE_OUTPUT ? m->kept_y : m->kept_l;
    (store == STORE_OUTPUT ? model_outputs : model_locals)(s->t, v, s->u, s->p, s->d_kept, s->c_kept, kept);
    return kept;
}
