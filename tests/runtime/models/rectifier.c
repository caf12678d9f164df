/* SPDX-License-Identifier: MIT-0
 * sizes: NX=1 NP=3 NG=2 NVARIABLES=11
 *
 * Half-wave rectifier with an ideal diode: L i' = if i > 0 or v > 0 then v - R i else 0, v = sin(omega t).
 */
#define SAMPLE_TIME_DERIVATIVE
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER),
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS), /* R */
    REAL(STORE_PARAMETER, 1, SET_BEFORE_INITIALIZATION_ENDS), /* L */
    REAL(STORE_PARAMETER, 2, SET_BEFORE_INITIALIZATION_ENDS), /* omega */
    COUNTER_VARIABLES,
};
const double model_start_parameters[3] = {1.0, 0.01, 314.0};
const double model_nominal[1] = {1.0};
const char *const model_unknown_names[1] = {"i"};
const char *const model_initial_texts[1] = {"i = 0"};
const unsigned char model_relation_strict[2] = {1, 1};
const char *const model_relation_texts[2] = {"i > 0", "v > 0"};

void model_start(const double *p, double *v, double *d)
{
    (void)p, (void)d;
    v[0] = 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    int conducts = c[0] != 0.0 || c[1] != 0.0;
    f[0] = conducts ? (sin(p[2] * t) - p[0] * v[0]) / p[1] : 0.0;
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = c[0] != 0.0 || c[1] != 0.0 ? -p[0] / p[1] : 0.0;
}

void model_time_derivative(MODEL_CONTINUOUS_ARGUMENTS, double *ft)
{
    ARGUMENTS_UNUSED;
    ft[0] = c[0] != 0.0 || c[1] != 0.0 ? p[2] * cos(p[2] * t) / p[1] : 0.0;
}

void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g)
{
    ARGUMENTS_UNUSED;
    g[0] = v[0];
    g[1] = sin(p[2] * t);
}
