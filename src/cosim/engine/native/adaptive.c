/* SPDX-License-Identifier: Apache-2.0
 *
 * Macro steps as long as the tolerance allows, as cosim/engine/coupling/_adaptive.py explains.
 */
#define SHORTEST_MACRO_STEP 1e-7
#define MACRO_SAFETY 0.9
#define MACRO_SHRINKAGE 0.2
#define MACRO_GROWTH 4.0
#define MACRO_ERROR 1e-4
#define MACRO_AGREES 0.1
#define MACRO_RESOLUTION 1e-14
#define MACRO_NOISE 0.1
#define MACRO_FALLS 0.8

typedef struct {
    double of_step;  /* over the part of the tolerance that a step may have */
    double of_whole; /* over the whole tolerance */
} Errors;

/* Take one step; without polynomials to begin with, twice, the second time with what the first has given. */
static bool solve_step(Engine *engine, Coupling *c, double t, double h, bool recording) {
    predict(engine, c, t, h);
    if (c->loops) return agree(engine, c, t, h, recording);
    if (c->known == 0) {
        double *const ends = c->scratch + c->n_cut * c->n_cut;
        if (!save(engine, c, INNER) || !take(engine, c, t, h, false) || !correct_again(engine, c, false)) return false;
        for (int64_t i = 0; i < c->n_links; i++) ends[i] = given_by(&c->links[i], engine->values);
        if (!restore(engine, c, INNER)) return false;
        c->repeated++;
        memcpy(c->end, ends, (size_t)c->n_links * sizeof(double));
    }
    return take(engine, c, t, h, recording) && correct_again(engine, c, recording);
}

static bool observe(Engine *engine, const Member *member) {
    return member->n_observed == 0 || call(engine, member->component, member->reads, &member->reads->extents[WHOLE]);
}

/* Keep what a step taken whole has led to. */
static bool note_full(Engine *engine, Coupling *c) {
    for (int64_t i = 0; i < c->n_links; i++) c->full[i] = given_by(&c->links[i], engine->values);
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        if (!observe(engine, member)) return false;
        memcpy(member->full, member->observed, (size_t)member->n_observed * sizeof(double));
    }
    return true;
}

/* The largest errors of a step of length h in two halves. Magnitudes on which both ways roughly agree are noted. */
static bool find_errors(Engine *engine, const Coupling *c, double h, Errors *errors) {
    const double whole = c->divisor * c->tolerance / c->allowed, part = h / c->stop;
    *errors = (Errors){0.0, 0.0};
    for (int64_t i = 0; i < c->n_links; i++) {
        const double value = given_by(&c->links[i], engine->values);
        const double size = fabs(value), difference = fabs(value - c->full[i]);
        if (difference <= MACRO_AGREES * size) c->magnitudes[i] = larger(c->magnitudes[i], size);
        double error = difference / (whole * larger(c->magnitudes[i], size));
        if (isnan(error)) error = INFINITY;
        errors->of_whole = larger(errors->of_whole, error);
        if (!c->links[i].observed) error = error / part;
        errors->of_step = larger(errors->of_step, error);
    }
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        if (!observe(engine, member)) return false;
        for (int64_t k = 0; k < member->n_observed; k++) {
            const double value = member->observed[k];
            const double size = fabs(value), difference = fabs(value - member->full[k]);
            if (difference <= MACRO_AGREES * size) member->scale[k] = larger(member->scale[k], size);
            double error = difference / (whole * larger(member->scale[k], size));
            if (isnan(error)) error = INFINITY;
            errors->of_whole = larger(errors->of_whole, error);
            error = error / part;
            errors->of_step = larger(errors->of_step, error);
        }
    }
    return true;
}

/* Take a step whole, note what that leads to, and take it in halves, to exactly `end`. */
static bool take_in_halves(Engine *engine, Coupling *c, double now, double h, double end, bool recording) {
    const double middle = now + 0.5 * h;
    if (!solve_step(engine, c, now, h, false) || !note_full(engine, c) || !restore(engine, c, OUTER) ||
        !solve_step(engine, c, now, 0.5 * h, false)) {
        return false;
    }
    push(engine, c, now, 0.5 * h);
    return solve_step(engine, c, middle, end - middle, recording);
}

