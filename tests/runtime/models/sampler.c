/* SPDX-License-Identifier: MIT-0
 * sizes: NX=1 NU=1 NP=4 ND=4 NG=1 NS=2 NY=1 NVARIABLES=18
 *
 * when sample(start, interval) then count = pre(count) + 1; hold = u; odd = not pre(odd); end when;
 * when sample(0, interval2) then level = mod(pre(level), 3) + 1; end when;
 * x' = hold; y = x + u.
 */
#define SAMPLE_DISCRETE
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_INPUT, 0, SET_ALWAYS),
    {STORE_DISCRETE, TYPE_INTEGER, SET_NEVER, 0}, /* count */
    REAL(STORE_DISCRETE, 1, SET_NEVER),           /* hold */
    {STORE_DISCRETE, TYPE_BOOLEAN, SET_NEVER, 2}, /* odd */
    {STORE_DISCRETE, TYPE_ENUMERATION, SET_NEVER, 3}, /* level, 1..3 */
    REAL(STORE_UNKNOWN, 0, SET_NEVER),                        /* x */
    REAL(STORE_OUTPUT, 0, SET_NEVER),                         /* y */
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS), /* interval */
    REAL(STORE_PARAMETER, 1, SET_BEFORE_INITIALIZATION_ENDS), /* start */
    REAL(STORE_PARAMETER, 2, SET_BEFORE_INITIALIZATION_ENDS), /* interval2 */
    REAL(STORE_PARAMETER, 3, SET_BEFORE_INITIALIZATION_ENDS), /* when a relation changes, with no other effect */
    COUNTER_VARIABLES,
};
const double model_start_inputs[1] = {0.0};
const double model_start_parameters[4] = {0.1, 0.0, 1000.0, 1e9};
const double model_nominal[1] = {1.0};
const char *const model_unknown_names[1] = {"x"};
const char *const model_discrete_names[4] = {"count", "held", "toggle", "phase"};
const char *const model_initial_texts[1] = {"x = 0"};
const unsigned char model_relation_strict[1] = {0};
const char *const model_relation_texts[1] = {"time >= change"};

void model_start(const double *p, double *v, double *d)
{
    (void)p;
    v[0] = 0.0;
    d[0] = d[1] = d[2] = 0.0;
    d[3] = 1.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = d[1];
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = 0.0;
}

void model_clocks(const double *p, double *start, double *interval)
{
    start[0] = p[1];
    interval[0] = p[0];
    start[1] = 0.0;
    interval[1] = p[2];
}

void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g)
{
    ARGUMENTS_UNUSED;
    g[0] = t - p[3];
}

void model_outputs(MODEL_CONTINUOUS_ARGUMENTS, double *y)
{
    ARGUMENTS_UNUSED;
    y[0] = v[0] + u[0];
}

int model_discrete(MODEL_CONTINUOUS_ARGUMENTS, const double *pre, const double *fired, int initial, double *d_new,
                   double *x_new)
{
    ARGUMENTS_UNUSED, (void)initial;
    int tick = fired[0] != 0.0;
    d_new[0] = pre[0] + tick;
    d_new[1] = tick ? u[0] : pre[1];
    d_new[2] = tick ? 1.0 - pre[2] : pre[2];
    d_new[3] = fired[1] != 0.0 ? fmod(pre[3], 3.0) + 1.0 : pre[3];
    x_new[0] = v[0];
    return 0;
}
