/* SPDX-License-Identifier: Apache-2.0
 *
 * Seconds for many evaluations of a model's equations, one after the other, at points that come in turn.
 */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

#include "model.h"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* points: NV values each. */
double time_rhs(long rounds, int points, const double *v, const double *u, const double *p, const double *d,
                const double *c)
{
    double f[MODEL_ROOM(MODEL_NV)], begun = now();
    for (long k = 0; k < rounds; k++)
        for (int i = 0; i < points; i++) model_rhs(0.0, v + i * MODEL_NV, u, p, d, c, f);
    return now() - begun;
}

double time_linearise(long rounds, int points, const double *v, const double *u, const double *p, const double *d,
                      const double *c)
{
    double f[MODEL_ROOM(MODEL_NV)], f_t[MODEL_ROOM(MODEL_NV)], J[MODEL_ROOM(MODEL_NV * MODEL_NV)], begun = now();
    for (long k = 0; k < rounds; k++)
        for (int i = 0; i < points; i++) model_linearise(0.0, v + i * MODEL_NV, u, p, d, c, f, J, f_t);
    return now() - begun;
}
