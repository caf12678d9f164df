/* SPDX-License-Identifier: MIT-0
 *
 * Model Exchange: where the algebraic unknowns of a trial point are looked for from. An importer that integrates asks for
 * derivatives at many points near the one that it has accepted last: they lie near the tangent there, and nearer to the
 * parabola through the point before.
 */
#include <string.h>

#include "simulation.h"

void simulation_settle(Simulation *m, const double *v, int after_event)
{
    State *s = &m->s;
    Settled *settled = &s->settled;
    settled->known = !after_event && settled->known > 0 && s->t > settled->t[0] ? 2 : 1;
    settled->t[1] = settled->t[0];
    memcpy(settled->x[1], settled->x[0], sizeof settled->x[0]);
    memcpy(settled->z_before, s->v + MODEL_NX, MODEL_NZ * sizeof *v);
    settled->t[0] = s->t;
    memcpy(settled->x[0], v, MODEL_NX * sizeof *v);
    memmove(s->v + MODEL_NX, v + MODEL_NX, MODEL_NZ * sizeof *v);
    m->tangent = TANGENT_UNKNOWN;
}

#if MODEL_HAS_SWEEP && MODEL_NX > 0

/* The tangent is in m->rodas, which nobody else uses in Model Exchange: with the states in system.zx, but for the sign,
 * with time in the first K. In the second one is how far the last but one point is from it, by the time between them
 * squared. */
enum { WITH_TIME, CURVATURE };

static void move_along_tangent(const Simulation *m, double t, const double *x, double *z)
{
    const Settled *settled = &m->s.settled;
    const double *zx = m->rodas.system.zx, *zt = m->rodas.K[WITH_TIME];
    double passed = t - settled->t[0];
    for (int i = 0; i < MODEL_NZ; i++) z[i] += zt[i] * passed;
    for (int j = 0; j < MODEL_NX; j++) {
        double moved = x[j] - settled->x[0][j];
        for (int i = 0; i < MODEL_NZ; i++) z[i] -= zx[j * MODEL_NZ + i] * moved;
    }
}

/* A function of the settled points and the present inputs alone, so that nothing depends on who has asked before. */
static void find_tangent(Simulation *m)
{
    State *s = &m->s;
    const Settled *settled = &s->settled;
    Held held = {s->u, s->p, s->d, s->c};
    double v[MODEL_ROOM(MODEL_NV)], *curvature = m->rodas.K[CURVATURE];
    memcpy(v, settled->x[0], MODEL_NX * sizeof *v);
    memcpy(v + MODEL_NX, s->v + MODEL_NX, MODEL_NZ * sizeof *v);
    s->counters[COUNTER_RHS]++;
    s->counters[COUNTER_JACOBIANS]++;
    m->tangent = rodas_begin(&m->rodas, settled->t[0], v, &held) ? TANGENT_FOUND : NO_TANGENT;
    if (m->tangent == NO_TANGENT) return;
    rodas_algebraic_rates(&m->rodas, m->rodas.K[WITH_TIME]);
    for (int i = 0; i < MODEL_NZ; i++) curvature[i] = 0.0;
    if (settled->known < 2) return;
    move_along_tangent(m, settled->t[1], settled->x[1], v + MODEL_NX);
    double between = settled->t[0] - settled->t[1];
    for (int i = 0; i < MODEL_NZ; i++) curvature[i] = (settled->z_before[i] - v[MODEL_NX + i]) / (between * between);
}

static int has_tangent(Simulation *m)
{
    const State *s = &m->s;
    if (s->mode != CONTINUOUS_TIME_MODE || !s->settled.known) return 0;
    if (m->tangent == TANGENT_UNKNOWN) find_tangent(m);
    return m->tangent == TANGENT_FOUND;
}

int simulation_predict(Simulation *m, double *v)
{
    const State *s = &m->s;
    if (!has_tangent(m)) return 0;
    double passed = s->t - s->settled.t[0], square = passed * passed;
    move_along_tangent(m, s->t, v, v + MODEL_NX);
    for (int i = 0; i < MODEL_NZ; i++) v[MODEL_NX + i] += m->rodas.K[CURVATURE][i] * square;
    return 1;
}

int simulation_solve_at_settled(Simulation *m, const double *v, double *x)
{
    const State *s = &m->s;
    double b[MODEL_ROOM(MODEL_NZ)];
    if (s->t != s->settled.t[0] || memcmp(v, s->settled.x[0], MODEL_NX * sizeof *v) != 0 || !has_tangent(m)) return 0;
    for (int i = 0; i < MODEL_NZ; i++) b[i] = -x[i];
    rodas_solve_algebraic(&m->rodas, b, x);
    return 1;
}

#else

int simulation_predict(Simulation *m, double *v)
{
    (void)m, (void)v;
    return 0;
}

int simulation_solve_at_settled(Simulation *m, const double *v, double *x)
{
    (void)m, (void)v, (void)x;
    return 0;
}

#endif
