/* SPDX-License-Identifier: Apache-2.0
 *
 * Model Exchange: what is asked of the FMU. Each call is noted, for a run that another process looks after.
 */
#include "exchange.h"

#define DISCARD 2
#define NOWHERE (-1)

typedef Status (*OfInstance)(void *);
typedef Status (*OfTime)(void *, double);
typedef Status (*OfVector)(void *, double *, size_t);
typedef Status (*Complete2)(void *, int, int *, int *);
typedef Status (*Complete3)(void *, bool, bool *, bool *);
typedef Status (*Direction2)(void *, const ValueReference *, size_t, const ValueReference *, size_t, const double *,
                             double *);
typedef Status (*Direction3)(void *, const ValueReference *, size_t, const ValueReference *, size_t, const double *,
                             size_t, double *, size_t);

/* fmi2EventInfo */
typedef struct {
    int needed, terminate, nominals, states, defined;
    double next;
} EventInfo;
typedef Status (*Update2)(void *, EventInfo *);

static void note_call(const Exchange *x, FmuFunction function) {
    x->fmu.at->calls++;
    x->fmu.at->call = (Call){x->fmu.number, x->fmu.numbers[function]};
}

static Answer fail_with(Exchange *x, TroubleKind kind) {
    x->trouble.kind = kind;
    x->trouble.t = x->m.now;
    return ENDED;
}

/* After a call; what has failed is kept, in case that no shorter step helps. */
static Answer judge_call(Exchange *x, FmuFunction function, Status status) {
    x->fmu.at->call.component = NOWHERE;
    if (status < FAILED) return ANSWERED;
    x->trouble.function = (int32_t)function;
    x->trouble.status = status;
    fail_with(x, FUNCTION_FAILED);
    return status == DISCARD ? DISCARDED : ENDED;
}

static Answer call_fmu(Exchange *x, FmuFunction function) {
    note_call(x, function);
    return judge_call(x, function, ((OfInstance)x->fmu.functions[function])(x->fmu.instance));
}

static Answer exchange_vector(Exchange *x, FmuFunction function, double *values, int64_t n) {
    note_call(x, function);
    return judge_call(x, function, ((OfVector)x->fmu.functions[function])(x->fmu.instance, values, (size_t)n));
}

/* Put the FMU to a time and states. */
static Answer put(Exchange *x, double t, double *states) {
    x->m.now = t;
    x->m.placed = false;
    note_call(x, FMU_SET_TIME);
    const Status status = ((OfTime)x->fmu.functions[FMU_SET_TIME])(x->fmu.instance, t);
    const Answer answer = judge_call(x, FMU_SET_TIME, status);
    if (answer != ANSWERED || x->fmu.n_states == 0) return answer;
    return exchange_vector(x, FMU_SET_STATES, states, x->fmu.n_states);
}

/* The rates of the states where the FMU is. */
static Answer rates_here(Exchange *x, double *rates) {
    x->m.counts[RHS_EVALUATIONS]++;
    const Answer answer = exchange_vector(x, FMU_GET_RATES, rates, x->fmu.n_states);
    if (answer != ANSWERED) return answer;
    for (int i = 0; i < (int)x->fmu.n_states; i++) {
        if (isfinite(rates[i])) continue;
        fail_with(x, NOT_FINITE);
        x->trouble.state = i;
        return DISCARDED;
    }
    return ANSWERED;
}

static Answer rates_at(Exchange *x, double t, double *states, double *rates) {
    const Answer answer = put(x, t, states);
    return answer == ANSWERED ? rates_here(x, rates) : answer;
}

/* The event indicators where the FMU is. */
static Answer indicators_here(Exchange *x, double *indicators) {
    return exchange_vector(x, FMU_GET_INDICATORS, indicators, x->fmu.n_indicators);
}

/* What the rates gain along the states `seeded`, each by its seed. */
static Answer gain_along(Exchange *x, size_t n_seeded) {
    const Known *fmu = &x->fmu;
    const Function function = fmu->functions[FMU_GET_DIRECTIONAL_DERIVATIVE];
    const size_t n = (size_t)fmu->n_states;
    note_call(x, FMU_GET_DIRECTIONAL_DERIVATIVE);
    const Status status =
        fmu->fmi == 2
            ? ((Direction2)function)(fmu->instance, fmu->rates, n, x->seeded, n_seeded, x->seed, x->gain)
            : ((Direction3)function)(fmu->instance, fmu->rates, n, x->seeded, n_seeded, x->seed, n_seeded, x->gain, n);
    return judge_call(x, FMU_GET_DIRECTIONAL_DERIVATIVE, status);
}

/* Tell the FMU that a step is accepted; it may want an event, or the end. */
static Answer complete_step(Exchange *x, bool *wants_event, bool *wants_end) {
    *wants_event = *wants_end = false;
    if (!x->fmu.completes) return ANSWERED;
    const Function function = x->fmu.functions[FMU_COMPLETE_STEP];
    Status status;
    note_call(x, FMU_COMPLETE_STEP);
    if (x->fmu.fmi == 2) {
        int event = 0, end = 0;
        status = ((Complete2)function)(x->fmu.instance, x->no_return, &event, &end);
        *wants_event = event, *wants_end = end;
    } else {
        status = ((Complete3)function)(x->fmu.instance, x->no_return, wants_event, wants_end);
    }
    return judge_call(x, FMU_COMPLETE_STEP, status);
}

/* Update the discrete states once. */
static Answer update_once(Exchange *x, EventInfo *info) {
    const Function function = x->fmu.functions[FMU_UPDATE];
    Status status;
    *info = (EventInfo){0};
    note_call(x, FMU_UPDATE);
    if (x->fmu.fmi == 2) {
        status = ((Update2)function)(x->fmu.instance, info);
    } else {
        bool needed = false, terminate = false, nominals = false, states = false, defined = false;
        status = ((Update)function)(x->fmu.instance, &needed, &terminate, &nominals, &states, &defined, &info->next);
        *info = (EventInfo){needed, terminate, nominals, states, defined, info->next};
    }
    x->m.dirty = false;
    x->m.next = info->defined ? info->next : INFINITY;
    x->m.moved |= info->states != 0;
    x->m.renominal |= info->nominals != 0;
    return judge_call(x, FMU_UPDATE, status);
}
