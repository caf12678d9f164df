/* SPDX-License-Identifier: Apache-2.0
 *
 * Follows a motion by collocation, interval by interval, together with its derivatives by q = [x0; theta].
 *
 * On an interval of length h that begins at x_b, the stages x_r satisfy, with the derivatives L[j][r] of the Lagrange
 * polynomials through 0 and Radau's nodes, and z_j given by x_j through the algebraic equations,
 *
 *     L[j][0] x_b + sum_r L[j][r+1] x_r = h f(x_j, z_j).
 *
 * Newton's method solves them; its last matrix gives the derivatives by the implicit function theorem.
 */
#include <math.h>
#include <string.h>

#include "equations.h" /* NX NZ NU NP NR STAGES, L, NODES, nominal sizes, and the functions that CasADi generates */

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#define NQ (NX + NP)
#define N (STAGES * NX)

/* What the equations are at the stages of one interval, and Newton's matrix for these; f_q by q, a column after another. */
typedef struct {
    double z[STAGES][NZ + 1 /* C has no arrays of length zero */], f[STAGES][NX], f_q[STAGES][NQ * NX];
    double matrix[N][N];
    int pivots[N];
} Interval;

/* LU factors by rows; on the diagonal stand the reciprocals. */
static int factorise(double a[N][N], int *pivots)
{
    for (int k = 0; k < N; k++) {
        int best = k;
        for (int i = k + 1; i < N; i++)
            if (fabs(a[i][k]) > fabs(a[best][k])) best = i;
        if (!(fabs(a[best][k]) > 0.0)) return 0;
        pivots[k] = best;
        if (best != k)
            for (int j = 0; j < N; j++) {
                double swapped = a[k][j];
                a[k][j] = a[best][j];
                a[best][j] = swapped;
            }
        a[k][k] = 1.0 / a[k][k];
        for (int i = k + 1; i < N; i++) {
            double factor = a[i][k] *= a[k][k];
            for (int j = k + 1; j < N; j++) a[i][j] -= factor * a[k][j];
        }
    }
    return 1;
}

/* Several right-hand sides at a time: b[i * columns + k]. */
static void solve(double a[N][N], const int *pivots, int columns, double *b)
{
    for (int k = 0; k < N; k++)
        for (int c = 0; c < columns && pivots[k] != k; c++) {
            double swapped = b[pivots[k] * columns + c];
            b[pivots[k] * columns + c] = b[k * columns + c];
            b[k * columns + c] = swapped;
        }
    for (int i = 1; i < N; i++)
        for (int k = 0; k < i; k++)
            for (int c = 0; c < columns; c++) b[i * columns + c] -= a[i][k] * b[k * columns + c];
    for (int i = N - 1; i >= 0; i--) {
        for (int k = i + 1; k < N; k++)
            for (int c = 0; c < columns; c++) b[i * columns + c] -= a[i][k] * b[k * columns + c];
        for (int c = 0; c < columns; c++) b[i * columns + c] *= a[i][i];
    }
}

/* The equations at the stages; their derivatives too, and the matrix of those, if these are to be new. */
static int evaluate(Interval *at, double h, const double *u, const double *p, const double *x, const double *z, int anew)
{
    for (int j = 0; j < STAGES; j++) {
        const double *arguments[4] = {x + j * NX, z + j * NZ, u + j * NU, p};
        double *results[3] = {at->z[j], at->f[j], at->f_q[j]};
        if (anew)
            point(arguments, results, 0, 0, 0);
        else
            value(arguments, results, 0, 0, 0);
    }
    if (!anew) return 1;
    for (int j = 0; j < STAGES; j++)
        for (int i = 0; i < NX; i++)
            for (int r = 0; r < STAGES; r++)
                for (int k = 0; k < NX; k++)
                    at->matrix[j * NX + i][r * NX + k] =
                        (i == k ? L[j][r + 1] : 0.0) - (r == j ? h * at->f_q[j][k * NX + i] : 0.0);
    return factorise(at->matrix, at->pivots);
}

