/* SPDX-License-Identifier: Apache-2.0
 *
 * Model Exchange: the FMU led through its modes. Between two steps it is in Continuous-Time Mode until an input is
 * set: that is an event, after which the solver starts anew. The solver may be ahead of the end of a step, with inputs
 * as they are, and what is asked for is interpolated. Events within a step are handled where they are: roots of
 * indicators, times that the FMU has announced, and those that it asks for after a step of the solver.
 */
#include <stdlib.h>
#include <string.h>

#include "exchange.h"

#define MOST_EVENTS 1000 /* at one instant */
#define LEAST_STEPS 50   /* into which a run is divided at least, so that no pair of events is stepped over */

/* What a call returns; why it has failed is kept, and what has only made steps shorter is not. */
static Status ending(Exchange *x, bool done) {
    if (done) x->trouble.kind = NO_TROUBLE;
    return done ? 0 : FAILED + 1;
}

static bool enter_event(Exchange *x) {
    if (!x->m.in_event_mode) {
        if (call_fmu(x, FMU_ENTER_EVENT_MODE) != ANSWERED) return false;
        x->m.in_event_mode = true;
    }
    x->m.dirty = true;
    return true;
}

/* Update the discrete states until they rest. */
static bool update_to_rest(Exchange *x) {
    EventInfo info;
    for (int updates = 0;; updates++) {
        if (updates == MOST_UPDATES) return fail_with(x, UPDATES_WITHOUT_END) == ANSWERED;
        if (update_once(x, &info) != ANSWERED) return false;
        if (info.terminate) return fail_with(x, WANTS_TO_END) == ANSWERED;
        if (!info.needed) break;
    }
    if (x->m.next > x->m.now + SAME_INSTANT) return true;
    x->trouble.value = x->m.next;
    return fail_with(x, EVENT_IN_THE_PAST) == ANSWERED;
}

/* Leave Event Mode, and start the solver from the states that the FMU has now. */
static bool enter_continuous_time(Exchange *x) {
    if (call_fmu(x, FMU_ENTER_CONTINUOUS_TIME_MODE) != ANSWERED) return false;
    x->m.in_event_mode = false;
    return start_solver(x) == ANSWERED;
}

static bool count_event(Exchange *x, int kind) {
    Moment *m = &x->m;
    m->counts[kind]++;
    m->repeated = m->front - m->last_event <= SAME_INSTANT ? m->repeated + 1 : 0;
    m->last_event = m->front;
    return m->repeated < MOST_EVENTS || fail_with(x, EVENTS_WITHOUT_END) == ANSWERED;
}

/* Accept the solver's last step, and handle what happens at its end. The step of the instance ends there, too, if
 * `at_end`, or if the FMU wants the simulation to end. */
static bool accept_step(Exchange *x, bool at_end, bool *event_needed, bool *terminate) {
    Moment *m = &x->m;
    bool wanted;
    m->open = false;
    if (!show_front(x) || complete_step(x, &wanted, terminate) != ANSWERED) return false;
    if (*terminate) return true;
    const bool timed = m->front >= m->next - SAME_INSTANT;
    if (!(wanted || timed || m->at_root)) return true;
    if (!count_event(x, timed ? TIME_EVENTS : m->at_root ? STATE_EVENTS : STEP_EVENTS)) return false;
    if (at_end && x->fmu.own_events) {
        *event_needed = true;
        return true;
    }
    if (!enter_event(x) || !update_to_rest(x)) return false;
    return at_end || enter_continuous_time(x); /* else it stays in Event Mode, where inputs may be set */
}

static bool step_to(Exchange *x, double target, bool *event_needed, bool *terminate) {
    Moment *m = &x->m;
    *event_needed = *terminate = false;
    if (m->in_event_mode && ((m->dirty && !update_to_rest(x)) || !enter_continuous_time(x))) return false;
    while (m->front <= target + SAME_INSTANT) {
        const bool at_end = m->front >= target - SAME_INSTANT;
        if (m->open && !accept_step(x, at_end, event_needed, terminate)) return false;
        if (at_end || *terminate) return true;
        if (!take_step(x, target)) return false;
    }
    return show_within(x, target);
}

EXPORT Status cosim_exchange_DoStep(void *exchange, double t, double h, bool no_return, bool *event_needed,
                                    bool *terminate, bool *early, double *reached) {
    Exchange *x = exchange;
    x->no_return = no_return;
    *early = false;
    *reached = t + h;
    if (t + h > x->m.stop + SAME_INSTANT) x->m.stop = t + h; /* whoever goes on from a copy may go further */
    return ending(x, step_to(x, t + h, event_needed, terminate));
}

