/* SPDX-License-Identifier: MIT-0
 *
 * Arrays of String, FMI 3.0 only: in each step y[0] is name[0] and u[1], y[1] is name[1] and u[0], with a space between.
 * heard is the length of u[0] plus a hundred times that of u[1], as they were during the last step.
 */
#define LENGTH(reference) ((reference) < 7 ? 2 : 1)
#include "shell.h"

enum { U = 1, Y = 3, NAME = 5, HEARD = 10 };

static void start(Model *m) {
    for (int j = 0; j < 2; j++) {
        snprintf(m->text[U + j], sizeof m->text[U], "-");
        snprintf(m->text[NAME + j], sizeof m->text[NAME], "word");
    }
}

static int event(Model *m) { return OK; }

static void outputs(Model *m) {}

static int step(Model *m, double h) {
    m->v[HEARD] = (double)(strlen(m->text[U]) + 100 * strlen(m->text[U + 1]));
    for (int j = 0; j < 2; j++)
        snprintf(m->text[Y + j], sizeof m->text[Y], "%.30s %.30s", m->text[NAME + j], m->text[U + 1 - j]);
    return OK;
}
