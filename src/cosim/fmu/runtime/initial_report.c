/* SPDX-License-Identifier: MIT-0
 *
 * Why the initial equations have no solution: which equations, with their residuals, or which depend on each other, and
 * which unknowns they leave open.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "simulation.h"

/* Pivots of the scaled Jacobian below this are rounding errors; so are entries of its null vectors. */
static const double NEGLIGIBLE = 1e-9;
enum { SHOWN = 6 };

/* A list in the making. */
typedef struct {
    char text[440];
    size_t used;
    int items;
} List;

static void add(List *list, const char *item, const char *separator)
{
    if (++list->items > SHOWN || list->used >= sizeof list->text) return;
    list->used += (size_t)snprintf(list->text + list->used, sizeof list->text - list->used, "%s%s",
                                   list->items > 1 ? separator : "", item);
}

static void add_equation(const Simulation *m, List *list, int i)
{
    char item[300];
    double r = m->newton.r[i];
    if (fabs(r) <= NEGLIGIBLE)
        snprintf(item, sizeof item, "%s", model_initial_texts[i]);
    else
        snprintf(item, sizeof item, "%s (residual %.3g)", model_initial_texts[i], r);
    add(list, item, "; ");
}

/* The three largest residuals. */
static void list_residuals(Simulation *m, List *list)
{
    double *r = m->newton.r;
    for (int rank = 0; rank < 3; rank++) {
        int worst = -1;
        for (int i = 0; i < MODEL_NV; i++)
            if (r[i] != 0.0 && (worst < 0 || isnan(r[i]) || fabs(r[i]) > fabs(r[worst]))) worst = i;
        if (worst < 0) return;
        add_equation(m, list, worst);
        r[worst] = 0.0;
    }
}

static void swap_rows(double *A, int i, int j)
{
    for (int k = 0; k < MODEL_NV && i != j; k++) {
        double swapped = A[k * MODEL_NV + i];
        A[k * MODEL_NV + i] = A[k * MODEL_NV + j];
        A[k * MODEL_NV + j] = swapped;
    }
}

/* Gauss-Jordan elimination of A with complete pivoting; the same row operations on B, columns stay in place: pivot k is
 * at row k, column order[k]. Returns the rank. */
static int reduce(double *A, double *B, int *order)
{
    for (int j = 0; j < MODEL_NV; j++) order[j] = j;
    for (int k = 0; k < MODEL_NV; k++) {
        int row = k, column = k;
        for (int j = k; j < MODEL_NV; j++)
            for (int i = k; i < MODEL_NV; i++)
                if (fabs(A[order[j] * MODEL_NV + i]) > fabs(A[order[column] * MODEL_NV + row])) row = i, column = j;
        int swapped = order[k];
        order[k] = order[column];
        order[column] = swapped;
        double pivot = A[order[k] * MODEL_NV + row];
        if (!(fabs(pivot) > NEGLIGIBLE)) return k;
        swap_rows(A, k, row);
        swap_rows(B, k, row);
        for (int i = 0; i < MODEL_NV; i++) {
            double factor = A[order[k] * MODEL_NV + i] / pivot;
            for (int j = 0; j < MODEL_NV && i != k && factor != 0.0; j++) {
                A[j * MODEL_NV + i] -= factor * A[j * MODEL_NV + k];
                B[j * MODEL_NV + i] -= factor * B[j * MODEL_NV + k];
            }
        }
    }
    return MODEL_NV;
}

/* The unknowns that the Jacobian at s.v leaves open, and the equations that depend on each other. */
static void list_dependent(Simulation *m, List *unknowns, List *equations)
{
    State *s = &m->s;
    double *A = m->newton.J, *B = m->rodas.J;
    int order[MODEL_ROOM(MODEL_NV)];
    memset(A, 0, sizeof m->newton.J);
    model_initial_jacobian(s->t, s->v, s->u, s->p, s->d, s->c, A);
    for (int i = 0; i < MODEL_NV; i++) {
        double largest = 0.0;
        for (int j = 0; j < MODEL_NV; j++) largest = fmax(largest, fabs(A[j * MODEL_NV + i] *= model_nominal[j]));
        for (int j = 0; j < MODEL_NV; j++) {
            A[j * MODEL_NV + i] /= largest > 0.0 ? largest : 1.0;
            B[j * MODEL_NV + i] = i == j;
        }
    }
    int rank = reduce(A, B, order);
    unsigned char open[MODEL_ROOM(MODEL_NV)] = {0};
    for (int k = rank; k < MODEL_NV; k++) {
        open[order[k]] = 1;
        for (int i = 0; i < rank; i++)
            if (fabs(A[order[k] * MODEL_NV + i]) > NEGLIGIBLE) open[order[i]] = 1;
    }
    for (int i = 0; i < MODEL_NV; i++) {
        int dependent = 0;
        for (int k = rank; k < MODEL_NV; k++) dependent |= fabs(B[i * MODEL_NV + k]) > NEGLIGIBLE;
        if (dependent) add_equation(m, equations, i);
        if (open[i]) add(unknowns, model_unknown_names[i], ", ");
    }
}

int simulation_blame_initial(Simulation *m, NewtonOutcome outcome)
{
    Newton *w = &m->newton;
    List unknowns = {.items = 0}, equations = {.items = 0}, residuals = {.items = 0};
    const char *concerned = model_unknown_names[w->worst];
    if (outcome == NEWTON_SINGULAR) list_dependent(m, &unknowns, &equations);
    list_residuals(m, &residuals);
    if (unknowns.items)
        return simulation_fail(m,
                               "The initial equations do not determine %s: near the start values these depend on each "
                               "other, or have no solution: %s. Give other start values, or one of the unknowns a fixed "
                               "start value in place of one of these equations.",
                               unknowns.text, equations.text);
    return simulation_fail(m,
                           "The initial equations cannot be solved; the unknown concerned is %s. The equations farthest "
                           "from their solution: %s. Check the start values and parameters in them.",
                           concerned, residuals.items ? residuals.text : "none");
}
