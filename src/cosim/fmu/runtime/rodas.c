/* SPDX-License-Identifier: MIT-0
 *
 * The method's coefficients are those of rodas_table.h.
 */
#include "rodas.h"

#include <math.h>
#include <string.h>

#include "lu.h"

/* Block elimination of the algebraic unknowns from J; index 1 means that it is possible. */
static int eliminate(Rodas *r)
{
    StageSystem *s = &r->system;
    for (int j = 0; j < MODEL_NZ; j++) {
        const double *column = r->J + (MODEL_NX + j) * MODEL_NV;
        memcpy(s->xz + j * MODEL_NX, column, MODEL_NX * sizeof *column);
        memcpy(s->zz + j * MODEL_NZ, column + MODEL_NX, MODEL_NZ * sizeof *column);
    }
    int singular = lu_prepare(MODEL_NZ, s->zz, s->pivots_z);
    if (singular) {
        r->worst = MODEL_NX + singular - 1;
        return 0;
    }
    for (int j = 0; j < MODEL_NX; j++) {
        const double *column = r->J + j * MODEL_NV;
        double *zx = s->zx + j * MODEL_NZ, *xx = s->xx + j * MODEL_NX;
        lu_apply(MODEL_NZ, s->zz, s->pivots_z, column + MODEL_NX, zx);
        memcpy(xx, column, MODEL_NX * sizeof *column);
        for (int k = 0; k < MODEL_NZ; k++)
            for (int i = 0; i < MODEL_NX; i++) xx[i] -= s->xz[k * MODEL_NX + i] * zx[k];
    }
    return 1;
}

/* I / (gamma h) - df_x/dx. */
static int factorise(Rodas *r, double h)
{
    StageSystem *s = &r->system;
    for (int i = 0; i < MODEL_NX * MODEL_NX; i++) s->W[i] = -s->xx[i];
    for (int i = 0; i < MODEL_NX; i++) s->W[i * MODEL_NX + i] += 1.0 / (RODAS_GAMMA * h);
    int singular = lu_prepare(MODEL_NX, s->W, s->pivots_x);
    if (singular) r->worst = singular - 1;
    return singular;
}

int rodas_begin(Rodas *r, double t, const double *v, const Held *held)
{
    r->step.t = t;
    memcpy(r->step.v, v, sizeof r->step.v);
    model_linearise(t, v, held->u, held->p, held->d, held->c, r->f, r->J, r->f_t);
    return eliminate(r);
}

void rodas_solve_algebraic(const Rodas *r, const double *b, double *x)
{
    lu_apply(MODEL_NZ, r->system.zz, r->system.pivots_z, b, x);
}

void rodas_algebraic_rates(const Rodas *r, double *dz_dt)
{
    rodas_solve_algebraic(r, r->f_t + MODEL_NX, dz_dt);
    for (int i = 0; i < MODEL_NZ; i++) dz_dt[i] = -dz_dt[i];
}

/* k = (M / (gamma h) - J)^-1 b; b is spent. */
static void solve(const StageSystem *s, double *b, double *k)
{
    double z[MODEL_ROOM(MODEL_NZ)];
    lu_apply(MODEL_NZ, s->zz, s->pivots_z, b + MODEL_NX, z);
    for (int j = 0; j < MODEL_NZ; j++)
        for (int i = 0; i < MODEL_NX; i++) b[i] -= s->xz[j * MODEL_NX + i] * z[j];
    lu_apply(MODEL_NX, s->W, s->pivots_x, b, k);
    for (int i = 0; i < MODEL_NZ; i++) k[MODEL_NX + i] = -z[i];
    for (int j = 0; j < MODEL_NX; j++)
        for (int i = 0; i < MODEL_NZ; i++) k[MODEL_NX + i] -= s->zx[j * MODEL_NZ + i] * k[j];
}

/* K[stage] from the right-hand side f of that stage. */
static void solve_stage(Rodas *r, int stage, double h, const double *f)
{
    double b[MODEL_ROOM(MODEL_NV)];
    for (int i = 0; i < MODEL_NV; i++) b[i] = f[i] + h * RODAS_D[stage] * r->f_t[i];
    for (int j = 0; j < stage; j++) {
        double factor = RODAS_C[stage][j] / h;
        for (int i = 0; i < MODEL_NX; i++) b[i] += factor * r->K[j][i];
    }
    solve(&r->system, b, r->K[stage]);
}

/* An algebraic unknown is a function of the states and is solved for again at the end of every step, so its error goes
 * no further. It is kept in bounds because events are found and rows begun from interpolated unknowns. */
