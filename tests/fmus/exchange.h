/* SPDX-License-Identifier: MIT-0
 *
 * The FMI 2.0 and 3.0 interface for Model Exchange of the test FMUs, around five functions of the model. It refuses what
 * the standard does not allow: integrating outside Continuous-Time Mode, setting inputs outside Event Mode.
 *
 * A value reference is an index into v. From 1 on there are NX states, then their NX derivatives.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define ROOM 32
typedef enum { INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS_TIME } Mode;
typedef struct {
    double v[ROOM];
    double time, next_event; /* infinite: none */
    bool update_needed, states_changed, terminate, step_event, discard;
    void *environment, *logger; /* as the others have them */
    Mode mode;
} Model;

static void start(Model *m);
/* Derivatives of the states; false: they cannot be computed, and if `discard`, not there. */
static bool rates(Model *m);
static void indicators(Model *m, double z[]);
static void update(Model *m);
static void completed(Model *m);
static void outputs(Model *m);

#define ERROR 3
#define IN(wanted) if (((Model *)c)->mode != (wanted)) return ERROR
#if FMI == 2
#include "fmi2Functions.h"
#define STATUS fmi2Status
#define INSTANCE fmi2Component
#define NAME(name) fmi2##name
#define REAL fmi2Real
#define FLAG fmi2Boolean
#else
#include "fmi3Functions.h"
#define STATUS fmi3Status
#define INSTANCE fmi3Instance
#define NAME(name) fmi3##name
#define REAL fmi3Float64
#define FLAG fmi3Boolean
#endif

static STATUS enter(Model *m, Mode from, Mode to) {
    if (m->mode != from) return ERROR;
    m->mode = to;
    return 0;
}
static Model *make(void) {
    Model *m = calloc(1, sizeof *m);
    m->next_event = INFINITY;
    start(m);
    return m;
}
STATUS NAME(SetTime)(INSTANCE c, REAL t) { IN(CONTINUOUS_TIME); ((Model *)c)->time = t; return 0; }
STATUS NAME(SetContinuousStates)(INSTANCE c, const REAL x[], size_t n) {
    IN(CONTINUOUS_TIME);
    memcpy(((Model *)c)->v + 1, x, n * sizeof *x);
    return n == NX ? 0 : ERROR;
}
STATUS NAME(GetContinuousStates)(INSTANCE c, REAL x[], size_t n) { memcpy(x, ((Model *)c)->v + 1, n * sizeof *x); return 0; }
STATUS NAME(GetNominalsOfContinuousStates)(INSTANCE c, REAL x[], size_t n) {
    for (size_t i = 0; i < n; i++) x[i] = 1.0;
    return 0;
}
STATUS
#if FMI == 2
fmi2GetDerivatives
#else
fmi3GetContinuousStateDerivatives
#endif
(INSTANCE c, REAL dx[], size_t n) {
    Model *m = c;
    IN(CONTINUOUS_TIME);
    m->discard = false;
    if (!rates(m)) return m->discard ? 2 : ERROR;
    memcpy(dx, m->v + 1 + NX, n * sizeof *dx);
    return n == NX ? 0 : ERROR;
}
STATUS NAME(GetEventIndicators)(INSTANCE c, REAL z[], size_t n) {
    indicators(c, z);
    return n == NZ ? 0 : ERROR;
}
STATUS NAME(EnterEventMode)(INSTANCE c) { return enter(c, CONTINUOUS_TIME, EVENT); }
STATUS NAME(EnterContinuousTimeMode)(INSTANCE c) { return enter(c, EVENT, CONTINUOUS_TIME); }
STATUS NAME(CompletedIntegratorStep)(INSTANCE c, FLAG final, FLAG *event, FLAG *terminate) {
    IN(CONTINUOUS_TIME);
    completed(c);
    *event = ((Model *)c)->step_event;
    *terminate = ((Model *)c)->terminate;
    return 0;
}
void NAME(FreeInstance)(INSTANCE c) { free(c); }
STATUS NAME(ExitInitializationMode)(INSTANCE c) { return enter(c, INITIALIZATION, EVENT); }
STATUS NAME(Terminate)(INSTANCE c) { return 0; }
STATUS NAME(Reset)(INSTANCE c) {
    *(Model *)c = (Model){.next_event = INFINITY};
    start(c);
    return 0;
}

static STATUS get(Model *m, unsigned vr, double *value) {
    rates(m);
    outputs(m);
    *value = m->v[vr];
    return 0;
}
static STATUS set(Model *m, unsigned vr, double value) {
    if (m->mode == CONTINUOUS_TIME) return ERROR;
    m->v[vr] = value;
    return 0;
}
#if FMI == 2
#define ACCESS(Type, type)                                                                                      \
    STATUS fmi2Get##Type(INSTANCE c, const fmi2ValueReference vr[], size_t n, type value[]) {                   \
        double found;                                                                                           \
        for (size_t i = 0; i < n; i++) { get(c, vr[i], &found); value[i] = (type)found; }                       \
        return fmi2OK;                                                                                          \
    }                                                                                                           \
    STATUS fmi2Set##Type(INSTANCE c, const fmi2ValueReference vr[], size_t n, const type value[]) {             \
        for (size_t i = 0; i < n; i++) if (set(c, vr[i], (double)value[i])) return fmi2Error;                   \
        return fmi2OK;                                                                                          \
    }
