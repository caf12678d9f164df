/* SPDX-License-Identifier: Apache-2.0
 *
 * Faults at work, as cosim/engine/signals/_signal_faults.py has them. At each communication point `arrive_faults` comes first,
 * while the signals are what has led there; in the exchange and in the step that follow `refresh` computes what inputs
 * get, and changes nothing else; `settle_faults` comes after the exchange.
 */
#define MOST_NEW_POINTS 4 /* points that a macro step may add to a history */

static void append(const SignalFault *fault, double t, double value) {
    fault->points[fault->state->count++] = (Point){t, value};
}

/* Three points of one value in a row need two. */
static void note_course(const SignalFault *fault, double t, double value) {
    const int64_t last = fault->state->count - 1;
    Point *points = fault->points;
    if (last > fault->state->first && points[last].value == value && points[last - 1].value == value) {
        points[last].time = t;
    } else {
        append(fault, t, value);
    }
}

static void note_step(const SignalFault *fault, double t, double value) {
    const int64_t last = fault->state->count - 1;
    if (last < 0) {
        append(fault, t, value);
    } else if (fault->points[last].value != value) {
        if (fault->points[last].time != t) append(fault, t, fault->points[last].value);
        append(fault, t, value);
    }
}

/* The last point at t or earlier stays, both of two at t. */
static void forget(const SignalFault *fault, double t) {
    FaultState *state = fault->state;
    while (state->first + 1 < state->count && fault->points[state->first + 1].time < t - SAME_INSTANT) state->first++;
    if (state->jump < state->first) state->jump = state->first;
}

/* The value that the signal had at t, before or after a step at t. */
static double earlier(const SignalFault *fault, double t, bool before) {
    const Point *const first = fault->points + fault->state->first, *const end = fault->points + fault->state->count;
    const Point *after = first;
    if (before) {
        while (after < end && after->time < t - SAME_INSTANT) after++;
        if (after == end) return after[-1].value;
        if (after == first || after->time <= t + SAME_INSTANT) return after->value;
    } else {
        while (after < end && after->time <= t + SAME_INSTANT) after++;
        if (after == first) return after->value;
        if (after == end || after[-1].time >= t - SAME_INSTANT) return after[-1].value;
    }
    const double t0 = after[-1].time, t1 = after->time, y0 = after[-1].value, y1 = after->value;
    return y0 + (y1 - y0) * ((t - t0) / (t1 - t0));
}

static double quantised(double value, double step) {
    const double steps = value / step;
    return step * (fabs(steps) < 0x1p52 ? rint(steps) + 0.0 : steps); /* no -0 */
}

/* What the fault makes of a value at t, or before what happens at t. */
static double faulty(const SignalFault *fault, double given, double t, bool before) {
    const FaultState *state = fault->state;
    if (!state->active) return given;
    switch ((SignalFaultKind)fault->kind) {
        case OVERRIDE: return fault->amount;
        case BIAS: return given + fault->amount;
        case SCALE: return given * fault->amount;
        case FREEZE: return state->kept;
        case DELAY: return earlier(fault, t - fault->amount, before);
        case DROP: return state->passing ? given : state->kept;
        case QUANTISE: return quantised(given, fault->amount);
        case NOISE: return given + fault->draws[state->period];
    }
    return given;
}

/* Compute what inputs get now. */
RARE void refresh(Engine *engine, const FaultyInput *inputs, int64_t count) {
    const FaultClock *clock = engine->fault_clock;
    for (const FaultyInput *input = inputs; input < inputs + count; input++) {
        double value = handed_on(clock->stepping ? &input->held : &input->at, engine->values);
        for (int64_t i = 0; i < input->n_faults; i++) value = faulty(&input->faults[i], value, clock->time, false);
        engine->values[input->slot] = value;
        engine->not_a_number |= isnan(value);
    }
}

/* Over a step inputs act with their values in its middle. */
static void begin_faulty_step(Engine *engine, double now, double h) {
    engine->fault_clock->time = now + 0.5 * h;
    engine->fault_clock->until = now + h;
    engine->fault_clock->stepping = true;
}

/* What an input would get at the end of the step, from a value of what drives it. */
static double faulty_at_end(const Engine *engine, const FaultyInput *input, double given) {
    const double until = engine->fault_clock->until;
    for (int64_t i = 0; i < input->n_faults; i++) given = faulty(&input->faults[i], given, until, false);
    return given;
}

