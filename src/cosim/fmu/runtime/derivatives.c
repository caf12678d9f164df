/* SPDX-License-Identifier: MIT-0
 *
 * Directional and adjoint derivatives: the implicit function theorem around the generated derivatives.
 */
#include "derivatives.h"

#include <math.h>
#include <string.h>

#include "instance.h"
#include "lu.h"

#if MODEL_HAS_DERIVATIVES

#define POINT(m) (m)->s.t, (m)->shown_v, (m)->s.u, (m)->s.p, (m)->s.d, (m)->s.c

static int singular(Simulation *m, int unknown)
{
    return simulation_fail(m, "At t = %.9g s there is no derivative: the equations are singular; the unknown concerned "
                           "is %s.", m->s.t, model_unknown_names[unknown]);
}

static void transpose(int n, double *A)
{
    for (int j = 0; j < n; j++)
        for (int i = 0; i < j; i++) {
            double swapped = A[j * n + i];
            A[j * n + i] = A[i * n + j];
            A[i * n + j] = swapped;
        }
}

/* x = -(df_z/dz)^-1 x, or with its transposed. */
static int solve_algebraic(Simulation *m, int transposed, double *x)
{
    if (!transposed && simulation_solve_at_settled(m, m->shown_v, x)) return 1;
    double r[MODEL_ROOM(MODEL_NZ)];
    model_linearise_residual(POINT(m), r, m->newton.J);
    if (transposed) transpose(MODEL_NZ, m->newton.J);
    int failed = lu_factor(MODEL_NZ, m->newton.J, m->newton.pivots);
    if (failed) return singular(m, MODEL_NX + failed - 1);
    for (int i = 0; i < MODEL_NZ; i++) x[i] = -x[i];
    lu_solve(MODEL_NZ, m->newton.J, m->newton.pivots, x);
    return 1;
}

int simulation_forward(Simulation *m, const Knowns *rates, Unknowns *result)
{
    if (!simulation_values(m, STORE_UNKNOWN)) return 0;
    Knowns *same = &result->same;
    *same = *rates;
    memset(same->v + MODEL_NX, 0, MODEL_NZ * sizeof *same->v);
    model_forward(POINT(m), same->t, same->v, same->u, result->f, result->y);
    if (MODEL_NZ == 0) return 1;
    memcpy(same->v + MODEL_NX, result->f + MODEL_NX, MODEL_NZ * sizeof *same->v);
    if (!solve_algebraic(m, 0, same->v + MODEL_NX)) return 0;
    model_forward(POINT(m), same->t, same->v, same->u, result->f, result->y);
    return 1;
}

static void reverse(Simulation *m, const double *f_bar, const Unknowns *weights, Knowns *result)
{
    model_reverse(POINT(m), f_bar, weights->y, &result->t, result->v, result->u, result->p);
    result->t += weights->same.t;
    for (int i = 0; i < MODEL_NV; i++) result->v[i] += weights->same.v[i];
    for (int i = 0; i < MODEL_NU; i++) result->u[i] += weights->same.u[i];
    for (int i = 0; i < MODEL_NP; i++) result->p[i] += weights->same.p[i];
}

/* What the weights of v add to those of t, u and p through the initial equations. */
static int through_initial_equations(Simulation *m, Knowns *result)
{
    double t_bar, u_bar[MODEL_ROOM(MODEL_NU)], p_bar[MODEL_ROOM(MODEL_NP)], *r_bar = m->newton.r;
    model_initial_jacobian(POINT(m), m->newton.J);
    transpose(MODEL_NV, m->newton.J);
    int failed = lu_factor(MODEL_NV, m->newton.J, m->newton.pivots);
    if (failed) return singular(m, failed - 1);
    for (int i = 0; i < MODEL_NV; i++) r_bar[i] = -result->v[i];
    lu_solve(MODEL_NV, m->newton.J, m->newton.pivots, r_bar);
    model_initial_reverse(POINT(m), r_bar, &t_bar, u_bar, p_bar);
    result->t += t_bar;
    for (int i = 0; i < MODEL_NU; i++) result->u[i] += u_bar[i];
    for (int i = 0; i < MODEL_NP; i++) result->p[i] += p_bar[i];
    return 1;
}

