/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0 for Co-Simulation: life cycle, modes and steps.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"

static void say(const Instance *i, fmi3Status status, const char *category, const char *text)
{
    if (i->log_message) i->log_message(i->environment, status, category, text);
}

static void log_simulation(void *context, LogKind kind, const char *text)
{
    if (kind == LOG_WARNING)
        say(context, fmi3Warning, "logStatusWarning", text);
    else
        say(context, fmi3OK, "logEvents", text);
}

fmi3Status instance_error(Instance *i, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    say(i, fmi3Error, "logStatusError", text);
    return fmi3Error;
}

/* The simulation could not go on. */
static fmi3Status failed(Instance *i)
{
    i->sim.s.mode = FAILED;
    return instance_error(i, "%s", i->sim.message);
}

static const char *mode_name(int mode)
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

Instance *instance_entering(fmi3Instance instance, int allowed_modes, const char *function)
{
    Instance *i = instance;
    if (!i) return NULL;
    if (i->sim.s.mode & allowed_modes) return i;
    instance_error(i, "%s is not allowed %s.", function, mode_name(i->sim.s.mode));
    return NULL;
}

#define ENTER(allowed_modes)                                            \
    Instance *i = instance_entering(instance, allowed_modes, __func__); \
    if (!i) return fmi3Error

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    ENTER(ANY_MODE);
    if (nCategories > 0 && !categories) return instance_error(i, "fmi3SetDebugLogging: categories is null.");
    bool events = nCategories == 0;
    for (size_t k = 0; k < nCategories; k++)
        if (categories[k] && strcmp(categories[k], "logEvents") == 0) events = true;
    i->sim.log_events = loggingOn && events;
    return fmi3OK;
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
    if (!instanceName || instanceName[0] == '\0') {
        instance_error(&blank, "fmi3InstantiateCoSimulation: the instance needs a name.");
        return NULL;
    }
    if (!instantiationToken || strcmp(instantiationToken, MODEL_TOKEN) != 0) {
        instance_error(&blank, "%s: the instantiation token is not that of this FMU (%s); the modelDescription.xml "
                       "belongs to another build.", instanceName, MODEL_TOKEN);
        return NULL;
    }
    Instance *i = calloc(1, sizeof *i);
    if (!i) {
        instance_error(&blank, "%s: out of memory.", instanceName);
        return NULL;
    }
    i->environment = instanceEnvironment;
    i->log_message = logMessage;
    i->event_mode_used = eventModeUsed;
    i->early_return_allowed = earlyReturnAllowed;
    i->sim.log = log_simulation;
    i->sim.log_context = i;
    i->sim.log_events = loggingOn;
    simulation_reset(&i->sim);
    i->sim.s.mode = INSTANTIATED;
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
    if (!isfinite(startTime)) return instance_error(i, "The start time %g is not a finite number.", startTime);
    if (toleranceDefined && !(tolerance > 0.0 && tolerance < 1.0))
        return instance_error(i, "The tolerance %g is not between 0 and 1.", tolerance);
    if (stopTimeDefined && !(stopTime >= startTime))
        return instance_error(i, "The stop time %g s is before the start time %g s.", stopTime, startTime);
    State *s = &i->sim.s;
    s->t = startTime;
    s->stop = stopTimeDefined ? stopTime : INFINITY;
    /* Below this, rounding errors would be taken for errors of the method. */
    if (toleranceDefined) s->tolerance = fmax(tolerance, 1e-12);
    s->mode = INITIALIZATION_MODE;
    simulation_changed(&i->sim, false);
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ENTER(INITIALIZATION_MODE);
    if (!i->sim.s.initialised && !simulation_initialise(&i->sim)) return instance_error(i, "%s", i->sim.message);
    i->sim.s.mode = i->event_mode_used ? EVENT_MODE : STEP_MODE;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    ENTER(STEP_MODE);
    if (!i->event_mode_used) return instance_error(i, "The instance was made without eventModeUsed.");
    i->sim.s.mode = EVENT_MODE;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    ENTER(EVENT_MODE);
    i->sim.s.mode = STEP_MODE;
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
        return instance_error(i, "fmi3UpdateDiscreteStates: an output argument is null.");
    int reinitialised = 0;
    if (!simulation_event(&i->sim, 1, &reinitialised)) return failed(i);
    double next = simulation_next_tick(&i->sim);
    *discreteStatesNeedUpdate = fmi3False;
    *terminateSimulation = i->sim.s.terminate != 0;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = reinitialised != 0;
    *nextEventTimeDefined = isfinite(next);
    *nextEventTime = isfinite(next) ? next : 0.0;
    return fmi3OK;
}