/* Begin, end, or go on to the period that begins at t; `given` is the signal that has led to t. */
static void go_to(const SignalFault *fault, double t, double given) {
    FaultState *state = fault->state;
    if (fault->kind == DELAY && !(fault->stepwise && state->count > 0)) note_course(fault, t, given);
    state->passing = false;
    if (state->period < 0 && t >= fault->watch - SAME_INSTANT) {
        state->period = 0;
        state->kept = given;
        state->passing = fault->kind == DROP && t < fault->start - SAME_INSTANT;
    }
    if (fault->start - SAME_INSTANT <= t && t < fault->stop - SAME_INSTANT) {
        state->active = true;
        if (fault->kind == DROP && state->period == 0 && t <= fault->start + SAME_INSTANT) {
            state->passing = fault->draws[0] == 0.0;
        }
        while ((double)(fault->boundary + state->period) * fault->every <= t + SAME_INSTANT) {
            state->period++;
            if (fault->kind == DROP && fault->draws[state->period] == 0.0) state->passing = true;
        }
    } else {
        state->active = false;
    }
    if (fault->kind == DELAY) forget(fault, t - fault->amount);
}

RARE void arrive_faults(Engine *engine, double t) {
    engine->fault_clock->time = t;
    engine->fault_clock->stepping = false;
    for (const FaultyInput *input = engine->faulty; input < engine->faulty + engine->n_faulty; input++) {
        const double source = input->line ? value_before(input->line, t) : engine->values[input->at.source];
        double value = translated(&input->at, source);
        for (const SignalFault *fault = input->faults; fault < input->faults + input->n_faults; fault++) {
            const double given = value;
            value = faulty(fault, given, t, true);
            if (input->linked && t >= fault->state->next - SAME_INSTANT) engine->fault_clock->changed = true;
            go_to(fault, t, given);
        }
    }
}

/* When the next step of the signal comes out of the delay after t. */
static double next_step(const SignalFault *fault, double t) {
    FaultState *state = fault->state;
    for (; state->jump + 1 < state->count; state->jump++) {
        const Point *point = &fault->points[state->jump];
        if (point[0].time == point[1].time && point->time + fault->amount > t + SAME_INSTANT) {
            return point->time + fault->amount;
        }
    }
    return INFINITY;
}

static double next_instant(const SignalFault *fault, double t) {
    if (t < fault->start - SAME_INSTANT) return fault->state->period < 0 ? fault->watch : fault->start;
    if (t >= fault->stop - SAME_INSTANT) return INFINITY;
    const double following = fault->kind == DELAY
                                 ? next_step(fault, t)
                                 : (double)(fault->boundary + fault->state->period) * fault->every;
    return fmin(following, fault->stop);
}

RARE void settle_faults(Engine *engine, double t) {
    double next = INFINITY;
    for (const FaultyInput *input = engine->faulty; input < engine->faulty + engine->n_faulty; input++) {
        double value = handed_on(&input->at, engine->values);
        for (const SignalFault *fault = input->faults; fault < input->faults + input->n_faults; fault++) {
            FaultState *state = fault->state;
            const double given = value;
            value = faulty(fault, given, t, false);
            if (fault->kind == DELAY) note_step(fault, t, given);
            if (state->passing) {
                state->kept = given;
                state->passing = false;
            }
            state->next = next_instant(fault, t);
            next = fmin(next, state->next);
        }
        engine->values[input->slot] = value;
        engine->not_a_number |= isnan(value);
    }
    engine->fault_clock->next = next;
}

/* Move the points in use to the front where the end is near; false if there is no room for a macro step even so. */
RARE bool make_room(Engine *engine) {
    bool enough = true;
    for (const FaultyInput *input = engine->faulty; input < engine->faulty + engine->n_faulty; input++) {
        for (const SignalFault *fault = input->faults; fault < input->faults + input->n_faults; fault++) {
            FaultState *state = fault->state;
            if (fault->kind != DELAY || state->count + MOST_NEW_POINTS <= fault->capacity) continue;
            memmove(fault->points, fault->points + state->first, (size_t)(state->count - state->first) * sizeof(Point));
            state->jump -= state->first;
            state->count -= state->first;
            state->first = 0;
            enough = enough && 2 * state->count <= fault->capacity;
        }
    }
    engine->fault_clock->full = !enough;
    return enough;
}
