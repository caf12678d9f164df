/* SPDX-License-Identifier: MIT-0
 *
 * A PI speed controller, executed at the begin of each step and held over it: u = Kp e + x, x' = Ki e, |u| <= 24 V, the
 * integral held at the limit. Its reference changes between 100 and -50 rad/s every 2.5 s.
 */
#include "shell.h"

enum { W = 1, KP, KI, U, X };

static void start(Model *m) {
    m->v[KP] = 0.5;
    m->v[KI] = 5.0;
}

static int event(Model *m) { return OK; }

static void outputs(Model *m) {}

static int step(Model *m, double h) {
    double *v = m->v;
    /* a little later, so that times that were added up with rounding errors give the same reference */
    const long interval = (long)((m->time + 1e-6) / 2.5);
    const double e = (interval % 2 ? -50.0 : 100.0) - v[W];
    const double u = v[KP] * e + v[X];
    v[U] = u > 24.0 ? 24.0 : u < -24.0 ? -24.0 : u;
    if (u == v[U]) v[X] += v[KI] * e * h;
    return OK;
}
