/* SPDX-License-Identifier: MIT-0
 * sizes: NX=4 NZ=4 NU=1 NVARIABLES=12
 *
 * Four nonlinear oscillating reservoirs joined by four algebraic flows, every unknown coupled to every other:
 * the size of a typical torn model, for timing and for convergence.
 */
#define SAMPLE_TIME_DERIVATIVE
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),    REAL(STORE_UNKNOWN, 0, SET_NEVER), REAL(STORE_UNKNOWN, 3, SET_NEVER),
    REAL(STORE_UNKNOWN, 4, SET_NEVER), REAL(STORE_UNKNOWN, 7, SET_NEVER), REAL(STORE_INPUT, 0, SET_ALWAYS),
    COUNTER_VARIABLES,
};
const double model_start_inputs[1] = {0.0};
const double model_nominal[8] = {1, 1, 1, 1, 1, 1, 1, 1};
const char *const model_unknown_names[8] = {"x1", "x2", "x3", "x4", "z1", "z2", "z3", "z4"};
const char *const model_initial_texts[8] = {"x1 = 1", "x2 = 2", "x3 = 3", "x4 = 4", "f1", "f2", "f3", "f4"};

void model_start(const double *p, double *v, double *d)
{
    (void)p, (void)d;
    for (int i = 0; i < 8; i++) v[i] = i < 4 ? i + 1.0 : 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    double sum_x = 0.0, sum_z = 0.0;
    for (int i = 0; i < 4; i++) sum_x += v[i], sum_z += v[4 + i];
    for (int i = 0; i < 4; i++) {
        f[i] = v[4 + i] - 0.1 * sum_z + cos(t) + u[0];
        f[4 + i] = 4.0 * v[4 + i] + v[4 + i] * v[4 + i] * v[4 + i] + 0.2 * sum_z + (i + 1.0) * v[i] + 0.1 * sum_x;
    }
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++) {
            J[j * 8 + i] = 0.0;
            J[j * 8 + 4 + i] = 0.1 + (i == j ? i + 1.0 : 0.0);
            J[(4 + j) * 8 + i] = (i == j) - 0.1;
            J[(4 + j) * 8 + 4 + i] = 0.2 + (i == j ? 4.0 + 3.0 * v[4 + i] * v[4 + i] : 0.0);
        }
}

void model_time_derivative(MODEL_CONTINUOUS_ARGUMENTS, double *ft)
{
    ARGUMENTS_UNUSED;
    for (int i = 0; i < 8; i++) ft[i] = i < 4 ? -sin(t) : 0.0;
}
