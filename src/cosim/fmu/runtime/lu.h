/* SPDX-License-Identifier: MIT-0
 *
 * Dense LU factorisation with partial pivoting. Matrices are column-major: A[column * n + row].
 *
 * The functions stand in the header because n is a constant where they are called: with it the loops, which take most
 * of a solver step's arithmetic, are unrolled.
 */
#ifndef COSIM_LU_H
#define COSIM_LU_H

#include <math.h>
#include <string.h>

/* Bring the row with the largest entry of column k, from row k on, to row k. Returns the reciprocal of that entry, 0 if
 * there is no pivot (singular, or not a number). */
static inline double lu_pivot(int n, double *A, int *pivots, int k)
{
    int pivot = k;
    for (int i = k + 1; i < n; i++)
        if (fabs(A[k * n + i]) > fabs(A[k * n + pivot])) pivot = i;
    pivots[k] = pivot;
    if (pivot != k)
        for (int j = 0; j < n; j++) {
            double swapped = A[j * n + k];
            A[j * n + k] = A[j * n + pivot];
            A[j * n + pivot] = swapped;
        }
    double inverse = 1.0 / A[k * n + k];
    return isfinite(inverse) ? inverse : 0.0;
}

/* Factorise A in place, into a form that only lu_solve reads. Returns 0, or 1 + the column in which no pivot is left
 * (singular, or not a number). */
static inline int lu_factor(int n, double *A, int *pivots)
{
    for (int k = 0; k < n; k++) {
        double *column = A + k * n, inverse = lu_pivot(n, A, pivots, k);
        if (inverse == 0.0) return k + 1;
        /* Kept inverted: a division in lu_solve would cost more than the rest of its row. */
        column[k] = inverse;
        for (int i = k + 1; i < n; i++) column[i] *= inverse;
        for (int j = k + 1; j < n; j++) {
            double *updated = A + j * n;
            double factor = updated[k];
            /* Torn models have sparse Jacobians: most of these are zero. */
            if (factor == 0.0) continue;
            for (int i = k + 1; i < n; i++) updated[i] -= column[i] * factor;
        }
    }
    return 0;
}

/* Solve A x = b in place with a factorised A. */
static inline void lu_solve(int n, const double *A, const int *pivots, double *b)
{
    /* Rows were swapped as a whole, the finished part of L included, so all swaps come first. */
    for (int k = 0; k < n; k++) {
        double swapped = b[k];
        b[k] = b[pivots[k]];
        b[pivots[k]] = swapped;
    }
    for (int k = 0; k < n; k++) {
        const double *column = A + k * n;
        double factor = b[k];
        if (factor == 0.0) continue;
        for (int i = k + 1; i < n; i++) b[i] -= column[i] * factor;
    }
    for (int k = n - 1; k >= 0; k--) {
        const double *column = A + k * n;
        if (b[k] == 0.0) continue;
        double value = b[k] *= column[k];
        for (int i = 0; i < k; i++) b[i] -= column[i] * value;
    }
}

/* Up to this size a matrix that many right-hand sides meet is inverted: to multiply by the inverse takes as many
 * operations as to solve with L and U, but these do not wait for each other. */
enum { LU_INVERTED = 8 };

/* Invert A in place by Gauss-Jordan elimination with partial pivoting. */
static inline int lu_invert(int n, double *A, int *pivots)
{
    for (int k = 0; k < n; k++) {
        double *column = A + k * n, inverse = lu_pivot(n, A, pivots, k);
        if (inverse == 0.0) return k + 1;
        column[k] = 0.0;
        for (int j = 0; j < n; j++) {
            double *updated = A + j * n, factor = updated[k] * inverse;
            if (j == k || factor == 0.0) continue;
            for (int i = 0; i < n; i++) updated[i] -= column[i] * factor;
            updated[k] = factor;
        }
        for (int i = 0; i < n; i++) column[i] *= -inverse;
        column[k] = inverse;
    }
    /* Rows were exchanged; of the inverse these are columns. */
    for (int k = n - 1; k >= 0; k--)
        if (pivots[k] != k)
            for (int i = 0; i < n; i++) {
                double swapped = A[k * n + i];
                A[k * n + i] = A[pivots[k] * n + i];
                A[pivots[k] * n + i] = swapped;
            }
    return 0;
}

/* Make A ready for lu_apply: its inverse if it is small, else its factors. Returns what lu_factor returns. */
static inline int lu_prepare(int n, double *A, int *pivots)
{
    return n > LU_INVERTED ? lu_factor(n, A, pivots) : lu_invert(n, A, pivots);
}

/* x = A^-1 b with what lu_prepare made of A; x and b are different arrays. */
static inline void lu_apply(int n, const double *A, const int *pivots, const double *b, double *x)
{
    if (n > LU_INVERTED) {
        memcpy(x, b, (size_t)n * sizeof *x);
        lu_solve(n, A, pivots, x);
        return;
    }
    for (int i = 0; i < n; i++) x[i] = 0.0;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) x[i] += A[j * n + i] * b[j];
}

#endif
