/* SPDX-License-Identifier: MIT-0
 *
 * Whether a simulation has come to where the choice of states, made once for all, is singular: what else could be
 * states there.
 */
#include <math.h>
#include <stdio.h>

#include "simulation.h"

#if MODEL_NCONSTRAINTS == 0

int simulation_blame_selection(Simulation *m, const double *v)
{
    (void)m, (void)v;
    return 0;
}

int simulation_check_selection(Simulation *m)
{
    (void)m;
    return 1;
}

#else

/* What is not a state moves more than the reciprocal of this times faster than what is: they should change places. */
static const double SINGULAR = 1e-4;

/* The matrix of one set of constraints. */
typedef struct {
    int rows, columns;
    int first_row, first_column;                                     /* in the tables */
    double a[MODEL_CONSTRAINT_ROOM];                                 /* row by row */
    int row[MODEL_CONSTRAINT_ROWS], column[MODEL_CONSTRAINT_COLUMNS]; /* as permuted */
    int sign; /* of the determinant of the first columns; 0 if it is zero or not a number */
    Determinant size; /* its absolute value, if it is not zero */
} Matrix;

static double *at(Matrix *x, int i, int j)
{
    return &x->a[x->row[i] * x->columns + x->column[j]];
}

static void load(Matrix *x, int k, const double *entries)
{
    int first = 0;
    x->first_row = x->first_column = 0;
    for (int i = 0; i < k; i++) {
        x->first_row += model_constraints[i].rows;
        x->first_column += model_constraints[i].columns;
        first += model_constraints[i].entries;
    }
    x->rows = model_constraints[k].rows;
    x->columns = model_constraints[k].columns;
    x->sign = 1;
    x->size = (Determinant){1.0, 0};
    for (int i = 0; i < x->rows; i++) x->row[i] = i;
    for (int j = 0; j < x->columns; j++) x->column[j] = j;
    for (int i = 0; i < x->rows * x->columns; i++) x->a[i] = 0.0;
    for (int e = first; e < first + model_constraints[k].entries; e++)
        *at(x, model_constraint_row[e], model_constraint_column[e]) = entries[e];
}

/* Each row relative to its largest entry. */
static void scale_rows(Matrix *x)
{
    for (int i = 0; i < x->rows; i++) {
        double largest = 0.0;
        for (int j = 0; j < x->columns; j++) largest = fmax(largest, fabs(*at(x, i, j)));
        for (int j = 0; j < x->columns && largest > 0.0; j++) *at(x, i, j) /= largest;
    }
}

static void swap(Matrix *x, int *order, int i, int j)
{
    if (i == j) return;
    int swapped = order[i];
    order[i] = order[j];
    order[j] = swapped;
    x->sign = -x->sign;
}

/* Bring an entry to the diagonal as a pivot, which becomes a factor of the determinant; 0 if it is none. */
static double take_pivot(Matrix *x, int k, int row, int column)
{
    swap(x, x->row, k, row);
    swap(x, x->column, k, column);
    double pivot = *at(x, k, k);
    x->sign *= (pivot > 0.0) - (pivot < 0.0);
    if (x->sign == 0) return 0.0;
    int exponent;
    x->size.mantissa = frexp(x->size.mantissa * fabs(pivot), &exponent);
    x->size.exponent += exponent;
    return pivot;
}

static void eliminate_column(Matrix *x, int k, double pivot, int columns)
{
    for (int i = k + 1; i < x->rows; i++) {
        double factor = *at(x, i, k) / pivot;
        for (int j = k; factor != 0.0 && j < columns; j++) *at(x, i, j) -= factor * *at(x, k, j);
    }
}

/* Gaussian elimination, with pivots among the columns of what is not a state: the smallest comes last. */
static void triangularise(Matrix *x)
{
    for (int k = 0; k < x->rows; k++) {
        int row = k, column = k;
        for (int i = k; i < x->rows; i++)
            for (int j = k; j < x->rows; j++)
                if (fabs(*at(x, i, j)) > fabs(*at(x, row, column))) row = i, column = j;
        double pivot = take_pivot(x, k, row, column);
        if (pivot == 0.0) return;
        eliminate_column(x, k, pivot, x->columns);
    }
}

/* The same for the determinant alone. */
static void find_determinant(Matrix *x)
{
    for (int k = 0; k < x->rows; k++) {
        int row = k;
        for (int i = k + 1; i < x->rows; i++)
            if (fabs(*at(x, i, k)) > fabs(*at(x, row, k))) row = i;
        double pivot = take_pivot(x, k, row, k);
        if (pivot == 0.0) return;
        eliminate_column(x, k, pivot, x->rows);
    }
}

