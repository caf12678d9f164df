/* SPDX-License-Identifier: Apache-2.0
 *
 * Inputs that are driven from tables.
 */
static inline double next_change(const Engine *engine) {
    return engine->change < engine->n_changes ? engine->changes[engine->change].time : INFINITY;
}

/* Of two changes at one time the second stays. */
static void apply_changes(Engine *engine, double t) {
    while (next_change(engine) <= t + SAME_INSTANT) {
        const Change *change = &engine->changes[engine->change++];
        if (change->slot >= 0) engine->values[change->slot] = change->value;
    }
}

/* The value at t, after a step at t. */
static double value_at(const Line *line, double t) {
    int64_t low = 0, high = line->count; /* of the entries after t, the first */
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (line->times[middle] > t + SAME_INSTANT) high = middle;
        else low = middle + 1;
    }
    if (low == 0) return line->start;
    if (low == line->count) return line->values[low - 1];
    const double t0 = line->times[low - 1], t1 = line->times[low];
    const double y0 = line->values[low - 1], y1 = line->values[low];
    const double passed = t - t0 > 0.0 ? t - t0 : 0.0;
    return y0 + (y1 - y0) * passed / (t1 - t0);
}

/* The value at t, before a step at t. */
static double value_before(const Line *line, double t) {
    int64_t low = 0, high = line->count; /* of the entries at t or after it, the first */
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (line->times[middle] < t - SAME_INSTANT) low = middle + 1;
        else high = middle;
    }
    if (low == 0 && t > SAME_INSTANT) return line->start;
    if (low < line->count && line->times[low] <= t + SAME_INSTANT) return line->values[low];
    return value_at(line, t);
}

static void set_middles(Engine *engine, double middle) {
    for (const Line *line = engine->lines; line < engine->lines + engine->n_lines; line++) {
        engine->values[line->middle] = value_at(line, middle);
    }
}

static void set_lines(Engine *engine, double t) {
    for (const Line *line = engine->lines; line < engine->lines + engine->n_lines; line++) {
        engine->values[line->slot] = value_at(line, t);
    }
}
