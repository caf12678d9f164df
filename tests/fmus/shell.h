/* SPDX-License-Identifier: MIT-0
 *
 * The FMI 2.0 and 3.0 interface of the test FMUs, around four functions of the model.
 *
 * A value reference is an index into v; whatever a variable's type, its value is kept as double.
 */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OK 0
#define DISCARD 2
#define ERROR 3
#define ROOM 64
#ifndef REFUSAL
#define REFUSAL(m) OK /* the status with which initialisation ends */
#endif
#ifndef READING
#define READING(m) OK /* the status with which values are given */
#endif
#ifndef AT
#define AT(moment) (void)0 /* done at the beginning of a function of the FMI */
#endif
#ifndef IS_WRONG
#define IS_WRONG(token) strcmp(token, "test")
#endif
#ifndef LENGTH
#define LENGTH(reference) 1 /* the number of values that a reference stands for */
#endif

typedef struct {
    double v[ROOM];
    char text[8][80]; /* the first value references may be texts */
#ifdef BINARY
    unsigned char binary[5][2][80]; /* or arrays of two Binary values */
    size_t size[5][2];
#endif
    double time;
    double next_event; /* infinite: none */
    bool terminate;
    bool early_return;
    bool update_needed; /* event() is to be called again */
    bool silent;        /* events are not announced, only reported when they have come */
    bool event_mode_used;
    void *environment;
    void *logger;
} Model;

/* Start values. */
static void start(Model *m);
/* Event at m->time, which may be no event of its own: status. */
static int event(Model *m);
/* From m->time over h [s]: status. */
static int step(Model *m, double h);
/* Outputs that depend on the present inputs. */
static void outputs(Model *m);
/* Pass a message to the importer. */
static void say(Model *m, const char *text);

/* Go back to what the instance was before initialisation. */
static void reset(Model *m);
#ifndef OWN_RESET
static void reset(Model *m) {
    const Model old = *m;
    memset(m, 0, sizeof *m);
    m->event_mode_used = old.event_mode_used;
    m->environment = old.environment;
    m->logger = old.logger;
    m->next_event = INFINITY;
    start(m);
}
#endif

static void set_text(Model *m, unsigned reference, const char *text) {
    snprintf(m->text[reference], sizeof m->text[reference], "%s", text);
    m->v[reference] += 1.0;
}

#if FMI == 2
#include "fmi2Functions.h"

