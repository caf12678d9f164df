/* SPDX-License-Identifier: MIT-0
 *
 * FMI 2.0: directional derivatives, and derivatives of outputs in time.
 */
#include "derivatives.h"
#include "fmi2Functions.h"
#include "instance.h"

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[])
{
    Simulation *m = instance_entering(c, CALL_GET_DIRECTIONAL_DERIVATIVES, __func__);
    if (!m) return fmi2Error;
    return (fmi2Status)derivatives_forward(m, __func__, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    Simulation *m = instance_entering(c, CALL_GET_OUTPUT_DERIVATIVES, __func__);
    if (!m) return fmi2Error;
    return (fmi2Status)derivatives_in_time(m, __func__, vr, nvr, order, value);
}
