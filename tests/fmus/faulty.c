/* SPDX-License-Identifier: MIT-0
 *
 * y = t until t_fault; the step that passes it fails in the way that the parameter chooses.
 * A negative t_fault is refused in initialisation, one below -1 without saying that an assertion is violated.
 */
#define REFUSAL(m) refusal(m)
static int refusal(void *instance);
#include "shell.h"

enum { FAULT = 1, T_FAULT, Y };
enum { NONE = 1, NOT_A_NUMBER, RETURN_ERROR, RETURN_DISCARD, TERMINATE, SILENT_ERROR, FATAL, EARLY, TALKATIVE };

static void start(Model *m) { m->v[FAULT] = NONE; }

static int refusal(void *instance) {
    Model *m = instance;
    if (m->v[T_FAULT] >= 0.0) return OK;
    say(m, m->v[T_FAULT] < -1.0 ? "it is too early" : "an assertion of the model is violated: t_fault is negative");
    return ERROR;
}

static int event(Model *m) { return OK; }

static void outputs(Model *m) {}

static int step(Model *m, double h) {
    m->v[Y] = m->time + h;
    if (m->v[FAULT] == TALKATIVE) say(m, "all is well");
    if (m->v[Y] < m->v[T_FAULT] - 1e-9) return OK;
    switch ((int)m->v[FAULT]) {
        case NOT_A_NUMBER: m->v[Y] = NAN; return OK;
        case RETURN_ERROR: say(m, "the solver has lost the solution"); return ERROR;
        case RETURN_DISCARD: say(m, "the step is too long"); return DISCARD;
        case TERMINATE: m->terminate = true; return OK;
        case SILENT_ERROR: return ERROR;
        case FATAL: say(m, "memory is exhausted"); return ERROR + 1;
        case EARLY: m->early_return = true; return OK;
        default: return OK;
    }
}