/* One Newton step of the stages; returns how large it is beside the nominal sizes, or a negative number if it failed. */
static double improve(Interval *at, double h, const double *x_b, const double *u, const double *p, double *x, double *z,
                      int anew)
{
    double b[N], largest = 0.0;
    if (!evaluate(at, h, u, p, x, z, anew)) return -1.0;
    for (int j = 0; j < STAGES; j++)
        for (int i = 0; i < NX; i++) {
            double sum = L[j][0] * x_b[i] - h * at->f[j][i];
            for (int r = 0; r < STAGES; r++) sum += L[j][r + 1] * x[r * NX + i];
            b[j * NX + i] = -sum;
        }
    solve(at->matrix, at->pivots, 1, b);
    for (int j = 0; j < STAGES; j++) {
        for (int i = 0; i < NX; i++) {
            double moved = fabs(b[j * NX + i]) / X_NOMINAL[i];
            if (!(moved <= largest)) largest = moved;
            x[j * NX + i] += b[j * NX + i];
        }
        for (int i = 0; i < NZ; i++) {
            double moved = fabs(at->z[j][i] - z[j * NZ + i]) / Z_NOMINAL[i];
            if (!(moved <= largest)) largest = moved;
            z[j * NZ + i] = at->z[j][i];
        }
    }
    return isfinite(largest) ? largest : -1.0;
}

/* Solve for the stages from a guess; return whether that succeeded. Derivatives are renewed where they are too old. */
static int settle(Interval *at, double h, const double *x_b, const double *u, const double *p, double *x, double *z,
                  double tolerance, int most)
{
    int anew = 1;
    double before = INFINITY;
    for (int k = 0; k < most; k++) {
        double moved = improve(at, h, x_b, u, p, x, z, anew);
        if (moved < 0.0) return 0;
        if (moved <= tolerance) return 1;
        anew = moved > 0.1 * before;
        before = moved;
    }
    return 0;
}

/* The derivatives s of the stages' states by q, from those of the state in which the interval begins. */
static void differentiate(Interval *at, double h, const double *s_b, double *s)
{
    for (int j = 0; j < STAGES; j++)
        for (int i = 0; i < NX; i++)
            for (int q = 0; q < NQ; q++)
                s[(j * NX + i) * NQ + q] = (q < NX ? 0.0 : h * at->f_q[j][q * NX + i]) - L[j][0] * s_b[i * NQ + q];
    solve(at->matrix, at->pivots, NQ, s);
}

static double polynomial(double t, int r)
{
    double value = 1.0;
    for (int k = 0; k <= STAGES; k++)
        if (k != r) value *= (t - NODES[k]) / (NODES[r] - NODES[k]);
    return value;
}

/* Stages of an interval as the polynomials of the one before it go on; z, that has no value at its begin, stays. */
static void extrapolate(double ratio, const double *x_before, double *x, const double *z_before, double *z)
{
    for (int j = 0; j < STAGES; j++) {
        double t = 1.0 + NODES[j + 1] * ratio;
        memset(x + j * NX, 0, NX * sizeof *x);
        for (int r = 0; r <= STAGES; r++)
            for (int i = 0; i < NX; i++) x[j * NX + i] += polynomial(t, r) * x_before[r * NX + i];
        memcpy(z + j * NZ, z_before + (STAGES - 1) * NZ, NZ * sizeof *z);
    }
}

/* Follow a motion over `count` intervals of lengths h; return over how many that succeeded.
 *
 * u, x, z: inputs, states, unknowns at all stages of all intervals, one after another; in x and s the state at the
 * beginning and its derivatives stand before them. In `known` intervals x and z hold guesses when called; of the first
 * one they have to. s: derivatives by q, for each state a row; as exact as the guess was near. */
