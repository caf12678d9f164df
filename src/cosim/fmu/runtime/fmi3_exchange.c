/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0: Model Exchange, but for what it has in common with Event Mode in Co-Simulation.
 */
#include "exchange.h"
#include "fmi3Functions.h"

#define ENTER(call)                                              \
    Simulation *m = instance_entering(instance, call, __func__); \
    if (!m) return fmi3Error

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    ENTER(CALL_ENTER_CONTINUOUS_TIME);
    return (fmi3Status)exchange_enter_continuous_time_mode(m, __func__);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    ENTER(CALL_COMPLETED_STEP);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!enterEventMode || !terminateSimulation)
        return (fmi3Status)instance_error(m, "%s: an output argument is null.", __func__);
    *enterEventMode = fmi3False;
    *terminateSimulation = m->s.terminate != 0;
    return (fmi3Status)exchange_complete_step(m, __func__);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    ENTER(CALL_SET_TIME);
    return (fmi3Status)exchange_set_time(m, __func__, time);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    ENTER(CALL_SET_STATES);
    return (fmi3Status)exchange_set_states(m, __func__, continuousStates, nContinuousStates);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates)
{
    ENTER(CALL_GET_CONTINUOUS);
    return (fmi3Status)exchange_get_derivatives(m, __func__, derivatives, nContinuousStates);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    ENTER(CALL_GET_CONTINUOUS);
    return (fmi3Status)exchange_get_indicators(m, __func__, eventIndicators, nEventIndicators);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    ENTER(CALL_GET_CONTINUOUS);
    return (fmi3Status)exchange_get_states(m, __func__, continuousStates, nContinuousStates);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    ENTER(CALL_GET_SIZES);
    return (fmi3Status)exchange_get_nominals(m, __func__, nominals, nContinuousStates);
}

static fmi3Status tell(Simulation *m, const char *function, size_t *place, size_t n)
{
    if (!place) return (fmi3Status)instance_error(m, "%s: the output argument is null.", function);
    *place = n;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    ENTER(CALL_GET_SIZES);
    return tell(m, __func__, nEventIndicators, exchange_indicators());
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    ENTER(CALL_GET_SIZES);
    return tell(m, __func__, nContinuousStates, MODEL_NX);
}
