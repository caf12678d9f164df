/* SPDX-License-Identifier: MIT-0
 *
 * FMI 2.0: Model Exchange.
 */
#include "exchange.h"
#include "fmi2Functions.h"

#define ENTER(call)                                       \
    Simulation *m = instance_entering(c, call, __func__); \
    if (!m) return fmi2Error

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    ENTER(CALL_ENTER_EVENT_MODE_AGAIN);
    return (fmi2Status)exchange_enter_event_mode(m, __func__);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    ENTER(CALL_UPDATE_DISCRETE_STATES);
    if (!eventInfo) return (fmi2Status)instance_error(m, "%s: eventInfo is null.", __func__);
    Update update;
    int status = instance_update(m, __func__, &update);
    if (status != STATUS_OK) return (fmi2Status)status;
    eventInfo->newDiscreteStatesNeeded = fmi2False;
    eventInfo->terminateSimulation = update.terminate;
    eventInfo->nominalsOfContinuousStatesChanged = fmi2False;
    eventInfo->valuesOfContinuousStatesChanged = update.states_changed;
    eventInfo->nextEventTimeDefined = update.has_next;
    eventInfo->nextEventTime = update.next;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    ENTER(CALL_ENTER_CONTINUOUS_TIME);
    return (fmi2Status)exchange_enter_continuous_time_mode(m, __func__);
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    ENTER(CALL_COMPLETED_STEP);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!enterEventMode || !terminateSimulation)
        return (fmi2Status)instance_error(m, "%s: an output argument is null.", __func__);
    *enterEventMode = fmi2False;
    *terminateSimulation = m->s.terminate != 0;
    return (fmi2Status)exchange_complete_step(m, __func__);
}

/* Of a model that has nothing but events FMI allows to go from one event to the next without Continuous-Time Mode. */
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ENTER(MODEL_NX > 0 || exchange_indicators() > 0 ? CALL_SET_TIME : CALL_SET_TIME_AFTER_EVENT);
    return (fmi2Status)exchange_set_time(m, __func__, time);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    ENTER(CALL_SET_STATES);
    return (fmi2Status)exchange_set_states(m, __func__, x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    ENTER(CALL_GET_CONTINUOUS);
    return (fmi2Status)exchange_get_derivatives(m, __func__, derivatives, nx);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    ENTER(CALL_GET_CONTINUOUS);
    return (fmi2Status)exchange_get_indicators(m, __func__, eventIndicators, ni);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    ENTER(CALL_GET_CONTINUOUS);
    return (fmi2Status)exchange_get_states(m, __func__, x, nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    ENTER(CALL_GET_SIZES);
    return (fmi2Status)exchange_get_nominals(m, __func__, x_nominal, nx);
}
