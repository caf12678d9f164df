/* SPDX-License-Identifier: MIT-0
 * sizes: NX=2 NP=2 ND=2 NG=2 NVARIABLES=12
 *
 * A ball that falls from rest and is thrown back with the restitution e whenever it touches the ground moving down:
 * when h <= 0 and v < 0 then reinit(v, -e * v); bounces = pre(bounces) + 1; end when.
 */
#define SAMPLE_DISCRETE
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER),                        /* h */
    REAL(STORE_UNKNOWN, 1, SET_NEVER),                        /* v */
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS), /* e */
    REAL(STORE_PARAMETER, 1, SET_BEFORE_INITIALIZATION_ENDS), /* start value of h */
    {STORE_DISCRETE, TYPE_INTEGER, SET_NEVER, 0},             /* bounces */
    COUNTER_VARIABLES,
};
const double model_start_parameters[2] = {0.8, 1.0};
const double model_nominal[2] = {1.0, 1.0};
const char *const model_unknown_names[2] = {"h", "v"};
const char *const model_discrete_names[2] = {"bounces", "impact"};
const char *const model_initial_texts[2] = {"h = h_start", "v = 0"};
const unsigned char model_relation_strict[2] = {0, 1};
const char *const model_relation_texts[2] = {"h <= 0", "v < 0"};

void model_start(const double *p, double *v, double *d)
{
    v[0] = p[1];
    v[1] = 0.0;
    d[0] = 0.0;
    d[1] = 0.0; /* the condition of the when clause */
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = v[1];
    f[1] = -9.81;
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = 0.0, J[2] = 1.0;
    J[1] = 0.0, J[3] = 0.0;
}

void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g)
{
    ARGUMENTS_UNUSED;
    g[0] = -v[0];
    g[1] = -v[1];
}

int model_discrete(MODEL_CONTINUOUS_ARGUMENTS, const double *pre, const double *fired, int initial, double *d_new,
                   double *x_new)
{
    ARGUMENTS_UNUSED, (void)fired;
    d_new[1] = c[0] != 0.0 && c[1] != 0.0;
    int when = d_new[1] != 0.0 && pre[1] == 0.0 && !initial;
    d_new[0] = pre[0] + when;
    x_new[0] = v[0];
    x_new[1] = when ? -p[0] * v[1] : v[1];
    return 0;
}
