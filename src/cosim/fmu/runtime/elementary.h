/* SPDX-License-Identifier: MIT-0
 *
 * What the generated code calls besides the C library.
 */
#ifndef COSIM_ELEMENTARY_H
#define COSIM_ELEMENTARY_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Sine and cosine, which a mechanism spends much of its time on: twice as fast as a C library's where both are wanted of
 * one angle, and the same bits on every platform. The error is below 2.5 units in the last place.
 *
 * The angle is folded to [-pi/4, pi/4] with pi/2 in three parts of 33 bits (Cody and Waite); the polynomials have the
 * coefficients of Sun's fdlibm, k_sin.c and k_cos.c. Larger angles than 1e5 go to the C library: up to there the products
 * of the first two parts with the number of quarter turns are exact. */
typedef struct {
    double sine, cosine;    /* of the angle after folding */
    uint64_t quarter_turns; /* taken off by folding; the last two bits count */
} Folded;

static inline Folded fold(double x)
{
    const double shift = 6755399441055744.0; /* 1.5 * 2^52: the last bits of a sum with it are the nearest integer */
    double shifted = x * 0.63661977236758134308 + shift, k = shifted - shift;
    double r = ((x - k * 1.57079632673412561417) - k * 6.07710050630396597660e-11) - k * 2.02226624879595063154e-21;
    double z = r * r, w = z * z;
    double s = (-1.66666666666666324348e-01 + z * 8.33333333332248946124e-03) +
               w * ((-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06) +
                    w * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10));
    double c = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) +
               w * ((2.48015872894767294178e-05 + z * -2.75573143513906633035e-07) +
                    w * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11));
    Folded f = {r + r * z * s, 1.0 - (0.5 * z - w * c), 0};
    memcpy(&f.quarter_turns, &shifted, sizeof shifted);
    return f;
}

static inline double model_sin(double x)
{
    if (!(fabs(x) < 1e5)) return sin(x);
    Folded f = fold(x);
    double value = f.quarter_turns & 1 ? f.cosine : f.sine;
    return f.quarter_turns & 2 ? -value : value;
}

static inline double model_cos(double x)
{
    if (!(fabs(x) < 1e5)) return cos(x);
    Folded f = fold(x);
    double value = f.quarter_turns & 1 ? f.sine : f.cosine;
    return (f.quarter_turns + 1) & 2 ? -value : value;
}

/* Whether any of n numbers is none. One comparison takes two of them, and the mask is as wide as they are, since a long filter has a
 * thousand. */
static inline int model_has_nan(const double *x, int n)
{
    int64_t found = 0;
    int half = n / 2;
    for (int i = 0; i < half; i++) found |= isunordered(x[i], x[half + i]);
    return found || (n % 2 && isnan(x[n - 1]));
}

#endif
