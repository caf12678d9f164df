/* SPDX-License-Identifier: MIT-0
 * sizes: NX=2 NP=1 ND=2 NG=1 NVARIABLES=11
 *
 * x'' = -x from x = 1, and a count of how often x rises above a level: just below 1, these are short excursions.
 */
#define SAMPLE_DISCRETE
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 1, SET_NEVER),
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS), /* level */
    {STORE_DISCRETE, TYPE_INTEGER, SET_NEVER, 0},             /* count */
    COUNTER_VARIABLES,
};
const double model_start_parameters[1] = {0.9999};
const double model_nominal[2] = {1.0, 1.0};
const char *const model_unknown_names[2] = {"x", "w"};
const char *const model_discrete_names[2] = {"count", "above"};
const char *const model_initial_texts[2] = {"x = 1", "w = 0"};
const unsigned char model_relation_strict[1] = {1};
const char *const model_relation_texts[1] = {"x > level"};

void model_start(const double *p, double *v, double *d)
{
    (void)p;
    v[0] = 1.0;
    v[1] = 0.0;
    d[0] = 0.0;
    d[1] = 1.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = v[1];
    f[1] = -v[0];
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = 0.0, J[2] = 1.0;
    J[1] = -1.0, J[3] = 0.0;
}

void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g)
{
    ARGUMENTS_UNUSED;
    g[0] = v[0] - p[0];
}

int model_discrete(MODEL_CONTINUOUS_ARGUMENTS, const double *pre, const double *fired, int initial, double *d_new,
                   double *x_new)
{
    ARGUMENTS_UNUSED, (void)fired, (void)initial;
    d_new[1] = c[0];
    d_new[0] = pre[0] + (d_new[1] > pre[1]);
    x_new[0] = v[0];
    x_new[1] = v[1];
    return 0;
}