/* The equations of one block, in `text`. */
static void list_equations(const Matrix *x, int block, char *text, size_t size)
{
    size_t used = 0;
    int shown = 0;
    for (int i = x->first_row; i < x->first_row + x->rows && used < size; i++) {
        if (model_constraint_block[i] != block) continue;
        const char *equation = ++shown > 4 ? "..." : model_constraint_texts[i];
        used += (size_t)snprintf(text + used, size - used, "%s%s", shown > 1 ? ", " : "", equation);
        if (shown > 4) return;
    }
}

/* What the last row that the elimination has left says of the choice; nothing if it is regular, unless `passed`. */
static void judge(Simulation *m, Matrix *x, int passed)
{
    int last = x->rows - 1, best = last;
    double pivot = fabs(*at(x, last, last)), largest = 0.0;
    for (int j = x->rows; j < x->columns; j++)
        if (fabs(*at(x, last, j)) > largest) largest = fabs(*at(x, last, best = j));
    if (!passed && !(pivot < SINGULAR * largest)) return;
    const char *dependent = model_constraint_variables[x->first_column + x->column[last]];
    const char *state = model_constraint_variables[x->first_column + x->column[best]];
    char equations[600] = "";
    /* Rows and the columns of what is not a state have the same order in the tables. */
    list_equations(x, model_constraint_block[x->first_row + x->column[last]], equations, sizeof equations);
    simulation_fail(m,
                    "%s t = %.9g s the chosen states do not determine the other variables: %s cannot be computed from "
                    "%s by %s. There %s would do as states: give them stateSelect=StateSelect.prefer. If that fails "
                    "elsewhere, or this is a dead centre, no choice holds everywhere: describe the motion by other "
                    "variables, such as an angle, and prefer those.",
                    passed ? "Shortly before" : "At", m->s.t, dependent, state, equations, dependent);
}

int simulation_blame_selection(Simulation *m, const double *v)
{
    const State *s = &m->s;
    double entries[MODEL_CONSTRAINT_ENTRIES];
    model_constraint_entries(s->t, v, s->u, s->p, s->d, s->c, entries);
    for (int e = 0; e < MODEL_CONSTRAINT_ENTRIES; e++)
        if (!isfinite(entries[e])) return 0;
    for (int k = 0; k < MODEL_NCONSTRAINTS; k++) {
        Matrix x;
        load(&x, k, entries);
        scale_rows(&x);
        triangularise(&x);
        judge(m, &x, 0);
    }
    return 0;
}

void simulation_determinants(const Simulation *m, double t, const double *v, Determinant *determinant)
{
    const State *s = &m->s;
    double entries[MODEL_CONSTRAINT_ENTRIES];
    model_constraint_entries(t, v, s->u, s->p, s->d, s->c, entries);
    for (int e = 0; e < MODEL_CONSTRAINT_ENTRIES; e++)
        if (!isfinite(entries[e])) entries[e] = 0.0; /* of no size, so that nothing follows from it */
    for (int k = 0; k < MODEL_NCONSTRAINTS; k++) {
        Matrix x;
        load(&x, k, entries);
        find_determinant(&x);
        determinant[k] = (Determinant){x.sign * x.size.mantissa, x.size.exponent};
    }
}

int simulation_blame_passed(Simulation *m, const double *v, int k)
{
    const State *s = &m->s;
    double entries[MODEL_CONSTRAINT_ENTRIES];
    Matrix x;
    model_constraint_entries(s->t, v, s->u, s->p, s->d, s->c, entries);
    load(&x, k, entries);
    scale_rows(&x);
    triangularise(&x);
    judge(m, &x, 1);
    return 0;
}

int simulation_check_selection(Simulation *m)
{
    State *s = &m->s;
    double entries[MODEL_CONSTRAINT_ENTRIES];
    /* So seldom that it is cheap against the steps: a point that was passed stays passed. */
    if (s->counters[COUNTER_STEPS] % (MODEL_CONSTRAINT_ROWS * MODEL_CONSTRAINT_ROWS)) return 1;
    model_constraint_entries(s->t, s->v, s->u, s->p, s->d, s->c, entries);
    for (int k = 0; k < MODEL_NCONSTRAINTS; k++) {
        Matrix x;
        load(&x, k, entries);
        triangularise(&x);
        if (x.sign * s->selection_sign[k] < 0) {
            load(&x, k, entries);
            scale_rows(&x);
            triangularise(&x);
            judge(m, &x, 1);
            return 0;
        }
        s->selection_sign[k] = (signed char)x.sign;
    }
    return 1;
}

#endif
