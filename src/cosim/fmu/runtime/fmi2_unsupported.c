/* SPDX-License-Identifier: MIT-0
 *
 * FMI 2.0 functions that the FMU does not offer and modelDescription.xml does not announce: those of Model Exchange, and
 * derivatives. They must exist all the same; each says that it is not supported.
 */
#include "fmi2Functions.h"
#include "instance.h"

/* The signatures are FMI's, and nobody looks at the arguments. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

static fmi2Status unsupported(fmi2Component c, const char *function)
{
    if (!c) return fmi2Error;
    return (fmi2Status)instance_error(c, "%s is not supported by this FMU.", function);
}

/* Asking for no variable at all is no mistake. */
static fmi2Status unsupported_if_any(fmi2Component c, const char *function, size_t n)
{
    return c && n == 0 ? fmi2OK : unsupported(c, function);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    return unsupported_if_any(c, __func__, nvr);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *fmi2eventInfo)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    return unsupported(c, __func__);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    return unsupported(c, __func__);
}
