/* SPDX-License-Identifier: MIT-0
 *
 * What holds at a point: the algebraic unknowns, and the relations.
 */
#include <math.h>
#include <string.h>

#include "simulation.h"

typedef struct {
    Simulation *m;
    double t;
    double *v;
} AlgebraicSystem;

static void algebraic_system(void *context, const double *z, double *r, double *J)
{
    AlgebraicSystem *a = context;
    State *s = &a->m->s;
    double v[MODEL_ROOM(MODEL_NV)];
    memcpy(v, a->v, MODEL_NX * sizeof *v);
    memcpy(v + MODEL_NX, z, MODEL_NZ * sizeof *v);
    s->counters[COUNTER_RHS]++;
    if (J) {
        model_linearise_residual(a->t, v, s->u, s->p, s->d, s->c, r, J);
        s->counters[COUNTER_JACOBIANS]++;
    } else {
        model_residual(a->t, v, s->u, s->p, s->d, s->c, r);
    }
}

static int solve_by_newton(Simulation *m, double t, double *v)
{
    AlgebraicSystem system = {m, t, v};
    double z[MODEL_ROOM(MODEL_NZ)];
    memcpy(z, v + MODEL_NX, MODEL_NZ * sizeof *z);
    enum { FEW = 10 };
    m->newton.most_iterations = MODEL_HAS_FIXED_STEP && m->s.initialised ? FEW : 0;
    NewtonOutcome outcome =
        newton_solve(&m->newton, MODEL_NZ, algebraic_system, &system, model_nominal + MODEL_NX, z);
    if (outcome != NEWTON_SOLVED) {
        simulation_fail(m, "At t = %.9g s the algebraic equations %s; the unknown concerned is %s.", t,
                        outcome == NEWTON_SINGULAR ? "are singular" : "cannot be solved",
                        model_unknown_names[MODEL_NX + m->newton.worst]);
        return simulation_blame_selection(m, v);
    }
    memcpy(v + MODEL_NX, z, MODEL_NZ * sizeof *z);
    return 1;
}

/* Newton's method in a few corrections, the first of which is less than `longest` of an unknown's size, and each of the
 * next ones far less than the one before. */
static const double NEARLY = 1e-2, ROUGHLY = 0.5;

static int sweep(Simulation *m, double t, double *v, double *y, int sweeps, double longest)
{
#if MODEL_HAS_SWEEP
    static const double LESS = 0.25;
    State *s = &m->s;
    /* A correction of this size leaves an error of its square, times a curvature; far below the solver's error. */
    double quadratic = sqrt(1e-5 * s->tolerance);
    double swept[MODEL_ROOM(MODEL_NV)], dz[MODEL_ROOM(MODEL_NZ)], unwanted[MODEL_ROOM(MODEL_NY)];
    if (!y) y = unwanted;
    memcpy(swept, v, sizeof swept);
    for (int k = 0; k < sweeps; k++, longest = fmax(NEARLY, LESS * longest)) {
        s->counters[COUNTER_RHS]++;
        model_sweep(t, swept, s->u, s->p, s->d, s->c, dz, y);
        double largest = 0.0;
        for (int i = 0; i < MODEL_NZ; i++) {
            double *z = &swept[MODEL_NX + i], length = fabs(dz[i]) / (fabs(*z) + model_nominal[MODEL_NX + i]);
            if (!(length < longest)) return 0;
            largest = fmax(largest, length);
            *z += dz[i];
        }
        if (largest <= quadratic) {
            memcpy(v, swept, sizeof swept);
            return 1;
        }
    }
#else
    (void)m, (void)t, (void)v, (void)y, (void)sweeps, (void)longest;
#endif
    return 0;
}

int simulation_solve_nearby(Simulation *m, double t, double *v, double *y)
{
    return sweep(m, t, v, y, 5, ROUGHLY);
}

int simulation_solve_algebraic(Simulation *m, double t, double *v, double *y)
{
    const State *s = &m->s;
    if (MODEL_NZ > 0 && sweep(m, t, v, y, 3, NEARLY)) return 1;
    if (MODEL_NZ > 0 && !solve_by_newton(m, t, v)) return 0;
    if (y) model_outputs(t, v, s->u, s->p, s->d, s->c, y);
    return 1;
}

void simulation_relations(const Simulation *m, double t, const double *v, double *g)
{
    const State *s = &m->s;
    if (MODEL_NG > 0) model_indicators(t, v, s->u, s->p, s->d, s->c, g);
}
