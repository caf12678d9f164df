/* SPDX-License-Identifier: MIT-0
 *
 * Dense LU factorisation with partial pivoting. Matrices are column-major: A[column * n + row].
 */
#ifndef COSIM_LU_H
#define COSIM_LU_H

/* Factorise A in place, into a form that only lu_solve reads. Returns 0, or 1 + the column in which no pivot is left
 * (singular, or not a number). */
int lu_factor(int n, double *A, int *pivots);

/* Solve A x = b in place with a factorised A. */
void lu_solve(int n, const double *A, const int *pivots, double *b);

#endif
