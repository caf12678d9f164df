/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0 for Co-Simulation: life cycle, modes and steps.
 */
#include <math.h>
#include <stdlib.h>

#include "fmi3Functions.h"
#include "instance.h"

typedef struct {
    Simulation sim; /* first: see instance.h */
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log_message;
    bool event_mode_used, early_return_allowed;
} Instance;

static void say(void *context, LogKind kind, const char *text)
{
    const Instance *i = context;
    if (i->log_message) i->log_message(i->environment, (fmi3Status)log_status(kind), log_category(kind), text);
}

const char *instance_mode_name(int mode)
{
    switch (mode) {
    case INSTANTIATED: return "before Initialization Mode";
    case INITIALIZATION_MODE: return "in Initialization Mode";
    case EVENT_MODE: return "in Event Mode";
    case STEP_MODE: return "in Step Mode";
    case TERMINATED: return "after fmi3Terminate";
    default: return "after an error; call fmi3Reset, fmi3SetFMUState or fmi3FreeInstance";
    }
}

#define ENTER(allowed_modes)                                              \
    Simulation *m = instance_entering(instance, allowed_modes, __func__); \
    if (!m) return fmi3Error

static fmi3Status error(Simulation *m, const char *text)
{
    return (fmi3Status)instance_error(m, "%s", text);
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    ENTER(ANY_MODE);
    return (fmi3Status)instance_log_events(m, __func__, loggingOn, nCategories, categories);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)resourcePath, (void)visible, (void)requiredIntermediateVariables, (void)nRequiredIntermediateVariables;
    (void)intermediateUpdate;
    Instance blank = {.environment = instanceEnvironment, .log_message = logMessage};
    blank.sim.log = say;
    blank.sim.log_context = &blank;
    if (!instance_may_begin(&blank.sim, instanceName, instantiationToken, __func__)) return NULL;
    Instance *i = instance_new(sizeof *i, say, loggingOn);
    if (!i) {
        instance_error(&blank.sim, "%s: out of memory.", instanceName);
        return NULL;
    }
    i->environment = instanceEnvironment;
    i->log_message = logMessage;
    i->event_mode_used = eventModeUsed;
    i->early_return_allowed = earlyReturnAllowed;
    return i;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    ENTER(INSTANTIATED);
    if (!instance_set_up(m, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime)) return fmi3Error;
    m->s.mode = INITIALIZATION_MODE;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ENTER(INITIALIZATION_MODE);
    if (!instance_initialise(m)) return fmi3Error;
    m->s.mode = ((Instance *)instance)->event_mode_used ? EVENT_MODE : STEP_MODE;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    ENTER(STEP_MODE);
    if (!((Instance *)instance)->event_mode_used) return error(m, "The instance was made without eventModeUsed.");
    m->s.kept = 0;
    m->s.mode = EVENT_MODE;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    ENTER(EVENT_MODE);
    m->s.mode = STEP_MODE;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{
    ENTER(EVENT_MODE);
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged ||
        !valuesOfContinuousStatesChanged || !nextEventTimeDefined || !nextEventTime)
        return error(m, "fmi3UpdateDiscreteStates: an output argument is null.");
    int reinitialised = 0;
    if (!simulation_event(m, 1, &reinitialised)) return (fmi3Status)instance_failed(m);
    double next = simulation_next_time_event(m);
    *discreteStatesNeedUpdate = fmi3False;
    *terminateSimulation = m->s.terminate != 0;
    if (m->s.terminate) simulation_log_termination(m, LOG_WARNING);
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = reinitialised != 0;
    *nextEventTimeDefined = isfinite(next);
    *nextEventTime = isfinite(next) ? next : 0.0;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    ENTER(STEP_MODE);
    (void)noSetFMUStatePriorToCurrentPoint;
    const Instance *i = instance;
    State *s = &m->s;
    double to = currentCommunicationPoint + communicationStepSize;
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime)
        return error(m, "fmi3DoStep: an output argument is null.");
    if (!instance_accepts_step(m, __func__, currentCommunicationPoint, communicationStepSize)) return fmi3Error;
    /* An importer with Event Mode sees discrete variables change there and nowhere else. If it cannot be given an early
     * return, what happens inside the step is computed at its instant, and shows in Event Mode at the step's end. */
    s->keeping = i->event_mode_used && !i->early_return_allowed;
    Advance outcome = instance_run(m, to, i->event_mode_used && i->early_return_allowed);
    s->keeping = 0;
    bool at_tick = outcome == ADVANCE_REACHED && i->event_mode_used && simulation_time_event_is_due(m);
    *eventHandlingNeeded = outcome == ADVANCE_EVENT || at_tick || s->kept;
    *terminateSimulation = s->terminate != 0;
    if (s->terminate) simulation_log_termination(m, LOG_WARNING);
    *earlyReturn = i->early_return_allowed && outcome != ADVANCE_FAILED && s->t < to;
    *lastSuccessfulTime = s->t;
    return outcome == ADVANCE_FAILED ? (fmi3Status)instance_failed(m) : fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    ENTER(INITIALIZATION_MODE | EVENT_MODE | STEP_MODE);
    m->s.mode = TERMINATED;
    return instance_end(m) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ENTER(ANY_MODE);
    simulation_reset(m);
    m->s.mode = INSTANTIATED;
    return fmi3OK;
}
