/* SPDX-License-Identifier: MIT-0
 *
 * A DC motor: L di/dt = u - R i - k w, J dw/dt = k i - b w - tau. Runge-Kutta of order 4 in equal steps of at most
 * 0.2 ms: five in a macro step of 1 ms, one in a macro step of 0.1 ms.
 */
#include "shell.h"

enum { U = 1, TAU, W, I };

static const double R = 1.0, per_L = 1.0 / 1e-3, per_J = 1.0 / 1e-4, k = 0.05, b = 1e-5;

static void start(Model *m) { m->v[TAU] = 0.02; }

static int event(Model *m) { return OK; }

static void outputs(Model *m) {}

static inline double didt(const double *v, double i, double w) { return (v[U] - R * i - k * w) * per_L; }

static inline double dwdt(const double *v, double i, double w) { return (k * i - b * w - v[TAU]) * per_J; }

static int step(Model *m, double h) {
    const double *v = m->v;
    double i = v[I], w = v[W];
    const int n = (int)ceil(h / 200e-6 - 1e-6);
    const double d = h / n;
    for (int step = 0; step < n; step++) {
        const double i1 = didt(v, i, w), w1 = dwdt(v, i, w);
        const double i2 = didt(v, i + 0.5 * d * i1, w + 0.5 * d * w1), w2 = dwdt(v, i + 0.5 * d * i1, w + 0.5 * d * w1);
        const double i3 = didt(v, i + 0.5 * d * i2, w + 0.5 * d * w2), w3 = dwdt(v, i + 0.5 * d * i2, w + 0.5 * d * w2);
        const double i4 = didt(v, i + d * i3, w + d * w3), w4 = dwdt(v, i + d * i3, w + d * w3);
        i += d / 6.0 * (i1 + 2.0 * (i2 + i3) + i4);
        w += d / 6.0 * (w1 + 2.0 * (w2 + w3) + w4);
    }
    m->v[I] = i;
    m->v[W] = w;
    return OK;
}
