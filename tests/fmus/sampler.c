/* SPDX-License-Identifier: MIT-0
 *
 * Samples its input every T_compute: y = K u(t_k), and says when and how often it did, and how many events it saw.
 * FMI 3.0: time events in Event Mode, each handled in 1 + updates passes, and, if silent, reported but not announced. FMI 2.0: doStep(t, h) executes the sample at t.
 */
#include "shell.h"

enum { U = 1, ENABLE, T, K, Y, T_SAMPLE, COUNT, EVENTS, SIDE, ENABLED, UPDATES, SILENT, DONE };

static void start(Model *m) {
    m->v[T] = 0.02;
    m->v[K] = 1.0;
    m->v[ENABLE] = 1.0;
    m->v[T_SAMPLE] = -1.0;
    m->v[SIDE] = 1.0;
    m->next_event = 0.0;
}

static void sample(Model *m) {
    m->v[Y] = m->v[ENABLE] != 0.0 ? m->v[K] * m->v[U] : 0.0;
    m->v[SIDE] = m->v[U] > 0.0 ? 3.0 : m->v[U] < 0.0 ? 1.0 : 2.0;
    m->v[T_SAMPLE] = m->time;
    m->v[COUNT] += 1.0;
}

static int event(Model *m) {
    m->silent = m->v[SILENT] != 0.0;
    m->v[DONE] += 1.0;
    m->update_needed = m->v[DONE] <= m->v[UPDATES];
    if (m->update_needed) return OK;
    m->v[DONE] = 0.0;
    m->v[EVENTS] += 1.0;
    m->v[ENABLED] = m->v[ENABLE];
    if (m->time >= m->next_event - 1e-12) {
        sample(m);
        m->next_event = m->v[COUNT] * m->v[T];
    }
    return OK;
}

static int step(Model *m, double h) {
    if (!m->event_mode_used) sample(m);
    return OK;
}

static void outputs(Model *m) {}
