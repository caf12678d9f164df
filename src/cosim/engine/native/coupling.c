/* SPDX-License-Identifier: Apache-2.0
 *
 * Components that act on each other continuously: one macro step of all of them, as in cosim/engine/coupling/_coupling.py.
 */
#define CLOSE 0.01

typedef Status (*SaveState)(void *, void **);
typedef Status (*RestoreState)(void *, void *);
typedef Status (*Derivative2)(void *, const ValueReference *, size_t, const ValueReference *, size_t, const double *,
                              double *);
typedef Status (*Derivative3)(void *, const ValueReference *, size_t, const ValueReference *, size_t, const double *,
                              size_t, double *, size_t);

static inline double larger(double a, double b) { return b > a ? b : a; }
static inline double smaller(double a, double b) { return b < a ? b : a; }

static inline double given_by(const Link *link, const double *values) {
    return values[link->wire.source] * link->wire.factor + link->wire.offset;
}

static inline void enter_member(Engine *engine, const Member *member, CalledFunction function) {
    if (WATCHED) engine->at.call = (Call){member->component->number, member->numbers[function - SAVE]};
}

/* The polynomials begin anew if what drives the members otherwise has changed, or what a fault does to them. */
static void notice(const Engine *engine, Coupling *c) {
    if (engine->n_faulty > 0 && engine->fault_clock->changed) {
        engine->fault_clock->changed = false;
        c->known = 0;
    }
    for (int64_t i = 0; i < c->n_steady; i++) {
        const double value = engine->values[c->steady[i]];
        if (value != c->was[i]) {
            c->was[i] = value;
            c->known = 0;
        }
    }
}

/* Take the signals as those at t, the beginning of a step, and continue the links over h. */
static void predict(const Engine *engine, Coupling *c, double t, double h) {
    const double t1 = c->times[0], t2 = c->times[1];
    if (c->known > 0 && t - t1 < CLOSE * h) c->known = 0;
    else if (c->known > 1 && t1 - t2 < CLOSE * h) c->known = 1;
    const int64_t order = c->known < c->order ? c->known : c->order;
    for (int64_t i = 0; i < c->n_links; i++) {
        double value = given_by(&c->links[i], engine->values);
        c->start[i] = value;
        if (order > 0) {
            double slope = (value - c->last[i]) / (t - t1);
            if (order > 1) {
                const double bend = (slope - (c->last[i] - c->before[i]) / (t1 - t2)) / (t - t2);
                slope = slope + bend * (t + h - t1);
            }
            value = value + slope * h;
        }
        c->end[i] = value;
    }
}

/* What a link holds from t over h. */
static double held(const Coupling *c, int64_t i, double t, double h) {
    const double start = c->start[i], end = c->end[i];
    if (c->links[i].holds_end) return end;
    double mean = 0.5 * (start + end);
    if (c->known > 0 && c->order > 1) {
        const double t1 = c->times[0];
        const double bend = ((end - start) / h - (start - c->last[i]) / (t - t1)) / (t + h - t1);
        mean = mean - bend * h * h / 6.0;
    }
    return mean;
}

/* Add to the outputs that feed inputs through what the inputs at the end of the step differ by from those held. */
static bool correct(Engine *engine, Coupling *c, const Member *member, bool recording) {
    const Correction *correction = member->correction;
    const int64_t n = correction->n_slots[recording];
    for (int64_t k = 0; k < correction->n_links; k++) {
        const int64_t i = correction->links[k];
        const FaultyInput *input = c->links[i].faulty;
        correction->seed[k] = input ? faulty_at_end(engine, input, c->end[i]) - engine->values[input->slot]
                                    : c->end[i] - engine->values[c->links[i].slot];
    }
    if (n == 0) return true;
    const size_t inputs = (size_t)correction->n_links, outputs = (size_t)n;
    void *const instance = member->component->instance;
    enter_member(engine, member, DERIVE);
    const Status status =
        member->component->fmi < 3
            ? ((Derivative2)correction->derivative)(instance, correction->outputs, outputs, correction->inputs, inputs,
                                                    correction->seed, correction->slope)
            : ((Derivative3)correction->derivative)(instance, correction->outputs, outputs, correction->inputs, inputs,
                                                    correction->seed, inputs, correction->slope, outputs);
    if (!check(engine, member->component, DERIVE, status)) return false;
    for (int64_t k = 0; k < n; k++) engine->values[correction->slots[k]] = correction->raw[k] + correction->slope[k];
    return true;
}

