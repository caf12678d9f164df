/* SPDX-License-Identifier: MIT-0
 *
 * The functions of FMI 2.0 that this FMU does not offer: they have to be there, and return an error. The headers are left
 * out on purpose, so that one line per function is enough.
 */
#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
#define ERROR 3
#define UNUSED(name)         \
    EXPORT int name(void); \
    EXPORT int name(void) { return ERROR; }

UNUSED(fmi2GetInteger)
UNUSED(fmi2GetBoolean)
UNUSED(fmi2GetString)
UNUSED(fmi2SetInteger)
UNUSED(fmi2SetBoolean)
UNUSED(fmi2SetString)
UNUSED(fmi2GetFMUstate)
UNUSED(fmi2SetFMUstate)
UNUSED(fmi2FreeFMUstate)
UNUSED(fmi2SerializedFMUstateSize)
UNUSED(fmi2SerializeFMUstate)
UNUSED(fmi2DeSerializeFMUstate)
UNUSED(fmi2GetDirectionalDerivative)
UNUSED(fmi2EnterEventMode)
UNUSED(fmi2NewDiscreteStates)
UNUSED(fmi2EnterContinuousTimeMode)
UNUSED(fmi2CompletedIntegratorStep)
UNUSED(fmi2SetTime)
UNUSED(fmi2SetContinuousStates)
UNUSED(fmi2GetDerivatives)
UNUSED(fmi2GetEventIndicators)
UNUSED(fmi2GetContinuousStates)
UNUSED(fmi2GetNominalsOfContinuousStates)
UNUSED(fmi2SetRealInputDerivatives)
UNUSED(fmi2GetRealOutputDerivatives)
UNUSED(fmi2CancelStep)
UNUSED(fmi2GetStatus)
UNUSED(fmi2GetRealStatus)
UNUSED(fmi2GetIntegerStatus)
UNUSED(fmi2GetBooleanStatus)
UNUSED(fmi2GetStringStatus)