/* Whether a step that has failed may be tried again from the state before it: nothing is broken for good. */
static bool can_go_back(const Failure *failure) {
    switch ((FailureKind)failure->kind) {
        case CALL_FAILED: return failure->status != FATAL;
        case ASKS_TO_END:
        case RETURNED_EARLY:
        case OUT_OF_RANGE:
        case DISAGREEMENT: return true;
        default: return false;
    }
}

static bool is_lost(const Engine *engine, const Coupling *c) {
    bool lost = false;
    for (int64_t i = 0; i < c->n_links; i++) lost |= !isfinite(given_by(&c->links[i], engine->values));
    for (const Member *member = c->members; member < c->members + c->n_members; member++) {
        for (int64_t k = 0; k < member->n_observed; k++) lost |= !isfinite(member->observed[k]);
    }
    return lost;
}

/* Take one step from `now` towards t, in two halves; leaves in `now` where it ends. */
static bool step_adaptively(Engine *engine, Coupling *c, double *now, double t, double shortest, double longest,
                            bool recording) {
    const bool fresh = c->known == 0;
    const double begin = *now;
    double last = 0.0, h, wanted, end, middle;
    int noisy = 0;
    Errors errors;
    if (!save(engine, c, OUTER)) return false;
    for (;;) {
        const double rest = t - begin;
        wanted = smaller(larger(c->wanted, shortest), longest);
        h = wanted >= rest ? rest : wanted > 0.5 * rest ? 0.5 * rest : wanted;
        end = h == rest ? t : begin + h;
        middle = begin + 0.5 * h;
        if (!take_in_halves(engine, c, begin, h, end, recording && end == t) ||
            !find_errors(engine, c, fresh ? larger(h, c->usual) : h, &errors)) {
            if (h <= shortest || !can_go_back(&engine->failure)) return false;
            engine->failure = (Failure){0};
            errors = (Errors){INFINITY, INFINITY};
        }
        const bool lasting = last > 0.0 && errors.of_step > MACRO_FALLS * last && errors.of_whole < MACRO_NOISE;
        noisy = lasting ? noisy + 1 : 0;
        if (errors.of_step <= 1.0 || h <= shortest || noisy == 2) break;
        last = errors.of_step;
        const double shrunk = h * larger(MACRO_SHRINKAGE, smaller(MACRO_SAFETY, MACRO_SAFETY / sqrt(errors.of_step)));
        c->wanted = shrunk;
        c->rejected++;
        if (!restore(engine, c, OUTER)) return false;
    }
    if (errors.of_step == INFINITY && is_lost(engine, c)) return fail(engine, c->members[0].component, LOST);
    c->forced += errors.of_step > 1.0;
    push(engine, c, middle, end - middle);
    enlarge(engine, c);
    c->macro_steps += 2;
    if (!fresh) c->usual = h;
    const double error = smaller(larger(errors.of_step, MACRO_ERROR), 1.0 / MACRO_ERROR);
    const double factor = MACRO_SAFETY * pow(error, -0.35) * pow(c->error, 0.2);
    c->error = error;
    if (h == wanted || factor < 1.0) {
        c->wanted = h * larger(MACRO_SHRINKAGE, smaller(MACRO_GROWTH, factor));
    }
    *now = end;
    return true;
}

/* Tell whether a call has lasted long enough, within an interval in which there may be ever so many steps. */
static bool out_of_time(Coupling *c) {
    c->out_of_time = wall_clock() >= c->deadline;
    return c->out_of_time;
}

/* Step all members from `now` to t. */
static bool advance_adaptively(Engine *engine, Coupling *c, double now, double t, bool recording) {
    const double longest = smaller((t - now) / engine->parts, engine->longest);
    const double shortest = larger(SHORTEST_MACRO_STEP * smaller(c->stop, 1.0), MACRO_RESOLUTION * t);
    for (bool first = true; c->front < t; first = false) {
        if (!first && out_of_time(c)) return false;
        if (!step_adaptively(engine, c, &c->front, t, shortest, longest, recording)) return false;
    }
    return true;
}
