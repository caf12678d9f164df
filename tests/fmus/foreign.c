/* SPDX-License-Identifier: MIT-0
 *
 * A sampled controller, y = -u, as other tools export it: it has its own sample period T, which its importer does not
 * know. It executes a sample at the start of the step that begins then (1), at the end of the one that ends then (2), or
 * at the start, but puts out the result with the next sample (3); 0 does not look at u. Until `deaf` it takes u as zero.
 */
#include "shell.h"

enum { U = 1, KIND, T, DEAF, Y, PENDING };
enum { NEVER, AT_START, AT_END, NEXT_TIME };

static void start(Model *m) {
    m->v[KIND] = AT_START;
    m->v[T] = 0.1;
}

static int event(Model *m) { return OK; }

static void outputs(Model *m) {}

static bool is_sample(const Model *m, double t) { return fabs(t / m->v[T] - round(t / m->v[T])) < 1e-6; }

static int step(Model *m, double h) {
    const int kind = (int)m->v[KIND];
    if (kind == NEVER || !is_sample(m, kind == AT_END ? m->time + h : m->time)) return OK;
    const double y = m->time < m->v[DEAF] ? 0.0 : -m->v[U];
    m->v[Y] = kind == NEXT_TIME ? m->v[PENDING] : y;
    m->v[PENDING] = y;
    return OK;
}
