/* SPDX-License-Identifier: MIT-0 */
#include "controller.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

Controller *controller_new(const char *token) {
    if (token == NULL || strcmp(token, TOKEN) != 0) return NULL;
    Controller *c = calloc(1, sizeof *c);
    if (c == NULL) return NULL;
    c->values[W_REF] = 2.0;
    c->values[K_P] = 0.2;
    c->values[K_I] = 0.6;
    return c;
}

bool controller_settable(const Controller *c, unsigned reference) {
    return reference == W_CRANK || (!c->initialized && reference >= W_REF && reference <= K_I);
}

bool controller_step(Controller *c, double t, double h) {
    if (!(fabs(h - PERIOD) <= 1e-9)) {
        char text[100];
        snprintf(text, sizeof text, "SpeedController takes steps of %g s only, not of %.9g s", PERIOD, h);
        c->say(c, text);
        return false;
    }
    double *v = c->values;
    const double error = v[W_REF] - v[W_CRANK];
    const double duty = v[K_P] * error + v[K_I] * v[ERROR_SUM];
    v[DUTY] = fmin(fmax(duty, 0.0), 1.0);
    if (v[DUTY] == duty) v[ERROR_SUM] += PERIOD * error; /* else it would wind up */
    v[TIME] = t + h;
    return true;
}
