/* SPDX-License-Identifier: MIT-0
 *
 * der(x) = u, exactly, u held over the step. A step that is longer than `longest` goes wrong in the way that a parameter
 * chooses; noise is there in all steps. said is the time, and lag is what the time was longer than heard says, where the
 * last step began.
 */
#include "shell.h"

enum { U = 1, HEARD, SAID, X0 = 10, LONGEST, WRONG, X, LAG, STEPS };
enum { NONE = 1, NOT_A_NUMBER, RETURN_ERROR, RETURN_DISCARD, TERMINATE, FATAL, EARLY, RUN_AWAY, NOISE };

static void start(Model *m) {
    m->v[LONGEST] = 1e9;
    m->v[WRONG] = NONE;
    snprintf(m->text[HEARD], sizeof m->text[HEARD], "0");
    snprintf(m->text[SAID], sizeof m->text[SAID], "0");
}

static int event(Model *m) { return OK; }

static void outputs(Model *m) {
    if (m->time == 0.0) m->v[X] = m->v[X0];
}

static int step(Model *m, double h) {
    outputs(m);
    m->v[LAG] = m->time - atof(m->text[HEARD]);
    m->v[STEPS] += 1.0;
    m->v[X] += h * m->v[U];
    snprintf(m->text[SAID], sizeof m->text[SAID], "%.17g", m->time + h);
    if (m->v[WRONG] == NOISE) m->v[X] += 1e-6 * sin(1e9 * m->v[STEPS] * h);
    if (h <= m->v[LONGEST]) return OK;
    switch ((int)m->v[WRONG]) {
        case NOT_A_NUMBER: m->v[X] = NAN; return OK;
        case RETURN_ERROR: say(m, "the solver has lost the solution"); return ERROR;
        case RETURN_DISCARD: say(m, "the step is too long"); return DISCARD;
        case TERMINATE: m->terminate = true; return OK;
        case FATAL: say(m, "memory is exhausted"); return ERROR + 1;
        case EARLY: m->early_return = true; return OK;
        case RUN_AWAY: m->v[X] += 1e9 * h * h; return OK;
        default: return OK;
    }
}
