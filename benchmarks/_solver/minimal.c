/* SPDX-License-Identifier: Apache-2.0
 *
 * The equations of minimal.py, which CasADi has written to minimal_functions.c, behind the interface of a model.
 */
#include "model.h"

int minimal_rhs(const double **arg, double **res, long long *iw, double *w, int mem);
int minimal_linearise(const double **arg, double **res, long long *iw, double *w, int mem);

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    (void)t, (void)p, (void)d, (void)c;
    minimal_rhs((const double *[]){v, u}, (double *[]){f}, 0, 0, 0);
}

void model_linearise(MODEL_CONTINUOUS_ARGUMENTS, double *f, double *J, double *ft)
{
    (void)t, (void)p, (void)d, (void)c;
    minimal_linearise((const double *[]){v, u}, (double *[]){f, J, ft}, 0, 0, 0);
}
