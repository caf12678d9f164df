/* SPDX-License-Identifier: MIT-0
 *
 * For Model Exchange, with a solution in closed form: x = cos(t) by der(x) = v, der(v) = -x, and s = cos(t) by
 * der(s) = -L (s - cos(t)) - sin(t), stiff if L is large. What can go wrong: derivatives exist only within `near` of the
 * last completed step, or not at all from t_hole on, or are no number from t_nan on; if `grows`, der(x) = x^2; if `jumps`,
 * der(v) = -sign(v) without an event.
 */
#define NX 3
#define NZ 0
#include "exchange.h"

enum { X = 1, V, S, DER_X, DER_V, DER_S, L, NEAR, T_HOLE, T_NAN, GROWS, DONE, JUMPS };

static void start(Model *m) {
    m->v[X] = m->v[S] = m->v[L] = 1.0;
    m->v[NEAR] = m->v[T_HOLE] = m->v[T_NAN] = 1e9;
}
static bool rates(Model *m) {
    const double t = m->time;
    m->v[DER_X] = m->v[GROWS] != 0.0 ? m->v[X] * m->v[X] : m->v[V];
    m->v[DER_V] = m->v[JUMPS] != 0.0 ? (m->v[V] > 0.0 ? -1.0 : 1.0) : -m->v[X];
    m->v[DER_S] = t < m->v[T_NAN] ? -m->v[L] * (m->v[S] - cos(t)) - sin(t) : NAN;
    m->discard = t - m->v[DONE] > m->v[NEAR] || t >= m->v[T_HOLE];
    return !m->discard;
}
static void indicators(Model *m, double z[]) {}
static void completed(Model *m) { m->v[DONE] = m->time; }
static void update(Model *m) {}
static void outputs(Model *m) {}
#ifdef DIRECTIONAL
static double gain(const Model *m, unsigned rate, unsigned known) {
    if (rate == DER_X && m->v[GROWS] != 0.0) return known == X ? 2.0 * m->v[X] : 0.0;
    return rate == DER_X ? known == V : rate == DER_V ? -(known == X) : known == S ? -m->v[L] : 0.0;
}
#endif
