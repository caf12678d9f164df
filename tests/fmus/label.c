/* SPDX-License-Identifier: MIT-0
 *
 * Texts: y says which step this is, in words that change every second step; heard is the length of u as it was during
 * the last step, and set is how often u has been set.
 */
#include "shell.h"

enum { U = 1, Y, NAME, HEARD = 10, SET, STEPS };

static void start(Model *m) { snprintf(m->text[NAME], sizeof m->text[NAME], "step"); }

static int event(Model *m) { return OK; }

static void outputs(Model *m) { m->v[SET] = m->v[U]; }

static int step(Model *m, double h) {
    m->v[HEARD] = (double)strlen(m->text[U]);
    m->v[STEPS] += 1.0;
    const int pair = (int)m->v[STEPS] / 2;
    snprintf(m->text[Y], sizeof m->text[Y], "%s %.*s", m->text[NAME], pair, "++++++++++++++++++++++++++++++++++++++++");
    return OK;
}
