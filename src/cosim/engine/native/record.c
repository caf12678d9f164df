/* SPDX-License-Identifier: Apache-2.0
 *
 * The rows of the result, and the clock by which a run is cut into pieces.
 */
#include <stdatomic.h>
#include <time.h>

static inline bool is_row(const Engine *engine, double t) { return t >= engine->grid[engine->at.row] - SAME_INSTANT; }

/* Whose output it is, the caller finds out. */
RARE bool are_all_numbers(Engine *engine) {
    int strange = 0;
    for (int64_t i = 0; i < engine->n_recorded; i++) strange |= isnan(engine->values[i]);
    engine->not_a_number = strange;
    if (strange) engine->failure.kind = NOT_A_NUMBER;
    return !strange;
}

/* What is not a number when it is read may have been replaced since. */
static inline bool are_numbers(Engine *engine) { return !engine->not_a_number || are_all_numbers(engine); }

static bool put_row(Engine *engine) {
    for (int64_t i = 0; i < engine->n_discrete; i++) {
        if (engine->discrete[i].stale && !read_outputs(engine, &engine->discrete[i], true)) return false;
    }
    if (!are_numbers(engine)) return false;
    double *place = engine->rows + engine->at.row;
    for (int64_t i = 0; i < engine->n_recorded; i++, place += engine->n_rows) *place = engine->values[i];
    atomic_signal_fence(memory_order_release); /* whoever counts a row, wherever this ends, finds it whole */
    engine->at.row++;
    return true;
}

/* Time since some moment in the past. */
static double wall_clock(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
