/* SPDX-License-Identifier: MIT-0
 *
 * The FMI functions that the test FMUs do not need: each returns the status Error. They have to be there, since fmpy
 * looks all of them up. The headers are left out on purpose, so that one line per function is enough.
 */
#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
#define STUB(name) EXPORT int name(void) { return 3; }

#if FMI == 2
#if !defined CHECKED && !defined SAVES
STUB(fmi2GetFMUstate)
STUB(fmi2SetFMUstate)
STUB(fmi2FreeFMUstate)
STUB(fmi2SerializedFMUstateSize)
STUB(fmi2SerializeFMUstate)
STUB(fmi2DeSerializeFMUstate)
#endif
#if !defined CHECKED && !defined DIRECTIONAL
STUB(fmi2GetDirectionalDerivative)
#endif
#ifndef CHECKED
STUB(fmi2GetRealOutputDerivatives)
#endif
#ifndef EXCHANGE
STUB(fmi2EnterEventMode)
STUB(fmi2NewDiscreteStates)
STUB(fmi2EnterContinuousTimeMode)
STUB(fmi2CompletedIntegratorStep)
STUB(fmi2SetTime)
STUB(fmi2SetContinuousStates)
STUB(fmi2GetDerivatives)
STUB(fmi2GetEventIndicators)
STUB(fmi2GetContinuousStates)
STUB(fmi2GetNominalsOfContinuousStates)
#endif
STUB(fmi2SetRealInputDerivatives)
STUB(fmi2CancelStep)
STUB(fmi2GetStatus)
STUB(fmi2GetRealStatus)
STUB(fmi2GetIntegerStatus)
STUB(fmi2GetStringStatus)
#else
#ifdef EXCHANGE
STUB(fmi3InstantiateCoSimulation)
STUB(fmi3EnterStepMode)
STUB(fmi3DoStep)
#else
STUB(fmi3InstantiateModelExchange)
STUB(fmi3EnterContinuousTimeMode)
STUB(fmi3CompletedIntegratorStep)
STUB(fmi3SetTime)
STUB(fmi3SetContinuousStates)
STUB(fmi3GetContinuousStateDerivatives)
STUB(fmi3GetEventIndicators)
STUB(fmi3GetContinuousStates)
STUB(fmi3GetNominalsOfContinuousStates)
STUB(fmi3GetNumberOfEventIndicators)
STUB(fmi3GetNumberOfContinuousStates)
#endif
STUB(fmi3InstantiateScheduledExecution)
#ifndef BINARY
STUB(fmi3GetBinary)
STUB(fmi3SetBinary)
#endif
STUB(fmi3GetClock)
STUB(fmi3SetClock)
STUB(fmi3GetNumberOfVariableDependencies)
STUB(fmi3GetVariableDependencies)
#if !defined CHECKED && !defined SAVES
STUB(fmi3GetFMUState)
STUB(fmi3SetFMUState)
STUB(fmi3FreeFMUState)
STUB(fmi3SerializedFMUStateSize)
STUB(fmi3SerializeFMUState)
STUB(fmi3DeserializeFMUState)
#endif
#if !defined CHECKED && !defined DIRECTIONAL
STUB(fmi3GetDirectionalDerivative)
#endif
#ifndef CHECKED
STUB(fmi3GetAdjointDerivative)
STUB(fmi3GetOutputDerivatives)
#endif
STUB(fmi3EnterConfigurationMode)
STUB(fmi3ExitConfigurationMode)
STUB(fmi3GetIntervalDecimal)
STUB(fmi3GetIntervalFraction)
STUB(fmi3GetShiftDecimal)
STUB(fmi3GetShiftFraction)
STUB(fmi3SetIntervalDecimal)
STUB(fmi3SetIntervalFraction)
STUB(fmi3SetShiftDecimal)
STUB(fmi3SetShiftFraction)
STUB(fmi3EvaluateDiscreteStates)
STUB(fmi3ActivateModelPartition)
#endif