/* Step all members from t over h, each with what is known of those before it. */
static bool take(Engine *engine, Coupling *c, double t, double h, bool recording) {
    double *const values = engine->values;
    if (engine->n_lines > 0) set_middles(engine, t + 0.5 * h);
    if (ANY(engine->n_faulty)) begin_faulty_step(engine, t, h);
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        for (int64_t k = 0; k < member->n_links; k++) {
            const int64_t i = member->links[k];
            if (c->links[i].ahead) c->end[i] = given_by(&c->links[i], values);
            values[c->links[i].slot] = held(c, i, t, h);
        }
        Component *const component = member->component;
        if (!write_inputs(engine, component) || !do_step(engine, component, t, h) ||
            !read_outputs(engine, component, recording)) {
            return false;
        }
        const Correction *correction = member->correction;
        if (!correction) continue;
        for (int64_t k = 0; k < correction->n_slots[true]; k++) correction->raw[k] = values[correction->slots[k]];
        if (!correct(engine, c, member, recording)) return false;
    }
    return true;
}

/* Correct the outputs once more, now that the ends of all links are known. */
static bool correct_again(Engine *engine, Coupling *c, bool recording) {
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        const Correction *correction = member->correction;
        if (!correction) continue;
        bool changed = false;
        for (int64_t k = 0; k < correction->n_links; k++) {
            const int64_t i = correction->links[k];
            const double value = given_by(&c->links[i], engine->values);
            if (value != c->end[i]) {
                c->end[i] = value;
                changed = true;
            }
        }
        if (changed && !correct(engine, c, member, recording)) return false;
    }
    return true;
}

/* The step from t over h stays. */
static void push(const Engine *engine, Coupling *c, double t, double h) {
    if (ANY(engine->n_bonds)) end_power(engine, h);
    c->times[1] = c->times[0];
    c->times[0] = t;
    if (c->known < 2) c->known++;
    for (int64_t i = 0; i < c->n_links; i++) {
        c->before[i] = c->last[i];
        c->last[i] = c->start[i];
    }
}

/* Note the magnitudes of what a step which stays has led to. */
static void enlarge(const Engine *engine, const Coupling *c) {
    for (int64_t i = 0; i < c->n_links; i++) {
        c->magnitudes[i] = larger(c->magnitudes[i], fabs(given_by(&c->links[i], engine->values)));
    }
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        for (int64_t k = 0; k < member->n_observed; k++) {
            member->scale[k] = larger(member->scale[k], fabs(member->observed[k]));
        }
    }
}

/* Copy all numbers that a step changes to a place, or from it. */
static void move_numbers(const Engine *engine, const Coupling *c, int place, bool back) {
    double *const parts[] = {engine->values, c->inputs, c->last, c->before, c->times, c->energies, c->powers};
    const int64_t m = c->n_links, n = engine->n_bonds, sizes[] = {c->n_numbers, c->n_inputs, m, m, 2, 3 * n, 2 * n};
    double *kept = c->kept[place];
    for (int i = 0; i < 7; i++) {
        if (sizes[i] == 0) continue; /* there may be no memory for none */
        memcpy(back ? parts[i] : kept, back ? kept : parts[i], (size_t)sizes[i] * sizeof(double));
        kept += sizes[i];
    }
}

static bool save(Engine *engine, Coupling *c, int place) {
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        enter_member(engine, member, SAVE);
        const Status status = ((SaveState)member->save)(member->component->instance, &member->states[place]);
        if (!check(engine, member->component, SAVE, status)) return false;
    }
    move_numbers(engine, c, place, false);
    c->known_then[place] = c->known;
    return true;
}

static bool restore(Engine *engine, Coupling *c, int place) {
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        enter_member(engine, member, RESTORE);
        const Status status = ((RestoreState)member->restore)(member->component->instance, member->states[place]);
        if (!check(engine, member->component, RESTORE, status)) return false;
    }
    move_numbers(engine, c, place, true);
    c->known = c->known_then[place];
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        if (!read_texts(engine, member->component)) return false;
    }
    return true;
}
