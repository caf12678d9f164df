/* SPDX-License-Identifier: MIT-0
 *
 * What a function may do between the points at which it has been looked at.
 */
#ifndef COSIM_CUBIC_H
#define COSIM_CUBIC_H

#include <math.h>

enum { CUBIC_POINTS = 4 };

/* Extrema of the cubic through four equidistant values, in units of the distance; returns how many lie inside. */
static inline int cubic_extrema(const double g[CUBIC_POINTS], double at[2])
{
    double first = g[1] - g[0], second = g[2] - 2.0 * g[1] + g[0], third = g[3] - 3.0 * g[2] + 3.0 * g[1] - g[0];
    double a = 0.5 * third, b = second - third, c = first - 0.5 * second + third / 3.0;
    double discriminant = b * b - 4.0 * a * c;
    if (!(discriminant >= 0.0)) return 0;
    double q = -0.5 * (b + copysign(sqrt(discriminant), b));
    double roots[2] = {q / a, c / q};
    int n = 0;
    for (int i = 0; i < 2; i++)
        if (roots[i] > 0.0 && roots[i] < CUBIC_POINTS - 1) at[n++] = roots[i];
    return n;
}

#endif
