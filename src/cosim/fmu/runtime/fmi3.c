/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0: life cycle, events, and the steps of Co-Simulation.
 */
#include <math.h>
#include <stdlib.h>

#include "fmi3Functions.h"
#include "exchange.h"

typedef struct {
    Simulation sim; /* first: see instance.h */
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log_message;
    fmi3IntermediateUpdateCallback intermediate_update;
    bool event_mode_used, early_return_allowed;
} Instance;

const char shell_token[] = MODEL_TOKEN;

static void say(void *context, LogKind kind, const char *text)
{
    const Instance *i = context;
    if (i->log_message) i->log_message(i->environment, (fmi3Status)log_status(kind), log_category(kind), text);
}

const char *instance_mode_name(int mode)
{
    switch (mode) {
    case SET_UP: return "before Initialization Mode";
    case INITIALIZATION_MODE: return "in Initialization Mode";
    case EVENT_MODE: return "in Event Mode";
    case INTERMEDIATE_UPDATE: return "in the callback of an intermediate update";
    case STEP_MODE: return "in Step Mode";
    case CONTINUOUS_TIME_MODE: return "in Continuous-Time Mode";
    case TERMINATED: return "after fmi3Terminate";
    default: return "after an error; call fmi3Reset, fmi3SetFMUState or fmi3FreeInstance";
    }
}

#define ENTER(call)                                              \
    Simulation *m = instance_entering(instance, call, __func__); \
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
    ENTER(CALL_ANY_TIME);
    return (fmi3Status)instance_log_events(m, __func__, loggingOn, nCategories, categories);
}

static Instance *instantiate(const char *function, fmi3String name, fmi3String token, InterfaceType type,
                             fmi3Boolean logging, fmi3InstanceEnvironment environment,
                             fmi3LogMessageCallback log_message)
{
    Instance blank = {.environment = environment, .log_message = log_message};
    blank.sim.log = say;
    blank.sim.log_context = &blank;
    if (!instance_may_begin(&blank.sim, name, token, function)) return NULL;
    Instance *i = instance_new(sizeof *i, say, logging);
    if (!i) {
        instance_error(&blank.sim, "%s: out of memory.", name);
        return NULL;
    }
    instance_begin(&i->sim, type, SET_UP);
    i->environment = environment;
    i->log_message = log_message;
    return i;
}

/* The end of a solver's step: it is not taken back, and nothing is set. */
static void update_intermediately(void *context)
{
    Instance *i = context;
    State *s = &i->sim.s;
    int mode = s->mode;
    fmi3Boolean wanted = fmi3False;
    fmi3Float64 at = s->t;
    s->mode = INTERMEDIATE_UPDATE;
    i->intermediate_update(i->environment, s->t, fmi3False, fmi3True, fmi3True, i->early_return_allowed, &wanted, &at);
    s->mode = mode;
    if (wanted && i->early_return_allowed) i->sim.return_at = at > s->t ? at : s->t;
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
    /* All variables can be read in the callback, so it makes no difference which are wanted. */
    (void)resourcePath, (void)visible, (void)requiredIntermediateVariables, (void)nRequiredIntermediateVariables;
    Instance *i = instantiate(__func__, instanceName, instantiationToken, CO_SIMULATION, loggingOn, instanceEnvironment,
                              logMessage);
    if (!i) return NULL;
    i->event_mode_used = eventModeUsed;
    i->early_return_allowed = earlyReturnAllowed;
    i->intermediate_update = intermediateUpdate;
    if (intermediateUpdate) i->sim.intermediate = update_intermediately;
    return i;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    (void)resourcePath, (void)visible;
    return instantiate(__func__, instanceName, instantiationToken, MODEL_EXCHANGE, loggingOn, instanceEnvironment,
                       logMessage);
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    ENTER(CALL_ENTER_INITIALIZATION);
    if (!instance_set_up(m, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime)) return fmi3Error;
    m->s.mode = INITIALIZATION_MODE;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ENTER(CALL_EXIT_INITIALIZATION);
    if (!instance_initialise(m)) return fmi3Error;
    bool events = m->s.type == MODEL_EXCHANGE || ((Instance *)instance)->event_mode_used;
    m->s.mode = events ? EVENT_MODE : STEP_MODE;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    ENTER(CALL_ENTER_EVENT_MODE);
    if (m->s.type == MODEL_EXCHANGE) return (fmi3Status)exchange_enter_event_mode(m, __func__);
    if (!((Instance *)instance)->event_mode_used) return error(m, "The instance was made without eventModeUsed.");
    m->s.kept = 0;
    m->s.mode = EVENT_MODE;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    ENTER(CALL_ENTER_STEP_MODE);
    m->s.mode = STEP_MODE;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{
    ENTER(CALL_UPDATE_DISCRETE_STATES);
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged ||
        !valuesOfContinuousStatesChanged || !nextEventTimeDefined || !nextEventTime)
        return error(m, "fmi3UpdateDiscreteStates: an output argument is null.");
    Update update;
    int status = instance_update(m, __func__, &update);
    if (status != STATUS_OK) return (fmi3Status)status;
    *discreteStatesNeedUpdate = fmi3False;
    *terminateSimulation = update.terminate;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = update.states_changed;
    *nextEventTimeDefined = update.has_next;
    *nextEventTime = update.next;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    ENTER(CALL_STEP);
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
    m->return_at = INFINITY;
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
    ENTER(CALL_TERMINATE);
    m->s.mode = TERMINATED;
    return instance_end(m) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ENTER(CALL_NEW_STATE);
    instance_begin(m, m->s.type, SET_UP);
    return fmi3OK;
}
