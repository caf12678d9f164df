/* SPDX-License-Identifier: MIT-0
 *
 * FMI 2.0 functions that the FMU does not offer and modelDescription.xml does not announce. They must exist all the
 * same; each says that it is not supported.
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
