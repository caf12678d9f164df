/* SPDX-License-Identifier: MIT-0
 * sizes: NX=2 NU=1 NP=3 NY=1 NVARIABLES=16
 *
 * x'' + omega^2 x = u with the energy as output.
 */
#define SAMPLE_PARAMETERS
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 1, SET_NEVER),
    REAL(STORE_DERIVATIVE, 1, SET_NEVER),
    REAL(STORE_INPUT, 0, SET_ALWAYS),
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS), /* omega */
    REAL(STORE_PARAMETER, 1, SET_BEFORE_INITIALIZATION_ENDS), /* start value of x */
    REAL(STORE_PARAMETER, 2, SET_NEVER),                      /* omega^2 */
    REAL(STORE_OUTPUT, 0, SET_NEVER),
    {STORE_INPUT, TYPE_BOOLEAN, SET_ALWAYS, 0}, /* the input once more, as a Boolean */
    COUNTER_VARIABLES,
};
const double model_start_inputs[1] = {0.0};
const double model_start_parameters[3] = {2.0, 1.0, 0.0};
const double model_nominal[2] = {1.0, 1.0};
const char *const model_unknown_names[2] = {"x", "w"};
const char *const model_initial_texts[2] = {"x = x_start", "w = 0"};

void model_parameters(double *p)
{
    p[2] = p[0] * p[0];
}

void model_start(const double *p, double *v, double *d)
{
    (void)d;
    v[0] = p[1];
    v[1] = 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = v[1];
    f[1] = u[0] - p[2] * v[0];
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = 0.0, J[2] = 1.0;
    J[1] = -p[2], J[3] = 0.0;
}

void model_outputs(MODEL_CONTINUOUS_ARGUMENTS, double *y)
{
    ARGUMENTS_UNUSED;
    y[0] = 0.5 * (v[1] * v[1] + p[2] * v[0] * v[0]);
}