static void say(Model *m, const char *text) {
    ((fmi2CallbackLogger)m->logger)(m->environment, "test", fmi2Error, "logStatusError", "%s at %g s", text, m->time);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    AT("Instantiate");
    if (IS_WRONG(guid)) return NULL;
    Model *m = calloc(1, sizeof *m);
    m->logger = (void *)functions->logger;
    m->environment = functions->componentEnvironment;
    m->next_event = INFINITY;
    start(m);
    return m;
}
void fmi2FreeInstance(fmi2Component c) { AT("FreeInstance"); free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tol, fmi2Real t0, fmi2Boolean sd, fmi2Real s) {
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { AT("EnterInitializationMode"); return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { AT("ExitInitializationMode"); return (fmi2Status)REFUSAL(c); }
fmi2Status fmi2Terminate(fmi2Component c) { AT("Terminate"); return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { reset(c); return fmi2OK; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    return fmi2OK;
}
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

#define ACCESS(Type, type)                                                                                          \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) {             \
        AT("Get" #Type);                                                                                            \
        outputs(c);                                                                                                 \
        for (size_t i = 0; i < n; i++) value[i] = (type)((Model *)c)->v[vr[i]];                                     \
        return (fmi2Status)READING((Model *)c);                                                                     \
    }                                                                                                               \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n, const type value[]) {       \
        for (size_t i = 0; i < n; i++) ((Model *)c)->v[vr[i]] = (double)value[i];                                   \
        return fmi2OK;                                                                                              \
    }
ACCESS(Real, fmi2Real)
ACCESS(Integer, fmi2Integer)
ACCESS(Boolean, fmi2Boolean)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    for (size_t i = 0; i < n; i++) value[i] = ((Model *)c)->text[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    for (size_t i = 0; i < n; i++) set_text(c, vr[i], value[i]);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
    Model *m = c;
    m->time = t;
    const int status = step(m, h);
    if (status == OK) m->time = t + h;
    return m->terminate ? fmi2Discard : (fmi2Status)status;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = ((Model *)c)->terminate;
    return fmi2OK;
}

#else
#include "fmi3Functions.h"

static void say(Model *m, const char *text) {
    char message[200];
    snprintf(message, sizeof message, "%s at %g s", text, m->time);
    ((fmi3LogMessageCallback)m->logger)(m->environment, fmi3Error, "logStatusError", message);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode_used, fmi3Boolean early,
                                         const fmi3ValueReference needed[], size_t n_needed,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    AT("Instantiate");
    if (IS_WRONG(token)) return NULL;
    Model *m = calloc(1, sizeof *m);
    m->event_mode_used = event_mode_used;
    m->environment = environment;
    m->logger = (void *)logger;
    m->next_event = INFINITY;
    start(m);
    return m;
}
void fmi3FreeInstance(fmi3Instance c) { AT("FreeInstance"); free(c); }
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    return fmi3OK;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean td, fmi3Float64 tol, fmi3Float64 t0, fmi3Boolean sd,
                                       fmi3Float64 s) { AT("EnterInitializationMode");
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { AT("ExitInitializationMode"); return (fmi3Status)REFUSAL(c); }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { AT("Terminate"); return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c) { reset(c); return fmi3OK; }

#define EACH(body)                                                                                                  \
    size_t k = 0;                                                                                                   \
    for (size_t i = 0; i < n; i++)                                                                                  \
        for (int j = 0; j < LENGTH(vr[i]); j++, k++) body;                                                          \
    return k == nv ? fmi3OK : fmi3Error;
#define ACCESS(Type, type)                                                                                          \
    fmi3Status fmi3Get##Type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type value[], size_t nv) {   \
        AT("Get" #Type);                                                                                            \
        outputs(c);                                                                                                 \
        if (READING((Model *)c) != OK) return (fmi3Status)READING((Model *)c);                                      \
        EACH(value[k] = (type)((Model *)c)->v[vr[i] + j])                                                           \
    }                                                                                                               \
    fmi3Status fmi3Set##Type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type value[],          \
                             size_t nv) {                                                                           \
        EACH(((Model *)c)->v[vr[i] + j] = (double)value[k])                                                         \
    }
ACCESS(Float64, fmi3Float64)
ACCESS(Float32, fmi3Float32)
ACCESS(Int8, fmi3Int8)
ACCESS(UInt8, fmi3UInt8)
ACCESS(Int16, fmi3Int16)
ACCESS(UInt16, fmi3UInt16)
ACCESS(Int32, fmi3Int32)
ACCESS(UInt32, fmi3UInt32)
ACCESS(Int64, fmi3Int64)
ACCESS(UInt64, fmi3UInt64)
ACCESS(Boolean, fmi3Boolean)

fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String value[], size_t nv) {
    size_t k = 0;
    for (size_t i = 0; i < n; i++)
        for (int j = 0; j < LENGTH(vr[i]); j++) value[k++] = ((Model *)c)->text[vr[i] + j];
    return k == nv ? fmi3OK : fmi3Error;
}
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String value[], size_t nv) {
    size_t k = 0;
    for (size_t i = 0; i < n; i++)
        for (int j = 0; j < LENGTH(vr[i]); j++) set_text(c, vr[i] + j, value[k++]);
    return k == nv ? fmi3OK : fmi3Error;
}

#ifdef BINARY
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary values[],
                         size_t nv) {
    for (size_t k = 0; k < 2 * n; k++) {
        sizes[k] = ((Model *)c)->size[vr[k / 2]][k % 2];
        values[k] = sizes[k] ? ((Model *)c)->binary[vr[k / 2]][k % 2] : NULL;
    }
    return 2 * n == nv ? fmi3OK : fmi3Error;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                         const fmi3Binary values[], size_t nv) {
    for (size_t k = 0; k < 2 * n; k++) {
        Model *m = c;
        if (sizes[k] > sizeof m->binary[0][0]) return fmi3Error;
        memcpy(m->binary[vr[k / 2]][k % 2], values[k], sizes[k]);
        m->size[vr[k / 2]][k % 2] = sizes[k];
        m->v[vr[k / 2]] += k % 2;
    }
    return 2 * n == nv ? fmi3OK : fmi3Error;
}
#endif

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needed, fmi3Boolean *terminate, fmi3Boolean *nominals,
                                    fmi3Boolean *states, fmi3Boolean *defined, fmi3Float64 *next) {
    Model *m = c;
    const int status = event(m);
    *needed = m->update_needed;
    *nominals = *states = false;
    *terminate = m->terminate;
    *defined = isfinite(m->next_event) && !m->silent;
    *next = *defined ? m->next_event : 0.0;
    return (fmi3Status)status;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event_needed,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    Model *m = c;
    m->time = t;
    const int status = step(m, h);
    if (status == OK) m->time = *reached = t + h;
    *event_needed = m->event_mode_used && m->time >= m->next_event - 1e-9;
    *terminate = m->terminate;
    *early = m->early_return;
    return (fmi3Status)status;
}
#endif

#ifdef SAVES
#include "saves.h"
#endif
