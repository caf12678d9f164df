/* SPDX-License-Identifier: MIT-0
 *
 * Binary variables, FMI 3.0 only: in step k, y[0] is the bytes of first[0] and then k bytes 0, 1, 2, ..., and y[1] is the
 * bytes of u[0] back to front.
 * sum is the sum of the bytes of u[0] and u[1] as they were during the last step, size their number, and set counts how
 * often u has been set. The FMU's memory of what it has put out is overwritten in each step.
 */
#include "shell.h"

enum { U = 1, Y = 2, FIRST = 4, SUM = 10, SIZE, SET, STEPS };

static void start(Model *m) {}

static int event(Model *m) { return OK; }

static void outputs(Model *m) { m->v[SET] = m->v[U]; }

static int step(Model *m, double h) {
    m->v[STEPS] += 1.0;
    m->v[SUM] = m->v[SIZE] = 0.0;
    for (int j = 0; j < 2; j++) {
        m->v[SIZE] += (double)m->size[U][j];
        for (size_t i = 0; i < m->size[U][j]; i++) m->v[SUM] += m->binary[U][j][i];
    }
    const size_t before = m->size[FIRST][0];
    m->size[Y][0] = before + (size_t)m->v[STEPS];
    memcpy(m->binary[Y][0], m->binary[FIRST][0], before);
    for (size_t i = before; i < m->size[Y][0]; i++) m->binary[Y][0][i] = (fmi3Byte)(i - before);
    m->size[Y][1] = m->size[U][0];
    for (size_t i = 0; i < m->size[U][0]; i++) m->binary[Y][1][i] = m->binary[U][0][m->size[U][0] - 1 - i];
    return OK;
}
