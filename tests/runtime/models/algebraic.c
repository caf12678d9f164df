/* SPDX-License-Identifier: MIT-0
 * sizes: NX=1 NZ=2 NU=1 NG=1 NY=1 NL=2 NVARIABLES=15
 *
 * x' = -z1, 0 = z1^3 + z1 - x - u - (if z1 > 0.5 then 0.1 else 0), 0 = z2 - exp(-z1), y = z1 + z2; as locals the two
 * residuals.
 */
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),    REAL(STORE_UNKNOWN, 0, SET_NEVER), REAL(STORE_UNKNOWN, 1, SET_NEVER),
    REAL(STORE_UNKNOWN, 2, SET_NEVER), REAL(STORE_INPUT, 0, SET_ALWAYS),  REAL(STORE_OUTPUT, 0, SET_NEVER),
    REAL(STORE_LOCAL, 0, SET_NEVER),   REAL(STORE_LOCAL, 1, SET_NEVER),   REAL(STORE_DERIVATIVE, 0, SET_NEVER),
    COUNTER_VARIABLES,
};
const double model_start_inputs[1] = {0.0};
const double model_nominal[3] = {1.0, 1.0, 1.0};
const char *const model_unknown_names[3] = {"x", "z1", "z2"};
const char *const model_initial_texts[3] = {"x = 2", "z1^3 + z1 = x + u", "z2 = exp(-z1)"};
const unsigned char model_relation_strict[1] = {1};
const char *const model_relation_texts[1] = {"z1 > 0.5"};

void model_start(const double *p, double *v, double *d)
{
    (void)p, (void)d;
    v[0] = 2.0;
    v[1] = v[2] = 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = -v[1];
    f[1] = v[1] * v[1] * v[1] + v[1] - v[0] - u[0] - 0.1 * c[0];
    f[2] = v[2] - exp(-v[1]);
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = 0.0, J[3] = -1.0, J[6] = 0.0;
    J[1] = -1.0, J[4] = 3.0 * v[1] * v[1] + 1.0, J[7] = 0.0;
    J[2] = 0.0, J[5] = exp(-v[1]), J[8] = 1.0;
}

void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g)
{
    ARGUMENTS_UNUSED;
    g[0] = v[1] - 0.5;
}

void model_outputs(MODEL_CONTINUOUS_ARGUMENTS, double *y)
{
    ARGUMENTS_UNUSED;
    y[0] = v[1] + v[2];
}

void model_locals(MODEL_CONTINUOUS_ARGUMENTS, double *l)
{
    double f[MODEL_NV];
    model_rhs(t, v, u, p, d, c, f);
    l[0] = f[1];
    l[1] = f[2];
}
