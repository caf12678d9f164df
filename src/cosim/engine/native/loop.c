/* SPDX-License-Identifier: Apache-2.0
 *
 * The two co-simulation algorithms. Each call goes on where the last one stopped, for about `limit` seconds of wall
 * time and for at least one macro step, so that the caller can report progress and be interrupted in between.
 */
/* Macro steps between two looks at the clock, each of which takes as long as a step of a small FMU. While that many
 * steps take long enough to be noticed, every step is followed by a look. */
#define BETWEEN_LOOKS 64
#define LONG 0.01

/* Apply the channels and compute the discrete components that are due at t, until nothing changes any more. */
static bool exchange(Engine *engine, double t, bool recording) {
    apply_changes(engine, t);
    Component *const end = engine->discrete + engine->n_discrete;
    bool quiet = false;
    for (int round = 0; !quiet; round++) {
        if (round == MOST_ROUNDS) {
            engine->failure.kind = WITHOUT_END;
            return false;
        }
        quiet = true;
        for (Component *component = engine->discrete; component < end; component++) {
            if (component->due <= t + SAME_INSTANT || triggered(engine, component)) {
                quiet = false;
                const bool done = component->role == EVENT ? handle_event(engine, component, t, recording)
                                                           : take_sample(engine, component, recording);
                if (!done) return false;
            }
        }
    }
    for (Component *component = engine->discrete; component < end; component++) {
        if (component->in_event_mode && !leave_event_mode(engine, component)) return false;
    }
    return true;
}

/* Step to the next instant at which something is to be exchanged, or to the next row if that comes first. */
static bool go_on(Engine *engine) {
    Component *const end = engine->discrete + engine->n_discrete;
    const double row = engine->grid[engine->at.row], stop = engine->grid[engine->n_rows - 1];
    double change = next_change(engine);
    if (ANY(engine->n_faulty) && engine->fault_clock->next < change) change = engine->fault_clock->next;
    double due = INFINITY;
    for (const Component *component = engine->discrete; component < end; component++) {
        if (component->due < due) due = component->due;
    }
    for (int64_t i = 0; i < engine->n_continuous; i++) {
        if (engine->continuous[i].due < due) due = engine->continuous[i].due;
    }
    const double instant = due <= change + SAME_INSTANT ? due : change;
    bool exchanging = instant <= row + SAME_INSTANT;
    double t = exchanging ? instant : row;
    if (t > stop) t = stop;
    const bool recording = is_row(engine, t);
    if (!advance_in_steps(engine, t, recording)) return false;
    for (Component *component = engine->discrete; component < end; component++) {
        if (component->role == EVENT && component->due == INFINITY) {
            if (!carry(engine, component, t)) return false;
            exchanging = exchanging || component->due == t;
        }
    }
    engine->at.now = t;
    if (ANY(engine->n_faulty)) arrive_faults(engine, t);
    if (exchanging && !(are_numbers(engine) && exchange(engine, t, recording))) return false;
    if (ANY(engine->n_faulty)) settle_faults(engine, t);
    engine->at.exchanges += exchanging || engine->coupled;
    return true;
}

/* Between the communication points t and t + step all components see what all have put out at t. */
static bool go_on_jacobi(Engine *engine) {
    Component *const end = engine->continuous + engine->n_continuous;
    const double now = engine->at.now, h = engine->step;
    const double t = (double)engine->at.exchanges * h; /* one at 0, and one at the end of each macro step */
    if (engine->n_lines > 0) set_middles(engine, now + 0.5 * h);
    if (ANY(engine->n_faulty)) begin_faulty_step(engine, now, 0.0);
    for (Component *component = engine->continuous; component < end; component++) {
        if (!write_inputs(engine, component)) return false;
    }
    for (Component *component = engine->continuous; component < end; component++) {
        if (!do_step(engine, component, now, h)) return false;
    }
    const bool recording = is_row(engine, t);
    for (Component *component = engine->continuous; component < end; component++) {
        if (!read_outputs(engine, component, recording)) return false;
    }
    if (ANY(engine->n_bonds)) end_power(engine, h);
    if (engine->n_lines > 0) set_lines(engine, t);
    if (ANY(engine->n_faulty)) arrive_faults(engine, t);
    if (next_change(engine) <= t + SAME_INSTANT) apply_changes(engine, t);
    if (ANY(engine->n_faulty)) settle_faults(engine, t);
    engine->at.now = t;
    engine->at.exchanges++;
    return are_numbers(engine);
}

static bool start(Engine *engine) {
    engine->started = true;
    engine->at.exchanges = 1;
    if (ANY(engine->n_faulty)) arrive_faults(engine, 0.0);
    if (engine->step > 0.0) apply_changes(engine, 0.0);
    else if (!exchange(engine, 0.0, true)) return false;
    if (ANY(engine->n_faulty)) settle_faults(engine, 0.0);
    if (ANY(engine->n_bonds)) begin_power(engine);
    return true;
}

/* A step of 0 asks for the default algorithm. */
#if WATCHED
#define cosim_run cosim_run_watched
#elif PLAIN
#define cosim_run cosim_run_plain
#endif
EXPORT int cosim_run(Engine *engine, double limit) {
    const double begun = wall_clock();
    const bool jacobi = engine->step > 0.0;
    double looked = begun;
    int until_look = 1;
    if (!engine->started && !start(engine)) return BROKEN;
    if (!PLAIN && engine->coupling) engine->coupling->deadline = begun + limit;
    for (bool first = true;; first = false) {
        if (!first && --until_look == 0) {
            const double now = wall_clock();
            if (fabs(now - begun) >= limit) return UNFINISHED;
            until_look = now - looked > LONG ? 1 : BETWEEN_LOOKS;
            looked = now;
        }
        if (is_row(engine, engine->at.now)) {
            if (!put_row(engine)) return BROKEN;
            if (engine->at.row == engine->n_rows) return FINISHED;
        }
        if (!PLAIN && engine->at.now >= engine->pause) return PAUSED;
        if (ANY(engine->n_faulty) && !make_room(engine)) return UNFINISHED;
        if (!(jacobi ? go_on_jacobi(engine) : go_on(engine))) {
            return !PLAIN && engine->coupling && engine->coupling->out_of_time ? UNFINISHED : BROKEN;
        }
    }
}

#if ONCE
/* Sizes of the structures, so that whoever fills them in can check that he means the same. */
EXPORT void cosim_sizes(int64_t *sizes) {
    const size_t known[] = {
        sizeof(Wire),       sizeof(Group),      sizeof(FaultState), sizeof(SignalFault), sizeof(FaultyInput),
        sizeof(FaultClock), sizeof(Trigger),    sizeof(Component),  sizeof(Change),      sizeof(Line),
        sizeof(Bond),       sizeof(Text),       sizeof(Engine),     sizeof(Fault),       sizeof(Link),
        sizeof(Correction), sizeof(Member),     sizeof(Coupling),
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) sizes[i] = (int64_t)known[i];
}
#endif
