/* SPDX-License-Identifier: MIT-0
 *
 * Coefficients: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia
 * Differential Equations package, BIT Numerical Mathematics 63:27 (2023), in the transformed form that needs no product
 * with the Jacobian: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., equation (IV.7.25).
 */
#include "rodas.h"

#include <math.h>
#include <string.h>

#include "lu.h"

static const double GAMMA = 0.21193756319429014;
/* Stages 6 and 7 (counted from 0) start where the one before them ends: their rows repeat row 5 with ones after it. */
static const double A[6][5] = {
    {0},
    {3.0},
    {2.849394379747939, 0.45842242204463923},
    {-6.954028509809101, 2.489845061869568, -10.358996098473584},
    {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946},
};
static const double C[RODAS_STAGES][RODAS_STAGES - 1] = {
    {0},
    {-14.155112264123755},
    {-17.97296035885952, -2.859693295451294},
    {147.12150275711716, -1.41221402718213, 71.68940251302358},
    {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306},
    {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471},
    {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
     -28.087943162872662},
    {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
     -54.66780262877968, -9.48861652309627},
};
static const double ALPHA[RODAS_STAGES] = {
    0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0};
static const double D[RODAS_STAGES] = {
    0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734, 2.325825639765069, 0.0, 0.0,
    0.0};
static const double DENSE[RODAS_DENSE][RODAS_STAGES] = {
    {25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204, 0.524948541321073,
     1.1241088310450404, 0.4272876194431874, -0.17202221070155493},
    {-9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796, 20.176138334709044,
     15.98066361424651, -6.789040303419874, -6.710236069923372},
    {11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643, -52.072871366152654,
     -59.78993625266729, -0.15582684282751913, 4.883087185713722},
};

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
    for (int i = 0; i < MODEL_NX; i++) s->W[i * MODEL_NX + i] += 1.0 / (GAMMA * h);
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
    for (int i = 0; i < MODEL_NV; i++) b[i] = f[i] + h * D[stage] * r->f_t[i];
    for (int j = 0; j < stage; j++) {
        double factor = C[stage][j] / h;
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
        f[i] = (f[i] - slope / h) / GAMMA;
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
                for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += A[stage][j] * r->K[j][i];
        } else {
            for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += r->K[stage - 1][i];
        }
        model_rhs(r->step.t + ALPHA[stage] * h, r->step.v_new, held->u, held->p, held->d, held->c, f);
        solve_stage(r, stage, h, f);
    }
    for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += r->K[RODAS_STAGES - 1][i];
    double error = norm(r, r->K[RODAS_STAGES - 1], tolerance);
    if (error > 1.0) return error;
    for (int i = 0; i < MODEL_NV; i++) {
        double sum[RODAS_DENSE] = {0};
        for (int j = 0; j < RODAS_STAGES; j++)
            for (int k = 0; k < RODAS_DENSE; k++) sum[k] += DENSE[k][j] * r->K[j][i];
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

/* Gustafsson's predictive controller with the limits of Hairer's code. */
static const double SAFETY = 0.9, MOST_GROWTH = 6.0, MOST_SHRINKAGE = 0.2;

static double limited(double factor)
{
    return fmin(MOST_GROWTH, fmax(MOST_SHRINKAGE, factor));
}

void control_accept(StepControl *control, double h, double error)
{
    double factor = limited(SAFETY * pow(error, -0.2));
    if (h < control->h) {
        /* Cut to end where it had to. If that was far too short for its error, it says nothing of the longer step. */
        control->h = factor < MOST_GROWTH ? h * factor : fmax(control->h, h * factor);
        control_restart(control);
        return;
    }
    if (control->h_accepted > 0.0) {
        double predicted = SAFETY * (h / control->h_accepted) * pow(control->error_accepted / (error * error), 0.2);
        factor = fmin(factor, limited(predicted));
    }
    if (control->rejected) factor = fmin(factor, 1.0);
    control->h = h * factor;
    control->h_accepted = h;
    control->error_accepted = fmax(1e-2, error);
    control->rejected = 0;
}

void control_reject(StepControl *control, double h, double error)
{
    control->h = h * (isfinite(error) ? limited(SAFETY * pow(error, -0.2)) : MOST_SHRINKAGE);
    control->rejected = 1;
}

void control_restart(StepControl *control)
{
    control->h_accepted = 0.0;
    control->rejected = 0;
}
