/* SPDX-License-Identifier: MIT-0
 *
 * Where in an accepted step the first relation changes.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "cubic.h"
#include "simulation.h"

/* The whole step is looked at through these points; between them through the cubic that they define. */
enum { SAMPLES = CUBIC_POINTS, NARROWINGS = MODEL_HAS_FIXED_STEP ? 12 : 200 };
static const double SAMPLE_AT[SAMPLES] = {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0};

typedef struct {
    double theta;
    double g[MODEL_ROOM(MODEL_NG)];
} Sample;

static void look(const Simulation *m, Sample *sample)
{
    const RodasStep *r = &m->rodas.step;
    double v[MODEL_ROOM(MODEL_NV)];
    rodas_dense(r, sample->theta, v);
    simulation_relations(m, r->t + sample->theta * r->h, v, sample->g);
}

/* As look, with the algebraic unknowns solved: what the event iteration will see there. */
static void look_closely(Simulation *m, Sample *sample)
{
    const RodasStep *r = &m->rodas.step;
    double v[MODEL_ROOM(MODEL_NV)], t = r->t + sample->theta * r->h;
    rodas_dense(r, sample->theta, v);
    if (MODEL_NZ > 0 && !simulation_solve_algebraic(m, t, v, NULL)) rodas_dense(r, sample->theta, v);
    simulation_relations(m, t, v, sample->g);
}

static int changed(const Simulation *m, const Sample *sample)
{
    for (int k = 0; k < MODEL_NG; k++)
        if (simulation_changed_state(m, k, sample->g[k])) return 1;
    return 0;
}

/* An excursion that comes back between two samples shows as an extremum of the cubic near zero. */
static void look_between(const Simulation *m, const Sample samples[SAMPLES], Sample *earliest)
{
    for (int k = 0; k < MODEL_NG; k++) {
        double g[SAMPLES], least = INFINITY, low = INFINITY, high = -INFINITY, at[2];
        for (int i = 0; i < SAMPLES; i++) {
            g[i] = samples[i].g[k];
            least = fmin(least, fabs(g[i]));
            low = fmin(low, g[i]);
            high = fmax(high, g[i]);
        }
        if (!(least < high - low)) continue;
        int n = cubic_extrema(g, at);
        for (int i = 0; i < n; i++) {
            Sample extremum = {.theta = at[i] / (SAMPLES - 1)};
            if (extremum.theta >= earliest->theta) continue;
            look(m, &extremum);
            if (changed(m, &extremum)) *earliest = extremum;
        }
    }
}

/* Shrink (before, after) around the first change, by Illinois steps (Dowell and Jarratt, BIT 11, 1971) that are kept
 * inside by the accuracy sought: an end that stays for a second time has its value halved, so that it moves, too. */
static void narrow(Simulation *m, Sample *before, Sample *after)
{
    const RodasStep *r = &m->rodas.step;
    double weight_before = 1.0, weight_after = 1.0;
    int moved = 0; /* the end that moved last: -1 before, 1 after */
    double accuracy = fmax(1e-13, 8.0 * DBL_EPSILON * (fabs(r->t) + r->h)) / r->h;
    for (int iteration = 0; iteration < NARROWINGS && after->theta - before->theta > accuracy; iteration++) {
        double fraction = 1.0;
        for (int k = 0; k < MODEL_NG; k++) {
            if (!simulation_changed_state(m, k, after->g[k])) continue;
            double left = weight_before * before->g[k], right = weight_after * after->g[k];
            double guess = left / (left - right);
            fraction = fmin(fraction, guess >= 0.0 && guess <= 1.0 ? guess : 0.5);
        }
        /* Every fourth step halves, for functions that no secant follows. */
        if (iteration % 4 == 3) fraction = 0.5;
        double width = after->theta - before->theta, margin = fmin(0.4 * accuracy, 0.5 * width);
        Sample middle;
        middle.theta = before->theta + fmin(width - margin, fmax(margin, fraction * width));
        look_closely(m, &middle);
        if (changed(m, &middle)) {
            *after = middle;
            weight_after = 1.0;
            if (moved == 1) weight_before *= 0.5;
            moved = 1;
        } else {
            *before = middle;
            weight_before = 1.0;
            if (moved == -1) weight_after *= 0.5;
            moved = -1;
        }
    }
}

int simulation_find_event(Simulation *m, double *theta)
{
    if (MODEL_NG == 0) return 0;
    Sample samples[SAMPLES], after = {.theta = 2.0};
    for (int i = 0; i < SAMPLES; i++) {
        samples[i].theta = SAMPLE_AT[i];
        look(m, &samples[i]);
        if (i > 0 && after.theta > 1.0 && changed(m, &samples[i])) after = samples[i];
    }
    look_between(m, samples, &after);
    if (after.theta > 1.0) return 0;
    look_closely(m, &after);
    if (!changed(m, &after)) {
        /* Only the interpolated algebraic unknowns said so; the end of the step has the last word. */
        after = samples[SAMPLES - 1];
        look_closely(m, &after);
        if (!changed(m, &after)) return 0;
    }
    Sample before = samples[0];
    for (int i = 1; i < SAMPLES && samples[i].theta < after.theta; i++)
        if (!changed(m, &samples[i])) before = samples[i];
    narrow(m, &before, &after);
    for (int k = 0; k < MODEL_NG; k++)
        m->changing[k] = (unsigned char)simulation_changed_state(m, k, after.g[k]);
    *theta = after.theta;
    return 1;
}
