/* SPDX-License-Identifier: MIT-0
 *
 * FMI 2.0: life cycle, and the steps of Co-Simulation.
 *
 * A sample at t is executed by the step from t, at its beginning, with the inputs set before it; its results hold until
 * the next one. A sample at the end of a step belongs to the next step. Inputs set between two steps wait for the next:
 * FMI 2.0 forbids to read outputs after setting inputs, and if an importer does so all the same, it gets the values of
 * the last step.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "instance.h"

typedef struct {
    Simulation sim; /* first: see instance.h */
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char *name;
} Instance;

const char shell_token[] = MODEL_TOKEN;

/* The text is a printf format for the importer: one without conversions, so that nothing is lost on those who print it
 * as it stands. */
static void say(void *context, LogKind kind, const char *text)
{
    const Instance *i = context;
    char message[2 * 1024];
    size_t n = 0;
    if (!i->logger) return;
    for (; *text && n + 2 < sizeof message; text++) {
        if (*text == '%') message[n++] = '%';
        message[n++] = *text;
    }
    message[n] = '\0';
    i->logger(i->environment, i->name, (fmi2Status)log_status(kind), log_category(kind), message);
}

const char *instance_mode_name(int mode)
{
    switch (mode) {
    case INSTANTIATED: return "before fmi2SetupExperiment";
    case SET_UP: return "before Initialization Mode";
    case INITIALIZATION_MODE: return "in Initialization Mode";
    case EVENT_MODE: return "in Event Mode";
    case STEP_MODE: return "after the end of Initialization Mode";
    case CONTINUOUS_TIME_MODE: return "in Continuous-Time Mode";
    case TERMINATED: return "after fmi2Terminate";
    default: return "after an error; call fmi2Reset, fmi2SetFMUstate or fmi2FreeInstance";
    }
}

#define ENTER(call)                                       \
    Simulation *m = instance_entering(c, call, __func__); \
    if (!m) return fmi2Error

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    ENTER(CALL_ANY_TIME);
    return (fmi2Status)instance_log_events(m, __func__, loggingOn != fmi2False, nCategories, categories);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation, (void)visible;
    if (!functions) return NULL;
    char nameless[] = "";
    Instance blank = {.logger = functions->logger, .environment = functions->componentEnvironment, .name = nameless};
    blank.sim.log = say;
    blank.sim.log_context = &blank;
    if (!instance_may_begin(&blank.sim, instanceName, fmuGUID, __func__)) return NULL;
    if (fmuType != fmi2CoSimulation && fmuType != fmi2ModelExchange) {
        instance_error(&blank.sim, "%s: there is no type of interface with the number %d.", instanceName, (int)fmuType);
        return NULL;
    }
    size_t length = strlen(instanceName) + 1;
    Instance *i = instance_new(sizeof *i, say, loggingOn != fmi2False);
    char *name = malloc(length);
    if (!i || !name) {
        instance_error(&blank.sim, "%s: out of memory.", instanceName);
        free(i);
        free(name);
        return NULL;
    }
    instance_begin(&i->sim, fmuType == fmi2ModelExchange ? MODEL_EXCHANGE : CO_SIMULATION, INSTANTIATED);
    i->logger = functions->logger;
    i->environment = functions->componentEnvironment;
    i->name = memcpy(name, instanceName, length);
    return i;
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *i = c;
    if (!i) return;
    free(i->name);
    free(i);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    ENTER(CALL_SET_UP_EXPERIMENT);
    if (!instance_set_up(m, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime)) return fmi2Error;
    m->s.mode = SET_UP;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ENTER(CALL_ENTER_INITIALIZATION);
    m->s.mode = INITIALIZATION_MODE;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ENTER(CALL_EXIT_INITIALIZATION);
    if (!instance_initialise(m)) return fmi2Error;
    m->s.mode = m->s.type == MODEL_EXCHANGE ? EVENT_MODE : STEP_MODE;
    return fmi2OK;
}

static void take_over_inputs(Simulation *m)
{
    State *s = &m->s;
    if (!s->inputs_wait) return;
    int changed = 0;
    for (int k = 0; k < MODEL_NU; k++) {
        changed |= s->u[k] != s->u_waiting[k];
        s->u[k] = s->u_waiting[k];
    }
    s->inputs_wait = 0;
    if (changed) simulation_changed(m, 0);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    ENTER(CALL_STEP);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!instance_accepts_step(m, __func__, currentCommunicationPoint, communicationStepSize)) return fmi2Error;
    take_over_inputs(m);
    Advance outcome = instance_run(m, currentCommunicationPoint + communicationStepSize, false);
    if (outcome == ADVANCE_FAILED) return (fmi2Status)instance_failed(m);
    if (!m->s.terminate) return fmi2OK;
    simulation_log_termination(m, LOG_DISCARD);
    return fmi2Discard;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ENTER(CALL_TERMINATE);
    m->s.mode = TERMINATED;
    return instance_end(m) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    ENTER(CALL_NEW_STATE);
    instance_begin(m, m->s.type, INSTANTIATED);
    return fmi2OK;
}

/* The status of an instance. Steps are never pending, so there is nothing but these two things to ask for. */

static fmi2Status unknown_status(fmi2Component c, const char *function, fmi2StatusKind kind)
{
    Simulation *m = instance_entering(c, CALL_STEP_STATUS, function);
    if (!m) return fmi2Error;
    static const char *const names[] = {"fmi2DoStepStatus", "fmi2PendingStatus", "fmi2LastSuccessfulTime",
                                        "fmi2Terminated"};
    bool known = kind >= fmi2DoStepStatus && kind <= fmi2Terminated;
    instance_error(m, "%s does not tell %s.", function, known ? names[kind] : "a status that FMI does not know");
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    ENTER(CALL_STEP_STATUS);
    if (s != fmi2LastSuccessfulTime) return unknown_status(c, __func__, s);
    if (!value) return (fmi2Status)instance_error(m, "%s: value is null.", __func__);
    *value = m->s.t;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    ENTER(CALL_STEP_STATUS);
    if (s != fmi2Terminated) return unknown_status(c, __func__, s);
    if (!value) return (fmi2Status)instance_error(m, "%s: value is null.", __func__);
    *value = m->s.terminate != 0;
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    (void)value;
    return unknown_status(c, __func__, s);
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    (void)value;
    return unknown_status(c, __func__, s);
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    (void)value;
    return unknown_status(c, __func__, s);
}