ACCESS(Real, fmi2Real)
ACCESS(Integer, fmi2Integer)
ACCESS(Boolean, fmi2Boolean)
STATUS fmi2GetString(INSTANCE c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) { return ERROR; }
STATUS fmi2SetString(INSTANCE c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) { return ERROR; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    return type == fmi2ModelExchange && strcmp(guid, "test") == 0 ? make() : NULL;
}
STATUS fmi2SetupExperiment(INSTANCE c, FLAG td, REAL tol, REAL t0, FLAG sd, REAL s) { return 0; }
STATUS fmi2EnterInitializationMode(INSTANCE c) { return enter(c, INSTANTIATED, INITIALIZATION); }
STATUS fmi2SetDebugLogging(INSTANCE c, FLAG on, size_t n, const fmi2String categories[]) { return 0; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
STATUS fmi2NewDiscreteStates(INSTANCE c, fmi2EventInfo *info) {
    Model *m = c;
    IN(EVENT);
    update(m);
    info->newDiscreteStatesNeeded = m->update_needed;
    info->terminateSimulation = m->terminate;
    info->nominalsOfContinuousStatesChanged = 0;
    info->valuesOfContinuousStatesChanged = m->states_changed;
    info->nextEventTimeDefined = isfinite(m->next_event);
    info->nextEventTime = m->next_event;
    return 0;
}
#else
#define ACCESS(Type, type)                                                                                      \
    STATUS fmi3Get##Type(INSTANCE c, const fmi3ValueReference vr[], size_t n, type value[], size_t nv) {        \
        double found;                                                                                           \
        for (size_t i = 0; i < n; i++) { get(c, vr[i], &found); value[i] = (type)found; }                       \
        return 0;                                                                                               \
    }                                                                                                           \
    STATUS fmi3Set##Type(INSTANCE c, const fmi3ValueReference vr[], size_t n, const type value[], size_t nv) {  \
        for (size_t i = 0; i < n; i++) if (set(c, vr[i], (double)value[i])) return ERROR;                       \
        return 0;                                                                                               \
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
STATUS fmi3GetString(INSTANCE c, const fmi3ValueReference vr[], size_t n, fmi3String value[], size_t nv) { return ERROR; }
STATUS fmi3SetString(INSTANCE c, const fmi3ValueReference vr[], size_t n, const fmi3String value[], size_t nv) {
    return ERROR;
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    return strcmp(token, "test") == 0 ? make() : NULL;
}
STATUS fmi3EnterInitializationMode(INSTANCE c, FLAG td, REAL tol, REAL t0, FLAG sd, REAL s) {
    return enter(c, INSTANTIATED, INITIALIZATION);
}
STATUS fmi3SetDebugLogging(INSTANCE c, FLAG on, size_t n, const fmi3String categories[]) { return 0; }
const char *fmi3GetVersion(void) { return "3.0"; }
STATUS fmi3GetNumberOfContinuousStates(INSTANCE c, size_t *n) { *n = NX; return 0; }
STATUS fmi3GetNumberOfEventIndicators(INSTANCE c, size_t *n) { *n = NZ; return 0; }
STATUS fmi3UpdateDiscreteStates(INSTANCE c, FLAG *needed, FLAG *terminate, FLAG *nominals, FLAG *states, FLAG *defined,
                                REAL *next) {
    Model *m = c;
    IN(EVENT);
    update(m);
    *needed = m->update_needed;
    *terminate = m->terminate;
    *nominals = false;
    *states = m->states_changed;
    *defined = isfinite(m->next_event);
    *next = m->next_event;
    return 0;
}
#endif

#ifdef DIRECTIONAL
/* What derivative `rate` gains along variable `known`. */
static double gain(const Model *m, unsigned rate, unsigned known);
#if FMI == 2
STATUS fmi2GetDirectionalDerivative(INSTANCE c, const fmi2ValueReference rate[], size_t n, const fmi2ValueReference known[],
                                    size_t n_known, const fmi2Real seed[], fmi2Real gained[]) {
#else
STATUS fmi3GetDirectionalDerivative(INSTANCE c, const fmi3ValueReference rate[], size_t n, const fmi3ValueReference known[],
                                    size_t n_known, const fmi3Float64 seed[], size_t n_seed, fmi3Float64 gained[],
                                    size_t n_gained) {
#endif
    for (size_t i = 0; i < n; i++) {
        gained[i] = 0.0;
        for (size_t k = 0; k < n_known; k++) gained[i] += gain(c, rate[i], known[k]) * seed[k];
    }
    return 0;
}
#endif

#ifdef SAVES
#undef NAME
#undef STATUS
#undef INSTANCE
#define OK 0
#define AT(function)
static void say(Model *m, const char *text) { (void)m, (void)text; }
#include "saves.h"
#endif
