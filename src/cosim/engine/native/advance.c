/* SPDX-License-Identifier: Apache-2.0
 *
 * The continuous components, from one instant to the next.
 */
/* Step them from now to t, each with what those before it have just put out. */
static bool advance(Engine *engine, double now, double t, bool recording) {
    const double h = t - now;
    Component *const end = engine->continuous + engine->n_continuous;
    for (Component *component = engine->continuous; component < end; component++) {
        if (component->due < INFINITY && !begin_fixed_step(engine, component, now)) return false;
    }
    if (engine->n_lines > 0) set_middles(engine, now + 0.5 * h);
    if (ANY(engine->n_faulty)) begin_faulty_step(engine, now, h);
    for (Component *component = engine->continuous; component < end; component++) {
        if (component->due < INFINITY) {
            if (!end_fixed_step(engine, component, t)) return false;
            continue;
        }
        if (!write_inputs(engine, component) || !do_step(engine, component, now, h) ||
            !read_outputs(engine, component, recording)) {
            return false;
        }
    }
    if (ANY(engine->n_bonds)) end_power(engine, h);
    if (engine->n_lines > 0) set_lines(engine, t);
    return true;
}

/* Into how many macro steps an interval of length h between two instants is divided. */
static int64_t divisions(const Engine *engine, double h) {
    const double steps = ceil(h / engine->longest - 1e-6);
    return engine->parts * (steps > 1.0 ? (int64_t)steps : 1);
}

/* Take macro steps of one length. */
static bool advance_evenly(Engine *engine, Coupling *c, double now, double t, bool recording) {
    const int64_t steps = divisions(engine, t - now);
    for (bool first = true; c->number < steps; first = false) {
        if (!first && out_of_time(c)) return false;
        const int64_t number = c->number + 1;
        const double begin = now + (t - now) * (double)(number - 1) / (double)steps;
        const double end = number == steps ? t : now + (t - now) * (double)number / (double)steps, h = end - begin;
        const bool last = recording && number == steps;
        predict(engine, c, begin, h);
        const bool done = c->method == ITERATED ? agree(engine, c, begin, h, last)
                                                : take(engine, c, begin, h, last) && correct_again(engine, c, last);
        if (!done) return false;
        push(engine, c, begin, h);
        enlarge(engine, c);
        c->macro_steps++;
        c->number = number;
    }
    return true;
}

/* Step those that act on each other together, then the others. */
static bool advance_coupled(Engine *engine, Coupling *c, double t, bool recording) {
    const double now = engine->at.now;
    if (!c->under_way) {
        for (int64_t i = 0; i < c->n_others; i++) {
            if (c->others[i]->due < INFINITY && !begin_fixed_step(engine, c->others[i], now)) return false;
        }
        notice(engine, c);
        c->under_way = true;
        c->front = now;
        c->number = 0;
        c->earlier = c->macro_steps;
    }
    if (!(c->method == ADAPTIVE ? advance_adaptively(engine, c, now, t, recording)
                                : advance_evenly(engine, c, now, t, recording))) {
        return false;
    }
    c->under_way = false;
    if (engine->n_lines > 0) set_middles(engine, now + 0.5 * (t - now));
    if (ANY(engine->n_faulty)) begin_faulty_step(engine, now, t - now);
    for (int64_t i = 0; i < c->n_others; i++) {
        Component *const component = c->others[i];
        if (component->due < INFINITY) {
            if (!end_fixed_step(engine, component, t)) return false;
        } else if (!write_inputs(engine, component) || !do_step(engine, component, now, t - now) ||
                   !read_outputs(engine, component, recording)) {
            return false;
        }
    }
    if (engine->n_lines > 0) set_lines(engine, t);
    return true;
}

static bool advance_in_steps(Engine *engine, double t, bool recording) {
    const double now = engine->at.now;
    if (PLAIN) return advance(engine, now, t, recording);
    if (engine->coupling) {
        if (!advance_coupled(engine, engine->coupling, t, recording)) return false;
        engine->at.exchanges += engine->coupling->macro_steps - engine->coupling->earlier - 1;
        return true;
    }
    const int64_t steps = engine->parts == 1 && engine->longest == INFINITY ? 1 : divisions(engine, t - now);
    double begun = now;
    for (int64_t part = 1; part < steps; part++) {
        const double until = now + (t - now) * (double)part / (double)steps;
        if (!advance(engine, begun, until, false)) return false;
        begun = until;
    }
    return advance(engine, begun, t, recording);
}