int simulation_reverse(Simulation *m, int initial, const Unknowns *weights, Knowns *result)
{
    if (!simulation_values(m, STORE_UNKNOWN)) return 0;
    double f_bar[MODEL_ROOM(MODEL_NV)] = {0}, free_bar[MODEL_ROOM(MODEL_NP)];
    memcpy(f_bar, weights->f, MODEL_NX * sizeof *f_bar);
    reverse(m, f_bar, weights, result);
    if (initial && MODEL_NV > 0) {
        if (!through_initial_equations(m, result)) return 0;
    } else if (MODEL_NZ > 0) {
        memcpy(f_bar + MODEL_NX, result->v + MODEL_NX, MODEL_NZ * sizeof *f_bar);
        if (!solve_algebraic(m, 1, f_bar + MODEL_NX)) return 0;
        reverse(m, f_bar, weights, result);
    }
    model_parameters_reverse(m->s.p, result->p, free_bar);
    memcpy(result->p, free_bar, MODEL_NP * sizeof *free_bar);
    return 1;
}

/* Where the rate or weight of a known is kept, or NULL after having said why it is none. */
static double *known(Simulation *m, const char *function, unsigned reference, Knowns *knowns)
{
    const ModelVariable *variable = reference < MODEL_NVARIABLES ? &model_variables[reference] : NULL;
    int initial = m->s.mode == INITIALIZATION_MODE;
    if (variable && variable->type == TYPE_REAL) switch (variable->store) {
        case STORE_TIME: return &knowns->t;
        case STORE_INPUT: return &knowns->u[variable->index];
        case STORE_PARAMETER:
            if (variable->settable != SET_NEVER) return &knowns->p[variable->index];
            break;
        case STORE_UNKNOWN:
            if ((int)variable->index < MODEL_NX && !initial) return &knowns->v[variable->index];
            break;
        default: break;
        }
    instance_error(m, "%s: derivatives are by Real inputs, parameters, time%s; the variable with value reference %u is "
                   "none of these.", function, initial ? "" : " and states", reference);
    return NULL;
}

/* Of an unknown; discrete variables keep their values, so their rate is that of nothing. */
static double *unknown(Simulation *m, const char *function, unsigned reference, Unknowns *unknowns, double *nothing)
{
    const ModelVariable *variable = reference < MODEL_NVARIABLES ? &model_variables[reference] : NULL;
    if (variable && variable->type == TYPE_REAL) switch (variable->store) {
        case STORE_TIME: return &unknowns->same.t;
        case STORE_UNKNOWN: return &unknowns->same.v[variable->index];
        case STORE_INPUT: return &unknowns->same.u[variable->index];
        case STORE_PARAMETER: return &unknowns->same.p[variable->index];
        case STORE_DERIVATIVE: return &unknowns->f[variable->index];
        case STORE_OUTPUT: return &unknowns->y[variable->index];
        case STORE_DISCRETE: return nothing;
        default: break;
        }
    instance_error(m, "%s: derivatives are of Real outputs, states and their derivatives; the variable with value "
                   "reference %u is none of these.", function, reference);
    return NULL;
}

static int exists(Simulation *m, const char *function, double value)
{
    if (isfinite(value)) return 1;
    return !instance_error(m, "%s: at t = %.9g s the derivative is not finite.", function, m->s.t);
}

static int ready(Simulation *m, const char *function, const void *unknowns, size_t n_unknowns, const void *knowns,
                 size_t n_knowns, const void *seed, size_t n_seed, const void *sensitivity, size_t n_sensitivity)
{
    int missing = (n_unknowns && !unknowns) || (n_knowns && !knowns) || (n_seed && !seed) ||
                  (n_sensitivity && !sensitivity);
    if (missing) instance_error(m, "%s: an array is null.", function);
    return !missing;
}

/* Row by row: what parameters do, and initial equations, is known in reverse. */
static int forward_by_rows(Simulation *m, const char *function, const unsigned *unknowns, size_t n_unknowns,
                           const unsigned *knowns, size_t n_knowns, const double *seed, double *sensitivity)
{
    Knowns gradient;
    double nothing;
    for (size_t i = 0; i < n_unknowns; i++) {
        Unknowns weights;
        memset(&weights, 0, sizeof weights);
        *unknown(m, function, unknowns[i], &weights, &nothing) = 1.0;
        if (!simulation_reverse(m, m->s.mode == INITIALIZATION_MODE, &weights, &gradient))
            return instance_error(m, "%s: %s", function, m->message);
        sensitivity[i] = 0.0;
        for (size_t k = 0; k < n_knowns; k++)
            if (seed[k] != 0.0) sensitivity[i] += *known(m, function, knowns[k], &gradient) * seed[k];
        if (!exists(m, function, sensitivity[i])) return STATUS_ERROR;
    }
    return STATUS_OK;
}