EXPORT Status cosim_exchange_EnterEventMode(void *exchange) { return ending(exchange, enter_event(exchange)); }

EXPORT Status cosim_exchange_EnterStepMode(void *exchange) {
    return ending(exchange, enter_continuous_time(exchange));
}

EXPORT Status cosim_exchange_UpdateDiscreteStates(void *exchange, bool *needed, bool *terminate, bool *nominals,
                                                  bool *states, bool *defined, double *next) {
    EventInfo info;
    const Answer answer = update_once(exchange, &info);
    *needed = info.needed, *terminate = info.terminate, *nominals = info.nominals, *states = info.states;
    *defined = info.defined;
    *next = info.next;
    return ending(exchange, answer == ANSWERED);
}

/* Inputs are about to be set: once it is initialised, in Event Mode only. */
EXPORT Status cosim_exchange_before_inputs(void *exchange) {
    Exchange *x = exchange;
    return ending(x, !x->m.initialized || enter_event(x));
}

/* The FMU has left Initialization Mode, for a run to stop, which is infinite if it is not known. */
EXPORT Status cosim_exchange_begin(void *exchange, double tolerance, double stop) {
    Exchange *x = exchange;
    x->m.tolerance = tolerance;
    x->m.stop = stop;
    x->m.longest = stop / LEAST_STEPS;
    x->m.initialized = x->m.in_event_mode = x->m.dirty = true;
    return ending(x, x->fmu.own_events || update_to_rest(x));
}

/* Arrays one after the other. */
static double *next_of(double **free, size_t n) {
    double *const array = *free;
    *free += n;
    return array;
}

/* A new instance, null if there is no memory for it. */
EXPORT void *cosim_exchange_new(const Known *fmu) {
    const size_t n = (size_t)fmu->n_states, n_z = (size_t)fmu->n_indicators;
    const size_t n_kept = (6 + RODAS_DENSE) * n + 2 * n_z;
    const size_t doubles = n_kept + (RODAS_STAGES + 5 + 2 * n) * n + LOOKS * n_z;
    const size_t others = n * (sizeof(ValueReference) + 2 * sizeof(int32_t) + sizeof(int));
    Exchange *x = calloc(1, sizeof *x + doubles * sizeof(double) + others);
    if (!x) return NULL;
    double *place = (double *)(x + 1);
    x->fmu = *fmu;
    x->n_kept = n_kept;
    x->kept = place;
    double **kept[] = {&x->x,        &x->f,        &x->nominal,  &x->start, &x->end,
                       &x->dense[0], &x->dense[1], &x->dense[2], &x->was};
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++) *kept[i] = next_of(&place, n);
    x->side = next_of(&place, n_z);
    x->looks = next_of(&place, LOOKS * n_z); /* the first of them is kept, too: the last one of the step before */
    for (int i = 0; i < RODAS_STAGES; i++) x->K[i] = next_of(&place, n);
    double **scratch[] = {&x->f_t, &x->trial, &x->rates, &x->seed, &x->gain};
    for (size_t i = 0; i < sizeof scratch / sizeof *scratch; i++) *scratch[i] = next_of(&place, n);
    x->J = next_of(&place, n * n);
    x->W = next_of(&place, n * n);
    x->seeded = (ValueReference *)place;
    x->moving = (int32_t *)(x->seeded + n);
    x->alone = x->moving + n;
    x->pivots = (int *)(x->alone + n);
    for (size_t i = 0; i < n; i++) x->nominal[i] = 1.0;
    x->m.renominal = true;
    x->m.next = INFINITY;
    x->m.last_event = -INFINITY;
    return x;
}

EXPORT void cosim_exchange_delete(void *exchange) { free(exchange); }

EXPORT void cosim_exchange_count(const void *exchange, int64_t counts[COUNTERS]) {
    memcpy(counts, ((const Exchange *)exchange)->m.counts, COUNTERS * sizeof *counts);
}

/* Why the last call has failed; it is forgotten with that. */
EXPORT void cosim_exchange_explain(void *exchange, Trouble *trouble) {
    Exchange *x = exchange;
    *trouble = x->trouble;
    x->trouble = (Trouble){0};
}

EXPORT int64_t cosim_exchange_size(void) { return sizeof(Known); }
