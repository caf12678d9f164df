/* SPDX-License-Identifier: MIT-0
 *
 * Arrays: y = K u, element by element, as the inputs were during the last step; last = the last element of u.
 */
#define LENGTH(reference) ((reference) % 10 == 0 ? 3 : 1)
#include "shell.h"

enum { U = 10, K = 20, Y = 30, LAST = 1, N = 40, M = 50 };

static void start(Model *m) {
    for (int i = 0; i < 3; i++) m->v[K + i] = 1.0;
}

static int event(Model *m) { return OK; }

static void outputs(Model *m) {}

static int step(Model *m, double h) {
    for (int i = 0; i < 3; i++) m->v[Y + i] = m->v[K + i] * m->v[U + i];
    for (int i = 0; i < 3; i++) m->v[M + i] = -m->v[N + i];
    m->v[LAST] = m->v[U + 2];
    return OK;
}
