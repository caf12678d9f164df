/* SPDX-License-Identifier: MIT-0
 * sizes: NX=2 NZ=1 NVARIABLES=10
 *
 * Robertson's reaction as an index-1 DAE: the third concentration follows from conservation of mass.
 */
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 1, SET_NEVER),
    REAL(STORE_UNKNOWN, 2, SET_NEVER),
    COUNTER_VARIABLES,
};
const double model_nominal[3] = {1.0, 1e-5, 1.0};
const char *const model_unknown_names[3] = {"a", "b", "c"};
const char *const model_initial_texts[3] = {"a = 1", "b = 0", "a + b + c = 1"};

void model_start(const double *p, double *v, double *d)
{
    (void)p, (void)d;
    v[0] = 1.0;
    v[1] = v[2] = 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = -0.04 * v[0] + 1e4 * v[1] * v[2];
    f[1] = 0.04 * v[0] - 1e4 * v[1] * v[2] - 3e7 * v[1] * v[1];
    f[2] = v[0] + v[1] + v[2] - 1.0;
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = -0.04, J[3] = 1e4 * v[2], J[6] = 1e4 * v[1];
    J[1] = 0.04, J[4] = -1e4 * v[2] - 6e7 * v[1], J[7] = -1e4 * v[1];
    J[2] = 1.0, J[5] = 1.0, J[8] = 1.0;
}
