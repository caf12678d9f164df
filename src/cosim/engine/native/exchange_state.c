/* SPDX-License-Identifier: Apache-2.0
 *
 * Model Exchange: copies of an instance's state, the FMU's and the solver's.
 */
#include <stdlib.h>
#include <string.h>

#include "exchange.h"

typedef Status (*OfState)(void *, void *);
typedef Status (*OfStatePlace)(void *, void **);
typedef Status (*SizeOf)(void *, void *, size_t *);
typedef Status (*Serialize)(void *, void *, uint8_t *, size_t);
typedef Status (*Deserialize)(void *, const uint8_t *, size_t, void **);

typedef struct {
    void *fmu;
    Moment m;
    double kept[];
} Saved;

static size_t saved_size(const Exchange *x) { return sizeof(Saved) + x->n_kept * sizeof(double); }

static Saved *new_state(const Exchange *x) { return calloc(1, saved_size(x)); }

static Status no_memory(Exchange *x) {
    fail_with(x, FUNCTION_FAILED);
    x->trouble.function = FMU_GET_STATE;
    return x->trouble.status = FAILED + 1;
}

EXPORT Status cosim_exchange_GetFMUState(void *exchange, void **state) {
    Exchange *x = exchange;
    Saved *saved = *state ? *state : new_state(x);
    if (!saved) return no_memory(x);
    note_call(x, FMU_GET_STATE);
    const Status status = ((OfStatePlace)x->fmu.functions[FMU_GET_STATE])(x->fmu.instance, &saved->fmu);
    if (judge_call(x, FMU_GET_STATE, status) != ANSWERED) {
        if (!*state) free(saved);
        return status;
    }
    saved->m = x->m;
    memcpy(saved->kept, x->kept, x->n_kept * sizeof(double));
    *state = saved;
    return status;
}

EXPORT Status cosim_exchange_SetFMUState(void *exchange, void *state) {
    Exchange *x = exchange;
    const Saved *saved = state;
    note_call(x, FMU_SET_STATE);
    const Status status = ((OfState)x->fmu.functions[FMU_SET_STATE])(x->fmu.instance, saved->fmu);
    if (judge_call(x, FMU_SET_STATE, status) != ANSWERED) return status;
    x->m = saved->m;
    memcpy(x->kept, saved->kept, x->n_kept * sizeof(double));
    x->trouble = (Trouble){0};
    return status;
}

EXPORT Status cosim_exchange_FreeFMUState(void *exchange, void **state) {
    Exchange *x = exchange;
    Saved *saved = *state;
    if (!saved) return 0;
    note_call(x, FMU_FREE_STATE);
    const Status status = ((OfStatePlace)x->fmu.functions[FMU_FREE_STATE])(x->fmu.instance, &saved->fmu);
    free(saved);
    *state = NULL;
    judge_call(x, FMU_FREE_STATE, status);
    return status;
}

EXPORT Status cosim_exchange_SerializedFMUStateSize(void *exchange, void *state, size_t *size) {
    Exchange *x = exchange;
    note_call(x, FMU_STATE_SIZE);
    const Status status =
        ((SizeOf)x->fmu.functions[FMU_STATE_SIZE])(x->fmu.instance, ((const Saved *)state)->fmu, size);
    *size += saved_size(x);
    judge_call(x, FMU_STATE_SIZE, status);
    return status;
}

/* Ours comes first. */
EXPORT Status cosim_exchange_SerializeFMUState(void *exchange, void *state, uint8_t *bytes, size_t size) {
    Exchange *x = exchange;
    const size_t own = saved_size(x);
    if (size < own) return FAILED + 1;
    memcpy(bytes, state, own);
    memset(bytes + offsetof(Saved, fmu), 0, sizeof(void *));
    note_call(x, FMU_SERIALIZE);
    const Serialize function = (Serialize)x->fmu.functions[FMU_SERIALIZE];
    const Status status = function(x->fmu.instance, ((const Saved *)state)->fmu, bytes + own, size - own);
    judge_call(x, FMU_SERIALIZE, status);
    return status;
}

EXPORT Status cosim_exchange_DeserializeFMUState(void *exchange, const uint8_t *bytes, size_t size, void **state) {
    Exchange *x = exchange;
    const size_t own = saved_size(x);
    if (size < own) return FAILED + 1;
    Saved *saved = *state ? *state : new_state(x);
    if (!saved) return no_memory(x);
    void *const fmu = saved->fmu;
    memcpy(saved, bytes, own);
    saved->fmu = fmu;
    note_call(x, FMU_DESERIALIZE);
    const Deserialize function = (Deserialize)x->fmu.functions[FMU_DESERIALIZE];
    const Status status = function(x->fmu.instance, bytes + own, size - own, &saved->fmu);
    if (judge_call(x, FMU_DESERIALIZE, status) != ANSWERED && !*state) {
        free(saved);
        return status;
    }
    *state = saved;
    return status;
}
