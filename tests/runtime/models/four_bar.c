/* SPDX-License-Identifier: MIT-0
 * sizes: NX=1 NZ=2 NP=4 NVARIABLES=14
 *
 * A crank-rocker four-bar: crank a turned at 1 rad/s, coupler f, rocker b, ground g. The start values of zero are a
 * singular point of the closure equations. The angles of coupler and rocker are the algebraic unknowns.
 */
#include "sample.h"

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER), /* crank */
    REAL(STORE_UNKNOWN, 1, SET_NEVER), /* coupler */
    REAL(STORE_UNKNOWN, 2, SET_NEVER), /* rocker */
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS), /* a */
    REAL(STORE_PARAMETER, 1, SET_BEFORE_INITIALIZATION_ENDS), /* f */
    REAL(STORE_PARAMETER, 2, SET_BEFORE_INITIALIZATION_ENDS), /* b */
    REAL(STORE_PARAMETER, 3, SET_BEFORE_INITIALIZATION_ENDS), /* g */
    COUNTER_VARIABLES,
};
const double model_start_parameters[4] = {0.055, 0.4359377, 0.07644, 0.4495446};
const double model_nominal[3] = {1.0, 1.0, 1.0};
const char *const model_unknown_names[3] = {"crank", "coupler", "rocker"};
const char *const model_initial_texts[3] = {"crank = 0", "closure in x", "closure in y"};

void model_start(const double *p, double *v, double *d)
{
    (void)p, (void)d;
    v[0] = v[1] = v[2] = 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    f[0] = 1.0;
    f[1] = p[0] * cos(v[0]) + p[1] * cos(v[1]) - p[2] * cos(v[2]) - p[3];
    f[2] = p[0] * sin(v[0]) + p[1] * sin(v[1]) - p[2] * sin(v[2]);
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = 0.0, J[3] = 0.0, J[6] = 0.0;
    J[1] = -p[0] * sin(v[0]), J[4] = -p[1] * sin(v[1]), J[7] = p[2] * sin(v[2]);
    J[2] = p[0] * cos(v[0]), J[5] = p[1] * cos(v[1]), J[8] = -p[2] * cos(v[2]);
}
