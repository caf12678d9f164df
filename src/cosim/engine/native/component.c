/* SPDX-License-Identifier: Apache-2.0
 *
 * Computing one component: steps, samples, events.
 */
typedef Status (*DoStep2)(void *, double, double, int);
typedef Status (*DoStep3)(void *, double, double, bool, bool *, bool *, bool *, double *);
typedef Status (*Enter)(void *);
typedef Status (*Update)(void *, bool *, bool *, bool *, bool *, bool *, double *);

RARE bool call_failed(Engine *engine, const Component *component, CalledFunction function, Status status) {
    engine->failure.function = function;
    engine->failure.status = status;
    return fail(engine, component, CALL_FAILED);
}

OFTEN bool check(Engine *engine, const Component *component, CalledFunction function, Status status) {
    return status < FAILED || call_failed(engine, component, function, status);
}

OFTEN bool do_step(Engine *engine, Component *component, double t, double h) {
    component->steps++;
    enter(engine, component, DO_STEP);
    const bool no_return = PLAIN || component->no_return;
    if (component->plain_step) {
        const Status status = ((DoStep2)component->do_step)(component->instance, t, h, no_return);
        return check(engine, component, DO_STEP, status);
    }
    bool event = false, terminate = false, early = false;
    double reached;
    const Status status =
        ((DoStep3)component->do_step)(component->instance, t, h, no_return, &event, &terminate, &early, &reached);
    if (status >= FAILED) return check(engine, component, DO_STEP, status);
    component->event_needed = event;
    if (terminate) return fail(engine, component, ASKS_TO_END);
    if (early) return fail(engine, component, RETURNED_EARLY);
    return true;
}

/* A component that takes steps of one length only: a step has the inputs of its beginning. */
static bool begin_fixed_step(Engine *engine, Component *component, double now) {
    return fabs(now - component->time) > SAME_INSTANT || write_inputs(engine, component);
}

/* What it puts out at the end holds until the next step has ended. */
static bool end_fixed_step(Engine *engine, Component *component, double t) {
    if (t < component->due - SAME_INSTANT) return true;
    if (!do_step(engine, component, component->time, component->period)) return false;
    component->time = component->due;
    component->due = (double)(++component->ticks + 1) * component->period;
    return read_outputs(engine, component, true);
}

/* Bring a component with event mode to t, where it may turn out to need an event. */
static bool carry(Engine *engine, Component *component, double t) {
    if (t > component->time) {
        if (!do_step(engine, component, component->time, t - component->time)) return false;
        component->time = t;
        if (component->event_needed) component->due = t;
    }
    return true;
}

/* Execute the sample that is due: an FMU without event mode samples at the beginning of its step, and then holds. */
static bool take_sample(Engine *engine, Component *component, bool recording) {
    if (!write_inputs(engine, component)) return false;
    component->ticks++;
    const double following = (double)component->ticks * component->period;
    if (!do_step(engine, component, component->due, following - component->due)) return false;
    component->due = component->time = following;
    return read_outputs(engine, component, recording);
}

/* The component stays in event mode, since the events of others may set it off again at the same instant. */
static bool handle_event(Engine *engine, Component *component, double t, bool recording) {
    void *instance = component->instance;
    if (!component->in_event_mode) {
        const double own = fabs(component->due - t) <= SAME_INSTANT ? component->due : t;
        if (!carry(engine, component, own)) return false;
        enter(engine, component, ENTER_EVENT_MODE);
        const Status status = ((Enter)component->enter_event_mode)(instance);
        if (!check(engine, component, ENTER_EVENT_MODE, status)) return false;
        component->in_event_mode = true;
    }
    if (!write_inputs(engine, component)) return false;
    bool needed = true, terminate = false, nominals, states, defined = false;
    double next = 0.0;
    for (int updates = 0; needed; updates++) {
        if (updates == MOST_UPDATES) return fail(engine, component, NEVER_SETTLES);
        needed = terminate = nominals = states = defined = false;
        enter(engine, component, UPDATE_DISCRETE_STATES);
        const Status status = ((Update)component->update_discrete_states)(
            instance, &needed, &terminate, &nominals, &states, &defined, &next);
        if (!check(engine, component, UPDATE_DISCRETE_STATES, status)) return false;
        if (terminate) return fail(engine, component, ASKS_TO_END);
    }
    component->due = defined ? next : INFINITY;
    if (component->due <= t + SAME_INSTANT) return fail(engine, component, ANNOUNCES_THE_PAST);
    return read_outputs(engine, component, recording);
}

static bool leave_event_mode(Engine *engine, Component *component) {
    component->events++;
    component->in_event_mode = false;
    enter(engine, component, ENTER_STEP_MODE);
    return check(engine, component, ENTER_STEP_MODE, ((Enter)component->enter_step_mode)(component->instance));
}
