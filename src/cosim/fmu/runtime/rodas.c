/* SPDX-License-Identifier: MIT-0
 *
 * Coefficients: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., section VI.4, code RODAS,
 * method 1 (gamma = 1/4), in the transformed form that needs no product with the Jacobian.
 */
#include "rodas.h"

#include <math.h>
#include <string.h>

#include "lu.h"

static const double GAMMA = 0.25;
static const double A[6][5] = {
    {0},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0},
};
static const double C[6][5] = {
    {0},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054},
};
static const double ALPHA[6] = {0.0, 0.386, 0.21, 0.63, 1.0, 1.0};
static const double D[6] = {0.25, -0.1043, 0.1035, -0.03620000000000023, 0.0, 0.0};
static const double DENSE2[5] = {10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
                                 1.025137723295662};
static const double DENSE3[5] = {-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386,
                                 -6.594389125716872};

void rodas_begin(Rodas *r, double t, const double *v, const Held *held)
{
    r->step.t = t;
    memcpy(r->step.v, v, sizeof r->step.v);
    model_linearise(t, v, held->u, held->p, held->d, held->c, r->f, r->J, r->f_t);
}

/* M / (gamma h) - J, factorised. */
static int factorise(Rodas *r, double h)
{
    for (int i = 0; i < MODEL_NV * MODEL_NV; i++) r->LU[i] = -r->J[i];
    for (int i = 0; i < MODEL_NX; i++) r->LU[i * MODEL_NV + i] += 1.0 / (GAMMA * h);
    int singular = lu_factor(MODEL_NV, r->LU, r->pivots);
    if (singular) r->worst = singular - 1;
    return singular;
}

/* K[stage] from the right-hand side f of that stage. */
static void solve_stage(Rodas *r, int stage, double h, const double *f)
{
    double *k = r->K[stage];
    for (int i = 0; i < MODEL_NV; i++) k[i] = f[i] + h * D[stage] * r->f_t[i];
    for (int j = 0; j < stage; j++) {
        double factor = C[stage][j] / h;
        for (int i = 0; i < MODEL_NX; i++) k[i] += factor * r->K[j][i];
    }
    lu_solve(MODEL_NV, r->LU, r->pivots, k);
}

/* Root mean square of the error estimate K[5] relative to the tolerance; infinite if anything is not a number. */
static double error_norm(Rodas *r, double tolerance)
{
    double sum = 0.0, largest = -1.0;
    for (int i = 0; i < MODEL_NV; i++) {
        double scale = tolerance * (model_nominal[i] + fmax(fabs(r->step.v[i]), fabs(r->step.v_new[i])));
        double ratio = r->K[5][i] / scale;
        double square = ratio * ratio;
        sum += square;
        if (!(square <= largest)) {
            largest = square;
            r->worst = i;
            if (!isfinite(square)) return INFINITY;
        }
    }
    return MODEL_NV > 0 ? sqrt(sum / MODEL_ROOM(MODEL_NV)) : 0.0;
}

double rodas_attempt(Rodas *r, double h, double tolerance, const Held *held)
{
    double f[MODEL_ROOM(MODEL_NV)];
    r->step.h = h;
    if (factorise(r, h)) return INFINITY;
    solve_stage(r, 0, h, r->f);
    for (int stage = 1; stage < 6; stage++) {
        /* The last stage starts from the one before it: A[5] = A[4] plus K[4]. */
        if (stage < 5) memcpy(r->step.v_new, r->step.v, sizeof r->step.v_new);
        for (int j = stage < 5 ? 0 : 4; j < stage; j++)
            for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += A[stage][j] * r->K[j][i];
        model_rhs(r->step.t + ALPHA[stage] * h, r->step.v_new, held->u, held->p, held->d, held->c, f);
        solve_stage(r, stage, h, f);
    }
    for (int i = 0; i < MODEL_NV; i++) r->step.v_new[i] += r->K[5][i];
    double error = error_norm(r, tolerance);
    if (error > 1.0) return error;
    for (int i = 0; i < MODEL_NV; i++) {
        double second = 0.0, third = 0.0;
        for (int j = 0; j < 5; j++) {
            second += DENSE2[j] * r->K[j][i];
            third += DENSE3[j] * r->K[j][i];
        }
        r->step.dense2[i] = second;
        r->step.dense3[i] = third;
    }
    return error;
}

void rodas_dense(const RodasStep *step, double theta, double *v)
{
    double rest = 1.0 - theta;
    for (int i = 0; i < MODEL_NV; i++)
        v[i] = step->v[i] * rest + theta * (step->v_new[i] + rest * (step->dense2[i] + theta * step->dense3[i]));
}

/* The local error is of order h^4 in units of the time T in which the fastest state changes by its own size. */
double rodas_first_step(const Rodas *r, double tolerance)
{
    double rate = 0.0;
    for (int i = 0; i < MODEL_NX; i++) rate = fmax(rate, fabs(r->f[i]) / (fabs(r->step.v[i]) + model_nominal[i]));
    double h = 0.5 * sqrt(sqrt(tolerance)) / rate;
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
    double factor = limited(SAFETY / sqrt(sqrt(error)));
    if (h < control->h) {
        /* Cut to end where it had to. If that was far too short for its error, it says nothing of the longer step. */
        control->h = factor < MOST_GROWTH ? h * factor : fmax(control->h, h * factor);
        control_restart(control);
        return;
    }
    if (control->h_accepted > 0.0) {
        double predicted = SAFETY * (h / control->h_accepted) * sqrt(sqrt(control->error_accepted / (error * error)));
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
    control->h = h * (isfinite(error) ? limited(SAFETY / sqrt(sqrt(error))) : MOST_SHRINKAGE);
    control->rejected = 1;
}

void control_restart(StepControl *control)
{
    control->h_accepted = 0.0;
    control->rejected = 0;
}
