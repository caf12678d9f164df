/* SPDX-License-Identifier: MIT-0
 *
 * A ball for Model Exchange: der(h) = v, der(v) = u - g; it bounces at h = 0 with restitution e (state event), reports
 * its height every T (time event), turns `high` over when asked after a step (step event), asks for the end at t_end,
 * has no derivatives from t_wrong on, and, if `again`, never settles.
 */
#define NX 2
#define NZ 1
#include "exchange.h"

enum { H = 1, V, DER_H, DER_V, U, G, E, T, BOUNCES, SAMPLED, SAMPLES, STEPS, HIGH, END, WRONG, AGAIN };

static void start(Model *m) {
    m->v[H] = 1.0;
    m->v[G] = 9.81;
    m->v[E] = 0.7;
}
static bool rates(Model *m) {
    m->v[DER_H] = m->v[V];
    m->v[DER_V] = m->v[U] - m->v[G];
    return m->v[WRONG] == 0.0 || m->time < m->v[WRONG];
}
static void indicators(Model *m, double z[]) { z[0] = m->v[H]; }
static void completed(Model *m) {
    m->v[STEPS] += 1.0;
    m->step_event = (m->v[H] > 0.5) != (m->v[HIGH] != 0.0);
    m->terminate = m->v[END] > 0.0 && m->time >= m->v[END];
}
static void update(Model *m) {
    m->states_changed = m->v[H] <= 0.0 && m->v[V] < 0.0;
    if (m->states_changed) {
        m->v[V] *= -m->v[E];
        m->v[H] = 0.0;
        m->v[BOUNCES] += 1.0;
    }
    m->v[HIGH] = m->v[H] > 0.5;
    if (m->v[T] > 0.0 && m->time >= m->v[SAMPLES] * m->v[T] - 1e-12) {
        m->v[SAMPLED] = m->v[H];
        m->v[SAMPLES] += 1.0;
        m->next_event = m->v[SAMPLES] * m->v[T];
    }
    m->update_needed = m->states_changed || m->v[AGAIN] != 0.0;
}
static void outputs(Model *m) {}
