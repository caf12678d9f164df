/* SPDX-License-Identifier: MIT-0
 *
 * Hand-written sample models: everything of model.h that follows from a size of zero, or is the same for most samples.
 * The line "sizes:" at the top of a sample becomes its model_sizes.h.
 */
#include <math.h>

#include "elementary.h"
#include "model.h"

#define ARGUMENTS_UNUSED (void)t, (void)v, (void)u, (void)p, (void)d, (void)c

#define REAL(store, index, settable) {store, TYPE_REAL, settable, index}

#define COUNTER_VARIABLES                                                                                          \
    {STORE_COUNTER, TYPE_COUNTER, SET_NEVER, 0}, {STORE_COUNTER, TYPE_COUNTER, SET_NEVER, 1},                        \
        {STORE_COUNTER, TYPE_COUNTER, SET_NEVER, 2}, {STORE_COUNTER, TYPE_COUNTER, SET_NEVER, 3},                    \
        {STORE_COUNTER, TYPE_COUNTER, SET_NEVER, 4}, {STORE_COUNTER, TYPE_COUNTER, SET_NEVER, 5}

/* The samples give the derivatives one by one. */
void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J);
void model_time_derivative(MODEL_CONTINUOUS_ARGUMENTS, double *ft);

void model_linearise(MODEL_CONTINUOUS_ARGUMENTS, double *f, double *J, double *ft)
{
    model_rhs(t, v, u, p, d, c, f);
    model_jacobian(t, v, u, p, d, c, J);
    model_time_derivative(t, v, u, p, d, c, ft);
}

void model_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r)
{
    double f[MODEL_ROOM(MODEL_NV)];
    model_rhs(t, v, u, p, d, c, f);
    for (int i = 0; i < MODEL_NZ; i++) r[i] = f[MODEL_NX + i];
}

void model_linearise_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r, double *J)
{
    double whole[MODEL_ROOM(MODEL_NV * MODEL_NV)];
    model_residual(t, v, u, p, d, c, r);
    model_jacobian(t, v, u, p, d, c, whole);
    for (int j = 0; j < MODEL_NZ; j++)
        for (int i = 0; i < MODEL_NZ; i++) J[j * MODEL_NZ + i] = whole[(MODEL_NX + j) * MODEL_NV + MODEL_NX + i];
}

#if MODEL_NU == 0
const double model_start_inputs[1] = {0};
#endif
#if MODEL_NP == 0
const double model_start_parameters[1] = {0};
#endif
#ifndef SAMPLE_PARAMETERS
void model_parameters(double *p)
{
    (void)p;
}
#endif

#if MODEL_NV == 0
const double model_nominal[1] = {1};
const char *const model_unknown_names[1] = {""};
const char *const model_initial_texts[1] = {""};
void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED, (void)f;
}
void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED, (void)J;
}
#endif

#ifndef SAMPLE_TIME_DERIVATIVE
void model_time_derivative(MODEL_CONTINUOUS_ARGUMENTS, double *ft)
{
    ARGUMENTS_UNUSED;
    for (int i = 0; i < MODEL_NV; i++) ft[i] = 0.0;
}
#endif

const unsigned char model_start_kept[MODEL_ROOM(MODEL_NV)] = {0};

#ifndef SAMPLE_INITIAL /* all states have their start values */
void model_initial_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r)
{
    double start[MODEL_ROOM(MODEL_NV)], d_start[MODEL_ROOM(MODEL_ND)];
    model_start(p, start, d_start);
    model_rhs(t, v, u, p, d, c, r);
    for (int i = 0; i < MODEL_NX; i++) r[i] = v[i] - start[i];
}
void model_initial_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    model_jacobian(t, v, u, p, d, c, J);
    for (int j = 0; j < MODEL_NV; j++)
        for (int i = 0; i < MODEL_NX; i++) J[j * MODEL_NV + i] = i == j;
}
#endif

#if MODEL_NG == 0
const unsigned char model_relation_strict[1] = {0};
const char *const model_relation_texts[1] = {""};
void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g)
{
    ARGUMENTS_UNUSED, (void)g;
}
#endif

#if MODEL_NS == 0
void model_clocks(const double *p, double *start, double *interval)
{
    (void)p, (void)start, (void)interval;
}
#endif

#if MODEL_NY == 0
void model_outputs(MODEL_CONTINUOUS_ARGUMENTS, double *y)
{
    ARGUMENTS_UNUSED, (void)y;
}
#endif
#if MODEL_NL == 0
void model_locals(MODEL_CONTINUOUS_ARGUMENTS, double *l)
{
    ARGUMENTS_UNUSED, (void)l;
}
#endif

#if MODEL_NA == 0
const char *const model_assertion_messages[1] = {""};
const unsigned char model_assertion_is_error[1] = {0};
int model_violated_assertion(MODEL_CONTINUOUS_ARGUMENTS)
{
    ARGUMENTS_UNUSED;
    return -1;
}
#endif

#if MODEL_NE == 0
const char *const model_termination_messages[1] = {""};
#endif

#ifndef SAMPLE_DISCRETE
const char *const model_discrete_names[1] = {""};
int model_discrete(MODEL_CONTINUOUS_ARGUMENTS, const double *pre, const double *fired, int initial, double *d_new,
                   double *x_new)
{
    ARGUMENTS_UNUSED, (void)pre, (void)fired, (void)initial, (void)d_new;
    for (int i = 0; i < MODEL_NX; i++) x_new[i] = v[i];
    return 0;
}
#endif
