/* SPDX-License-Identifier: MIT-0
 *
 * A controller for Model Exchange without states: every T it samples y = K u. Its indicator t - t_cross turns `late` on.
 */
#define NX 0
#define NZ 1
#include "exchange.h"

enum { U = 1, K, T, T_CROSS, Y, SAMPLES, LATE };

static void start(Model *m) {
    m->v[K] = 1.0;
    m->v[T] = 0.02;
    m->v[T_CROSS] = 1e9;
}
static bool rates(Model *m) { return true; }
static void indicators(Model *m, double z[]) { z[0] = m->time - m->v[T_CROSS]; }
static void completed(Model *m) {}
static void update(Model *m) {
    m->v[LATE] = m->time >= m->v[T_CROSS] - 1e-12;
    if (m->time >= m->v[SAMPLES] * m->v[T] - 1e-12) {
        m->v[Y] = m->v[K] * m->v[U];
        m->v[SAMPLES] += 1.0;
        m->next_event = m->v[SAMPLES] * m->v[T];
    }
}
static void outputs(Model *m) {}
