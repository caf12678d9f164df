/* SPDX-License-Identifier: MIT-0
 *
 * FMI 2.0 Co-Simulation around the controller.
 */
#include <stdlib.h>

#include "controller.h"
#include "fmi2Functions.h"

static void say(void *environment, const char *text) {
    const Controller *c = environment;
    ((fmi2CallbackLogger)c->logger)(c->environment, "SpeedController", fmi2Error, "logStatusError", "%s", text);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)resources, (void)visible, (void)logging;
    Controller *c = type == fmi2CoSimulation && functions != NULL ? controller_new(guid) : NULL;
    if (c != NULL) {
        c->say = say;
        c->environment = functions->componentEnvironment;
        c->logger = (void (*)(void))functions->logger;
    }
    return c;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_defined, fmi2Real stop) {
    (void)c, (void)tolerance_defined, (void)tolerance, (void)start, (void)stop_defined, (void)stop;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c != NULL ? fmi2OK : fmi2Error; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ((Controller *)c)->initialized = true;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { return c != NULL ? fmi2OK : fmi2Error; }
fmi2Status fmi2Reset(fmi2Component c) {
    ((Controller *)c)->initialized = false;
    ((Controller *)c)->values[DUTY] = ((Controller *)c)->values[ERROR_SUM] = 0.0;
    return fmi2OK;
}
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)on, (void)n, (void)categories;
    return c != NULL ? fmi2OK : fmi2Error;
}
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t n, fmi2Real values[]) {
    for (size_t i = 0; i < n; i++) {
        if (references[i] >= N_VALUES) return fmi2Error;
        values[i] = ((Controller *)c)->values[references[i]];
    }
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t n, const fmi2Real values[]) {
    for (size_t i = 0; i < n; i++) {
        if (!controller_settable(c, references[i])) return fmi2Error;
        ((Controller *)c)->values[references[i]] = values[i];
    }
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
    (void)final;
    return controller_step(c, t, h) ? fmi2OK : fmi2Error;
}