static const double MOST_AHEAD = 100.0;

/* Advance to `to`, or to where the importer has to handle an event. */
static Advance run(Instance *i, double to, bool *event_needed)
{
    Simulation *m = &i->sim;
    bool stop_at_events = i->event_mode_used && i->early_return_allowed;
    *event_needed = false;
    while (m->s.t < to) {
        if (m->s.terminate) return ADVANCE_TERMINATED;
        /* The ticks at the start of a step belong to it, those at its end to the next. */
        if (simulation_tick_is_due(m) && !simulation_event(m, 1, NULL)) return ADVANCE_FAILED;
        double tick = simulation_next_tick(m);
        bool tick_inside = tick < to - SAME_INSTANT;
        /* Far beyond the step asked for, an event could no longer be located as accurately as within it. */
        double limit = fmin(fmin(tick, m->s.stop), to + MOST_AHEAD * (to - m->s.t));
        if (limit < to + SAME_INSTANT) limit = to;
        Advance outcome = simulation_advance(m, tick_inside ? tick : to, tick_inside ? tick : limit, stop_at_events);
        if (outcome == ADVANCE_EVENT || (outcome == ADVANCE_REACHED && tick_inside && stop_at_events)) {
            *event_needed = true;
            return outcome;
        }
        if (outcome != ADVANCE_REACHED) return outcome;
    }
    *event_needed = i->event_mode_used && simulation_tick_is_due(m);
    return ADVANCE_REACHED;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    ENTER(STEP_MODE);
    (void)noSetFMUStatePriorToCurrentPoint;
    State *s = &i->sim.s;
    double to = currentCommunicationPoint + communicationStepSize;
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime)
        return instance_error(i, "fmi3DoStep: an output argument is null.");
    /* The importer's sums of steps may differ from ours by rounding. */
    double same = fmax(SAME_INSTANT, 1e-13 * fabs(to));
    if (!(fabs(currentCommunicationPoint - s->t) <= same))
        return instance_error(i, "fmi3DoStep: the communication point %.17g s is not the instance's time %.17g s.",
                              currentCommunicationPoint, s->t);
    if (!(communicationStepSize > 0.0) || !isfinite(to))
        return instance_error(i, "fmi3DoStep: the step size %g s is not a positive number.", communicationStepSize);
    if (to > s->stop + same)
        return instance_error(i, "fmi3DoStep: the step to %.17g s goes beyond the stop time %.17g s.", to, s->stop);
    bool event_needed;
    Advance outcome = run(i, to, &event_needed);
    *eventHandlingNeeded = event_needed;
    *terminateSimulation = s->terminate != 0;
    *earlyReturn = outcome != ADVANCE_FAILED && s->t < to;
    *lastSuccessfulTime = s->t;
    return outcome == ADVANCE_FAILED ? failed(i) : fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    ENTER(INITIALIZATION_MODE | EVENT_MODE | STEP_MODE);
    i->sim.s.mode = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ENTER(ANY_MODE);
    simulation_reset(&i->sim);
    i->sim.s.mode = INSTANTIATED;
    return fmi3OK;
}