static const double ALGEBRAIC_WEIGHT = 0.1;

/* The largest of these errors relative to the tolerance; infinite if one is not a number. */
static double norm(Rodas *r, const double *error, double tolerance)
{
    double largest = 0.0;
    for (int i = 0; i < MODEL_NV; i++) {
        double scale = tolerance * (model_nominal[i] + fmax(fabs(r->step.v[i]), fabs(r->step.v_new[i])));
        double ratio = fabs(error[i]) / scale * (i < MODEL_NX ? 1.0 : ALGEBRAIC_WEIGHT);
        if (!(ratio <= largest)) {
            largest = ratio;
            r->worst = i;
            if (!isfinite(ratio)) return INFINITY;
        }
    }
    return largest;
}

void rodas_dense(const RodasStep *step, double theta, double *v)
{
    double rest = 1.0 - theta;
    for (int i = 0; i < MODEL_NV; i++) {
        double bend = step->dense[0][i] + theta * (step->dense[1][i] + theta * step->dense[2][i]);
        v[i] = step->v[i] * rest + theta * (step->v_new[i] + rest * bend);
    }
}

/* How far the dense output is from satisfying the equations at one point, as an error of the unknowns: multiplied by
 * (I - gamma h J)^-1, lest stiffness blows it up. No stage lies between 0 and 0.4 h: a bend that is over by then, as of
 * friction when a motion reverses, would pass unseen without this. */
static double defect(Rodas *r, double h, double tolerance, const Held *held)
{
    static const double AT = 0.2;
    static const double SLOPE[RODAS_DENSE] = {1.0 - 2.0 * 0.2, 2.0 * 0.2 - 3.0 * 0.04, 3.0 * 0.04 - 4.0 * 0.008};
    double v[MODEL_ROOM(MODEL_NV)], f[MODEL_ROOM(MODEL_NV)], error[MODEL_ROOM(MODEL_NV)];
    rodas_dense(&r->step, AT, v);
    model_rhs(r->step.t + AT * h, v, held->u, held->p, held->d, held->c, f);
    for (int i = 0; i < MODEL_NX; i++) {
        double slope = r->step.v_new[i] - r->step.v[i];
        for (int k = 0; k < RODAS_DENSE; k++) slope += SLOPE[k] * r->step.dense[k][i];
        f[i] = (f[i] - slope / h) / RODAS_GAMMA;
    }
    solve(&r->system, f, error);
    return norm(r, error, tolerance);
}

double rodas_attempt(Rodas *r, double h, double tolerance, const Held *held)
{
    double f[MODEL_ROOM(MODEL_NV)];
    r->step.h = h;
    if (factorise(r, h)) return INFINITY;
    solve_stage(r, 0, h, r->f);
    for (int stage = 1; stage < RODAS_STAGES; stage++) {
        if (stage < 6) {
            memcpy(r->step.v_new, r->step.v, sizeof r->step.v_new);
            for (int j = 0; j < stage; j++)
                for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += RODAS_A[stage][j] * r->K[j][i];
        } else {
            for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += r->K[stage - 1][i];
        }
        model_rhs(r->step.t + RODAS_ALPHA[stage] * h, r->step.v_new, held->u, held->p, held->d, held->c, f);
        solve_stage(r, stage, h, f);
    }
    for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += r->K[RODAS_STAGES - 1][i];
    double error = norm(r, r->K[RODAS_STAGES - 1], tolerance);
    if (error > 1.0) return error;
    for (int i = 0; i < MODEL_NV; i++) {
        double sum[RODAS_DENSE] = {0};
        for (int j = 0; j < RODAS_STAGES; j++)
            for (int k = 0; k < RODAS_DENSE; k++) sum[k] += RODAS_BEND[k][j] * r->K[j][i];
        for (int k = 0; k < RODAS_DENSE; k++) r->step.dense[k][i] = sum[k];
    }
    return fmax(error, defect(r, h, tolerance, held));
}

/* The local error is of order h^5 in units of the time T in which the fastest state changes by its own size. */
double rodas_first_step(const Rodas *r, double tolerance)
{
    double rate = 0.0;
    for (int i = 0; i < MODEL_NX; i++) rate = fmax(rate, fabs(r->f[i]) / (fabs(r->step.v[i]) + model_nominal[i]));
    double h = 0.5 * pow(tolerance, 0.2) / rate;
    return fmax(isfinite(h) ? h : 1e-6, 1e-12 * fmax(1.0, fabs(r->step.t)));
}
