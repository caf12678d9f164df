/* SPDX-License-Identifier: Apache-2.0
 *
 * Model Exchange: variables and derivatives, as FMI 2.0 and 3.0 have them: handed on to the FMU, which is led into
 * Event Mode before an input is set.
 */
#include "exchange.h"

typedef Status (*Access2Of)(void *, const ValueReference *, size_t, void *);
typedef Status (*Access3Of)(void *, const ValueReference *, size_t, void *, size_t);
typedef Status (*AccessBinaryOf)(void *, const ValueReference *, size_t, size_t *, void *, size_t);

/* The caller has noted its own call, and gets the note back. */
static bool may_set(Exchange *x) {
    const Call outer = x->fmu.at->call;
    const bool may = !x->m.initialized || enter_event(x);
    if (may) x->fmu.at->call = outer;
    return may;
}

#define GET_AND_SET_2(Type)                                                                             \
    EXPORT Status cosim_exchange2_Get##Type(void *exchange, const ValueReference *references, size_t n, \
                                            void *values) {                                             \
        const Exchange *x = exchange;                                                                   \
        return ((Access2Of)x->fmu.functions[FMU_GET_##Type])(x->fmu.instance, references, n, values);   \
    }                                                                                                   \
    EXPORT Status cosim_exchange2_Set##Type(void *exchange, const ValueReference *references, size_t n, \
                                            void *values) {                                             \
        Exchange *x = exchange;                                                                         \
        if (!may_set(x)) return ending(x, false);                                                       \
        return ((Access2Of)x->fmu.functions[FMU_SET_##Type])(x->fmu.instance, references, n, values);   \
    }
GET_AND_SET_2(Real)
GET_AND_SET_2(Integer)
GET_AND_SET_2(Boolean)
GET_AND_SET_2(String)

#define GET_AND_SET_3(Type)                                                                                     \
    EXPORT Status cosim_exchange3_Get##Type(void *exchange, const ValueReference *references, size_t n,         \
                                            void *values, size_t n_values) {                                    \
        const Exchange *x = exchange;                                                                           \
        return ((Access3Of)x->fmu.functions[FMU_GET_##Type])(x->fmu.instance, references, n, values, n_values); \
    }                                                                                                           \
    EXPORT Status cosim_exchange3_Set##Type(void *exchange, const ValueReference *references, size_t n,         \
                                            void *values, size_t n_values) {                                    \
        Exchange *x = exchange;                                                                                 \
        if (!may_set(x)) return ending(x, false);                                                               \
        return ((Access3Of)x->fmu.functions[FMU_SET_##Type])(x->fmu.instance, references, n, values, n_values); \
    }
GET_AND_SET_3(Float64)
GET_AND_SET_3(Float32)
GET_AND_SET_3(Int8)
GET_AND_SET_3(UInt8)
GET_AND_SET_3(Int16)
GET_AND_SET_3(UInt16)
GET_AND_SET_3(Int32)
GET_AND_SET_3(UInt32)
GET_AND_SET_3(Int64)
GET_AND_SET_3(UInt64)
GET_AND_SET_3(Boolean)
GET_AND_SET_3(String)

EXPORT Status cosim_exchange3_GetBinary(void *exchange, const ValueReference *references, size_t n, size_t *sizes,
                                        void *values, size_t n_values) {
    const Exchange *x = exchange;
    const AccessBinaryOf function = (AccessBinaryOf)x->fmu.functions[FMU_GET_Binary];
    return function(x->fmu.instance, references, n, sizes, values, n_values);
}

EXPORT Status cosim_exchange3_SetBinary(void *exchange, const ValueReference *references, size_t n, size_t *sizes,
                                        void *values, size_t n_values) {
    Exchange *x = exchange;
    if (!may_set(x)) return ending(x, false);
    const AccessBinaryOf function = (AccessBinaryOf)x->fmu.functions[FMU_SET_Binary];
    return function(x->fmu.instance, references, n, sizes, values, n_values);
}

EXPORT Status cosim_exchange2_GetDirectionalDerivative(void *exchange, const ValueReference *unknowns,
                                                       size_t n_unknowns, const ValueReference *knowns,
                                                       size_t n_knowns, const double *seed, double *sensitivity) {
    const Exchange *x = exchange;
    const Direction2 function = (Direction2)x->fmu.functions[FMU_GET_DIRECTIONAL_DERIVATIVE];
    return function(x->fmu.instance, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity);
}

EXPORT Status cosim_exchange3_GetDirectionalDerivative(void *exchange, const ValueReference *unknowns,
                                                       size_t n_unknowns, const ValueReference *knowns,
                                                       size_t n_knowns, const double *seed, size_t n_seed,
                                                       double *sensitivity, size_t n_sensitivity) {
    const Exchange *x = exchange;
    const Direction3 function = (Direction3)x->fmu.functions[FMU_GET_DIRECTIONAL_DERIVATIVE];
    return function(x->fmu.instance, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, sensitivity, n_sensitivity);
}