EXPORT int follow(int count, int known, const double *h, const double *u, const double *p, double *x, double *z, double *s,
                  double tolerance, int most)
{
    Interval at;
    for (int k = 0; k < count; k++) {
        double *x_k = x + (k * STAGES + 1) * NX, *z_k = z + k * STAGES * NZ;
        const double *x_b = x_k - NX, *u_k = u + k * STAGES * NU;
        int done = k < known && settle(&at, h[k], x_b, u_k, p, x_k, z_k, tolerance, most);
        if (!done && k > 0) {
            extrapolate(h[k] / h[k - 1], x_b - N, x_k, z_k - STAGES * NZ, z_k);
            done = settle(&at, h[k], x_b, u_k, p, x_k, z_k, tolerance, most);
        }
        if (!done) return k;
        double *s_k = s + (k * STAGES + 1) * NX * NQ;
        differentiate(&at, h[k], s_k - NX * NQ, s_k);
    }
    return count;
}

/* The current, or else the torque, at `count` points, and its derivatives by q from those of the states. */
EXPORT void measure(int torque, int count, const double *x, const double *z, const double *u, const double *p,
                    const double *s, double *y, double *y_q)
{
    for (int k = 0; k < count; k++) {
        const double *arguments[4] = {x + k * NX, z + k * NZ, u + k * NU, p};
        double *results[2] = {y + k, y_q + k * NQ};
        (torque ? tau_crank : i_motor)(arguments, results, 0, 0, 0);
        double by_x[NX];
        for (int i = 0; i < NX; i++) by_x[i] = y_q[k * NQ + i];
        for (int q = 0; q < NQ; q++) {
            double sum = q < NX ? 0.0 : y_q[k * NQ + q];
            for (int i = 0; i < NX; i++) sum += by_x[i] * s[(k * NX + i) * NQ + q];
            y_q[k * NQ + q] = sum;
        }
    }
}

/* Residuals of `samples`, each interpolated by `weights` from four rows of `points` from `first` on, in which the value is
 * followed by its derivatives by q; their sums: the loss, the squares, gradient and, row by row, Hessian without their
 * curvature. The loss of a residual r is r^2/2, or from about `turn` on linear: turn^2 (sqrt(1 + (r/turn)^2) - 1). */
EXPORT void gather(int samples, const int *first, const double *weights, const double *points, const double *measured,
                   double turn, double *loss, double *squares, double *gradient, double *hessian)
{
    for (int s = 0; s < samples; s++) {
        double row[1 + NQ] = {0.0}, weight = 1.0;
        for (int k = 0; k < 4; k++)
            for (int c = 0; c <= NQ; c++) row[c] += weights[4 * s + k] * points[(first[s] + k) * (1 + NQ) + c];
        double r = row[0] - measured[s];
        *squares += r * r;
        if (isfinite(turn)) {
            double root = sqrt(1.0 + (r / turn) * (r / turn));
            *loss += turn * turn * (root - 1.0);
            weight = 1.0 / root;
        } else
            *loss += 0.5 * r * r;
        for (int a = 0; a < NQ; a++) {
            double weighted = weight * row[1 + a];
            gradient[a] += weighted * r;
            for (int b = 0; b <= a; b++) hessian[a * NQ + b] += weighted * row[1 + b];
        }
    }
    for (int a = 0; a < NQ; a++)
        for (int b = 0; b < a; b++) hessian[b * NQ + a] = hessian[a * NQ + b];
}

/* All parameters from the independent ones. */
EXPORT void all_parameters(const double *free, double *all)
{
    parameters(&free, &all, 0, 0, 0);
}

/* The indicators of the relations that are held, at `count` points. */
EXPORT void held_relations(int count, const double *x, const double *z, const double *u, const double *p, double *g)
{
    for (int k = 0; k < count; k++) {
        const double *arguments[4] = {x + k * NX, z + k * NZ, u + k * NU, p};
        double *result = g + k * NR;
        relations(arguments, &result, 0, 0, 0);
    }
}
