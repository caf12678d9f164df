/* SPDX-License-Identifier: Apache-2.0
 *
 * Repeats a macro step until the components agree at its end, as cosim/engine/coupling/_agreement.py explains.
 */
#define MOST_PASSES 40
#define CONTRACTS 0.3
#define ACCURACY 0.01
#define END_PROBE 1e-4
#define SINGULAR_PIVOT 1e-10
#define PIVOT_OF_GAIN_1 1e-7

/* The differences between what the sources give and what was taken; returns the largest over what is allowed. */
static double differences(const Engine *engine, const Coupling *c, double *residual) {
    double norm = 0.0;
    for (int64_t k = 0; k < c->n_cut; k++) {
        const int64_t i = c->cut[k];
        residual[k] = given_by(&c->links[i], engine->values) - c->end[i];
        const double allowed = ACCURACY * c->tolerance * larger(c->magnitudes[i], fabs(c->end[i]));
        const double ratio = fabs(residual[k]) / allowed;
        if (!(ratio <= norm)) norm = ratio;
    }
    return norm;
}

/* Find the matrix, that of the residuals' negative derivatives, by one step for each of its columns. */
static bool measure(Engine *engine, Coupling *c, double t, double h) {
    const int64_t n = c->n_cut;
    double *const ends = c->scratch + n * n;
    memcpy(ends, c->end, (size_t)c->n_links * sizeof(double));
    for (int64_t column = 0; column < n; column++) {
        const int64_t i = c->cut[column];
        if (!restore(engine, c, INNER)) return false;
        c->repeated++;
        memcpy(c->end, ends, (size_t)c->n_links * sizeof(double));
        const double probe = END_PROBE * larger(c->magnitudes[i], fabs(ends[i]));
        c->end[i] += probe;
        if (!take(engine, c, t, h, false)) return false;
        differences(engine, c, c->probed);
        for (int64_t row = 0; row < n; row++) {
            c->matrix[row * n + column] = (c->residual[row] - c->probed[row]) / probe;
        }
    }
    memcpy(c->end, ends, (size_t)c->n_links * sizeof(double));
    c->has_matrix = true;
    return true;
}

/* Let the matrix explain what has become of the residuals after a change of the unknowns that it asked for. */
static void mend(const Coupling *c) {
    const int64_t n = c->n_cut;
    double square = 0.0;
    for (int64_t k = 0; k < n; k++) square += c->change[k] * c->change[k];
    if (!(square > 0.0)) return;
    for (int64_t row = 0; row < n; row++) {
        for (int64_t column = 0; column < n; column++) {
            c->matrix[row * n + column] -= c->residual[row] * c->change[column] / square;
        }
    }
}

static void swap(double *a, double *b) {
    const double kept = *a;
    *a = *b;
    *b = kept;
}

/* Solve matrix * change = residual by elimination with row pivoting; false if the matrix is singular. */
static bool solve(const Coupling *c) {
    const int64_t n = c->n_cut;
    double *const a = c->scratch, *const x = c->change;
    memcpy(a, c->matrix, (size_t)(n * n) * sizeof(double));
    memcpy(x, c->residual, (size_t)n * sizeof(double));
    for (int64_t k = 0; k < n; k++) {
        int64_t pivot = k;
        double best = fabs(a[k * n + k]), size = 0.0;
        for (int64_t row = k; row < n; row++) {
            if (fabs(a[row * n + k]) > best) {
                pivot = row;
                best = fabs(a[row * n + k]);
            }
        }
        for (int64_t column = 0; column < n; column++) size = larger(size, fabs(c->matrix[pivot * n + column]));
        if (!(best > larger(SINGULAR_PIVOT * size, pivot == k ? PIVOT_OF_GAIN_1 : 0.0))) return false;
        if (pivot != k) {
            for (int64_t column = 0; column < n; column++) swap(&a[k * n + column], &a[pivot * n + column]);
            swap(&x[k], &x[pivot]);
        }
        for (int64_t row = k + 1; row < n; row++) {
            const double factor = a[row * n + k] / a[k * n + k];
            for (int64_t column = k; column < n; column++) a[row * n + column] -= factor * a[k * n + column];
            x[row] -= factor * x[k];
        }
    }
    for (int64_t k = n - 1; k >= 0; k--) {
        for (int64_t column = k + 1; column < n; column++) x[k] -= a[k * n + column] * x[column];
        x[k] /= a[k * n + k];
    }
    return true;
}

RARE bool disagree(Engine *engine, const Coupling *c, double t) {
    engine->failure.value = t;
    return fail(engine, c->members[0].component, DISAGREEMENT);
}

/* Step from t over h, from ends that are predicted already. */
static bool agree(Engine *engine, Coupling *c, double t, double h, bool recording) {
    if (!save(engine, c, INNER)) return false;
    double last = 0.0;
    bool measured = false;
    for (int passes = 0; passes < MOST_PASSES; passes++) {
        if (!take(engine, c, t, h, recording)) return false;
        const double norm = differences(engine, c, c->residual);
        if (norm <= 1.0) return true;
        if (passes > 0 && c->has_matrix) mend(c);
        if (passes > 0 && !(norm <= CONTRACTS * last) && !measured) {
            if (!measure(engine, c, t, h)) return false;
            measured = true;
        }
        last = norm;
        if (!c->has_matrix) {
            memcpy(c->change, c->residual, (size_t)c->n_cut * sizeof(double));
        } else if (!solve(c)) {
            break;
        }
        if (!restore(engine, c, INNER)) return false;
        c->repeated++;
        for (int64_t k = 0; k < c->n_cut; k++) c->end[c->cut[k]] += c->change[k];
    }
    return disagree(engine, c, t + h);
}
