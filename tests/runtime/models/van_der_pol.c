/* SPDX-License-Identifier: MIT-0
 * sizes: NX=2 NP=1 NVARIABLES=10
 *
 * x'' = mu (1 - x^2) x' - x, stiff for large mu.
 */
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 1, SET_NEVER),
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS), /* mu */
    COUNTER_VARIABLES,
};
const double model_start_parameters[1] = {1000.0};
const double model_nominal[2] = {1.0, 1.0};
const char *const model_unknown_names[2] = {"x", "w"};
const char *const model_initial_texts[2] = {"x = 2", "w = 0"};

void model_start(const double *p, double *v, double *d)
{
    (void)p, (void)d;
    v[0] = 2.0;
    v[1] = 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = v[1];
    f[1] = p[0] * (1.0 - v[0] * v[0]) * v[1] - v[0];
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = 0.0, J[2] = 1.0;
    J[1] = -2.0 * p[0] * v[0] * v[1] - 1.0, J[3] = p[0] * (1.0 - v[0] * v[0]);
}
