/* SPDX-License-Identifier: MIT-0
 *
 * The functions of FMI 3.0 that this FMU does not offer: they have to be there, and return an error. The headers are left
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

EXPORT void *fmi3InstantiateModelExchange(void);
EXPORT void *fmi3InstantiateModelExchange(void) { return 0; }
EXPORT void *fmi3InstantiateScheduledExecution(void);
EXPORT void *fmi3InstantiateScheduledExecution(void) { return 0; }
UNUSED(fmi3EnterEventMode)
UNUSED(fmi3GetFloat32)
UNUSED(fmi3GetInt8)
UNUSED(fmi3GetUInt8)
UNUSED(fmi3GetInt16)
UNUSED(fmi3GetUInt16)
UNUSED(fmi3GetInt32)
UNUSED(fmi3GetUInt32)
UNUSED(fmi3GetInt64)
UNUSED(fmi3GetUInt64)
UNUSED(fmi3GetBoolean)
UNUSED(fmi3GetString)
UNUSED(fmi3GetBinary)
UNUSED(fmi3GetClock)
UNUSED(fmi3SetFloat32)
UNUSED(fmi3SetInt8)
UNUSED(fmi3SetUInt8)
UNUSED(fmi3SetInt16)
UNUSED(fmi3SetUInt16)
UNUSED(fmi3SetInt32)
UNUSED(fmi3SetUInt32)
UNUSED(fmi3SetInt64)
UNUSED(fmi3SetUInt64)
UNUSED(fmi3SetBoolean)
UNUSED(fmi3SetString)
UNUSED(fmi3SetBinary)
UNUSED(fmi3SetClock)
UNUSED(fmi3GetNumberOfVariableDependencies)
UNUSED(fmi3GetVariableDependencies)
UNUSED(fmi3GetFMUState)
UNUSED(fmi3SetFMUState)
UNUSED(fmi3FreeFMUState)
UNUSED(fmi3SerializedFMUStateSize)
UNUSED(fmi3SerializeFMUState)
UNUSED(fmi3DeserializeFMUState)
UNUSED(fmi3GetDirectionalDerivative)
UNUSED(fmi3GetAdjointDerivative)
UNUSED(fmi3EnterConfigurationMode)
UNUSED(fmi3ExitConfigurationMode)
UNUSED(fmi3GetIntervalDecimal)
UNUSED(fmi3GetIntervalFraction)
UNUSED(fmi3GetShiftDecimal)
UNUSED(fmi3GetShiftFraction)
UNUSED(fmi3SetIntervalDecimal)
UNUSED(fmi3SetIntervalFraction)
UNUSED(fmi3SetShiftDecimal)
UNUSED(fmi3SetShiftFraction)
UNUSED(fmi3EvaluateDiscreteStates)
UNUSED(fmi3UpdateDiscreteStates)
UNUSED(fmi3EnterContinuousTimeMode)
UNUSED(fmi3CompletedIntegratorStep)
UNUSED(fmi3SetTime)
UNUSED(fmi3SetContinuousStates)
UNUSED(fmi3GetContinuousStateDerivatives)
UNUSED(fmi3GetEventIndicators)
UNUSED(fmi3GetContinuousStates)
UNUSED(fmi3GetNominalsOfContinuousStates)
UNUSED(fmi3GetNumberOfEventIndicators)
UNUSED(fmi3GetNumberOfContinuousStates)
UNUSED(fmi3EnterStepMode)
UNUSED(fmi3GetOutputDerivatives)
UNUSED(fmi3ActivateModelPartition)
