/* SPDX-License-Identifier: MIT-0
 *
 * der(x) = u, exactly, u held over the step; y = u + offset feeds the input through. It publishes how often it was
 * stepped, the longest step, and the start value of its input as it was at the end of initialisation.
 */
#include "shell.h"

enum { U = 1, X0, OFFSET, X, Y, POSITIVE, STEPS, LONGEST, GAIN };

static void start(Model *m) { m->v[GAIN] = 1.0; }

static int event(Model *m) { return OK; }

static void outputs(Model *m) {
    if (m->v[STEPS] == 0.0) m->v[X] = m->v[X0];
    m->v[Y] = m->v[U] + m->v[OFFSET];
    m->v[POSITIVE] = m->v[X] > 0.0;
}

static int step(Model *m, double h) {
    outputs(m);
    m->v[X] += h * m->v[GAIN] * m->v[U];
    m->v[STEPS] += 1.0;
    m->v[LONGEST] = fmax(m->v[LONGEST], h);
    return OK;
}
