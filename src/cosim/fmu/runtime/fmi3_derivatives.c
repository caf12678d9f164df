/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0: directional and adjoint derivatives, and derivatives of outputs in time. All variables are scalars.
 */
#include "derivatives.h"
#include "fmi3Functions.h"
#include "instance.h"

static Simulation *entering(fmi3Instance instance, const char *function, Call call, size_t n_given, size_t n_seed,
                            size_t n_wanted, size_t n_sensitivity)
{
    Simulation *m = instance_entering(instance, call, function);
    if (!m || (n_given == n_seed && n_wanted == n_sensitivity)) return m;
    instance_error(m, "%s: %zu seeds for %zu variables, %zu sensitivities for %zu; all variables are scalars.",
                   function, n_seed, n_given, n_sensitivity, n_wanted);
    return NULL;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    Simulation *m = entering(instance, __func__, CALL_GET_DIRECTIONAL_DERIVATIVES, nKnowns, nSeed, nUnknowns,
                             nSensitivity);
    if (!m) return fmi3Error;
    return (fmi3Status)derivatives_forward(m, __func__, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    Simulation *m = entering(instance, __func__, CALL_GET_DIRECTIONAL_DERIVATIVES, nUnknowns, nSeed, nKnowns,
                             nSensitivity);
    if (!m) return fmi3Error;
    return (fmi3Status)derivatives_adjoint(m, __func__, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues)
{
    Simulation *m = entering(instance, __func__, CALL_GET_OUTPUT_DERIVATIVES, nValueReferences, nValueReferences,
                             nValueReferences, nValues);
    if (!m) return fmi3Error;
    return (fmi3Status)derivatives_in_time(m, __func__, valueReferences, nValueReferences, orders, values);
}