int derivatives_forward(Simulation *m, const char *function, const unsigned *unknowns, size_t n_unknowns,
                        const unsigned *knowns, size_t n_knowns, const double *seed, double *sensitivity)
{
    Knowns rates;
    Unknowns result;
    double nothing = 0.0;
    int by_rows = m->s.mode == INITIALIZATION_MODE;
    if (!ready(m, function, unknowns, n_unknowns, knowns, n_knowns, seed, n_knowns, sensitivity, n_unknowns))
        return STATUS_ERROR;
    memset(&rates, 0, sizeof rates);
    for (size_t k = 0; k < n_knowns; k++) {
        double *rate = known(m, function, knowns[k], &rates);
        if (!rate) return STATUS_ERROR;
        *rate += seed[k];
        by_rows |= seed[k] != 0.0 && model_variables[knowns[k]].store == STORE_PARAMETER;
    }
    for (size_t i = 0; i < n_unknowns; i++)
        if (!unknown(m, function, unknowns[i], &result, &nothing)) return STATUS_ERROR;
    if (by_rows) return forward_by_rows(m, function, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity);
    if (!simulation_forward(m, &rates, &result)) return instance_error(m, "%s: %s", function, m->message);
    for (size_t i = 0; i < n_unknowns; i++) {
        sensitivity[i] = *unknown(m, function, unknowns[i], &result, &nothing);
        if (!exists(m, function, sensitivity[i])) return STATUS_ERROR;
    }
    return STATUS_OK;
}

int derivatives_adjoint(Simulation *m, const char *function, const unsigned *unknowns, size_t n_unknowns,
                        const unsigned *knowns, size_t n_knowns, const double *seed, double *sensitivity)
{
    Knowns result;
    Unknowns weights;
    double nothing = 0.0;
    if (!ready(m, function, unknowns, n_unknowns, knowns, n_knowns, seed, n_unknowns, sensitivity, n_knowns))
        return STATUS_ERROR;
    memset(&weights, 0, sizeof weights);
    for (size_t i = 0; i < n_unknowns; i++) {
        double *weight = unknown(m, function, unknowns[i], &weights, &nothing);
        if (!weight) return STATUS_ERROR;
        *weight += seed[i];
    }
    for (size_t k = 0; k < n_knowns; k++)
        if (!known(m, function, knowns[k], &result)) return STATUS_ERROR;
    if (!simulation_reverse(m, m->s.mode == INITIALIZATION_MODE, &weights, &result))
        return instance_error(m, "%s: %s", function, m->message);
    for (size_t k = 0; k < n_knowns; k++) {
        sensitivity[k] = *known(m, function, knowns[k], &result);
        if (!exists(m, function, sensitivity[k])) return STATUS_ERROR;
    }
    return STATUS_OK;
}

int derivatives_in_time(Simulation *m, const char *function, const unsigned *references, size_t n, const int *orders,
                        double *values)
{
    Knowns rates;
    Unknowns result;
    double nothing = 0.0;
    if (n && (!references || !orders || !values)) return instance_error(m, "%s: an array is null.", function);
    for (size_t k = 0; k < n; k++) {
        if (!unknown(m, function, references[k], &result, &nothing)) return STATUS_ERROR;
        if (orders[k] != 1)
            return instance_error(m, "%s: the derivative of order %d is asked for; there is only the first.", function,
                                  orders[k]);
    }
    const double *f = simulation_values(m, STORE_DERIVATIVE);
    memset(&rates, 0, sizeof rates);
    rates.t = 1.0;
    if (f) memcpy(rates.v, f, MODEL_NX * sizeof *f);
    if (!f || !simulation_forward(m, &rates, &result)) return instance_error(m, "%s: %s", function, m->message);
    for (size_t k = 0; k < n; k++) {
        values[k] = *unknown(m, function, references[k], &result, &nothing);
        if (!exists(m, function, values[k])) return STATUS_ERROR;
    }
    return STATUS_OK;
}

#else /* models written by hand */

int derivatives_forward(Simulation *m, const char *function, const unsigned *unknowns, size_t n_unknowns,
                        const unsigned *knowns, size_t n_knowns, const double *seed, double *sensitivity)
{
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)sensitivity;
    return instance_error(m, "%s is not supported by this FMU.", function);
}

int derivatives_adjoint(Simulation *m, const char *function, const unsigned *unknowns, size_t n_unknowns,
                        const unsigned *knowns, size_t n_knowns, const double *seed, double *sensitivity)
{
    return derivatives_forward(m, function, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity);
}

int derivatives_in_time(Simulation *m, const char *function, const unsigned *references, size_t n, const int *orders,
                        double *values)
{
    (void)orders;
    return n == 0 ? STATUS_OK : derivatives_forward(m, function, references, n, NULL, 0, NULL, values);
}

#endif
