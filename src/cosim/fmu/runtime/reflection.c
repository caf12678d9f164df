/* SPDX-License-Identifier: MIT-0
 *
 * Whether an importer's step may have passed a point where the choice of states is singular, and gone on with the wrong one
 * of two solutions: the states are smooth there, but the algebraic unknowns turn back.
 *
 * A determinant that was about to change its sign, by the last two completed steps, and has not, is suspicious. Then the
 * step is searched: does the determinant vanish along the states' cubic through both ends? That it comes near zero and
 * turns, as in a linkage that just misses its dead centre, cannot be told from this where steps are long; so this warns,
 * and does not refuse.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "simulation.h"

#if MODEL_NCONSTRAINTS == 0

void simulation_watch_for_reflection(Simulation *m)
{
    (void)m;
}

#else

static double determinant_ratio(Determinant a, Determinant b)
{
    return ldexp(a.mantissa / b.mantissa, a.exponent - b.exponent);
}

/* The unknowns at the part theta of the step to s.t: 0 if there are none. */
static int within_step(Simulation *m, double theta, const double *f, double *v)
{
    const State *s = &m->s;
    const Trend *last = &s->trend;
    double h = s->t - last->t[0], rest = 1.0 - theta;
    for (int i = 0; i < MODEL_NX; i++)
        v[i] = rest * rest * ((1.0 + 2.0 * theta) * last->v[i] + theta * h * last->f[i]) +
               theta * theta * ((1.0 + 2.0 * rest) * s->v[i] - rest * h * f[i]);
    for (int i = MODEL_NX; i < MODEL_NV; i++) v[i] = rest * last->v[i] + theta * s->v[i];
    return simulation_solve_algebraic(m, last->t[0] + theta * h, v, NULL);
}

/* How small determinant k becomes within the step, relative to the smaller of those at its ends; v is where. */
static double smallest_determinant(Simulation *m, int k, const double *f, const Determinant *now, double *v)
{
    enum { PARTS = 24 };
    Determinant within[MODEL_NCONSTRAINTS];
    const Determinant *last = &m->s.trend.determinant[0][k];
    double least = 1.0, end = fmin(1.0, determinant_ratio(now[k], *last)), low = 0.0, high = 1.0, here[MODEL_ROOM(MODEL_NV)];
    memcpy(v, m->s.v, sizeof m->s.v);
    for (int round = 0; round < 2; round++) {
        double width = (high - low) / PARTS, best = 0.5 * (low + high);
        for (int i = 1; i < PARTS; i++) {
            double theta = low + i * width;
            if (!within_step(m, theta, f, here)) {
                memcpy(v, here, sizeof here);
                return 0.0;
            }
            simulation_determinants(m, m->s.trend.t[0] + theta * (m->s.t - m->s.trend.t[0]), here, within);
            double size = determinant_ratio(within[k], *last) / end;
            if (size < least) {
                least = size;
                best = theta;
                memcpy(v, here, sizeof here);
            }
        }
        low = best - width;
        high = best + width;
    }
    return least;
}

static void warn_of_reflection(Simulation *m, const double *v, int k)
{
    char text[sizeof m->message + 256];
    m->s.trend.told = 1;
    simulation_blame_passed(m, v, k);
    snprintf(text, sizeof text, "The step from t = %.9g s may have gone on with the wrong one of two solutions, of which "
                                "shorter steps or Co-Simulation find the right one. %s",
             m->s.trend.t[0], m->message);
    if (m->log) m->log(m->log_context, LOG_WARNING, text);
}

void simulation_watch_for_reflection(Simulation *m)
{
    static const double VANISHED = 0.2;
    State *s = &m->s;
    Trend *trend = &s->trend;
    Determinant now[MODEL_NCONSTRAINTS];
    double v[MODEL_ROOM(MODEL_NV)], f[MODEL_ROOM(MODEL_NV)];
    if (trend->told) return;
    simulation_determinants(m, s->t, s->v, now);
    model_rhs(s->t, s->v, s->u, s->p, s->d, s->c, f);
    if (trend->points > 0 && s->t <= trend->t[0]) trend->points = 0; /* the importer has gone back */
    for (int k = 0; k < MODEL_NCONSTRAINTS && trend->points > 1 && !trend->told; k++) {
        double steps = (s->t - trend->t[0]) / (trend->t[0] - trend->t[1]);
        double expected = 1.0 + steps * (1.0 - determinant_ratio(trend->determinant[1][k], trend->determinant[0][k]));
        if (!(expected < 0.0 && determinant_ratio(now[k], trend->determinant[0][k]) > 0.0)) continue;
        if (smallest_determinant(m, k, f, now, v) < VANISHED) warn_of_reflection(m, v, k);
    }
    trend->points = trend->points > 0 ? 2 : 1;
    trend->t[1] = trend->t[0];
    trend->t[0] = s->t;
    memcpy(trend->determinant[1], trend->determinant[0], sizeof now);
    memcpy(trend->determinant[0], now, sizeof now);
    memcpy(trend->v, s->v, sizeof s->v);
    memcpy(trend->f, f, sizeof f);
}

#endif
