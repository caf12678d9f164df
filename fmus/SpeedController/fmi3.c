/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0 Co-Simulation around the controller.
 */
#include <stdlib.h>

#include "controller.h"
#include "fmi3Functions.h"

static void say(void *environment, const char *text) {
    const Controller *c = environment;
    ((fmi3LogMessageCallback)c->logger)(c->environment, fmi3Error, "logStatusError", text);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode_used, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t n_intermediate,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)early_return, (void)intermediate, (void)update;
    Controller *c = event_mode_used || n_intermediate > 0 || logger == NULL ? NULL : controller_new(token);
    if (c != NULL) {
        c->say = say;
        c->environment = environment;
        c->logger = (void (*)(void))logger;
    }
    return c;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
    (void)tolerance_defined, (void)tolerance, (void)start, (void)stop_defined, (void)stop;
    return c != NULL ? fmi3OK : fmi3Error;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    ((Controller *)c)->initialized = true;
    return fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance c) { return c != NULL ? fmi3OK : fmi3Error; }
fmi3Status fmi3Reset(fmi3Instance c) {
    ((Controller *)c)->initialized = false;
    ((Controller *)c)->values[DUTY] = ((Controller *)c)->values[ERROR_SUM] = 0.0;
    return fmi3OK;
}
fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    (void)on, (void)n, (void)categories;
    return c != NULL ? fmi3OK : fmi3Error;
}
const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t n, fmi3Float64 values[],
                          size_t n_values) {
    for (size_t i = 0; i < n; i++) {
        if (references[i] >= N_VALUES || n_values != n) return fmi3Error;
        values[i] = ((Controller *)c)->values[references[i]];
    }
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t n, const fmi3Float64 values[],
                          size_t n_values) {
    for (size_t i = 0; i < n; i++) {
        if (!controller_settable(c, references[i]) || n_values != n) return fmi3Error;
        ((Controller *)c)->values[references[i]] = values[i];
    }
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event_needed,
                      fmi3Boolean *terminate, fmi3Boolean *early_return, fmi3Float64 *reached) {
    (void)final;
    *event_needed = *terminate = *early_return = false;
    if (!controller_step(c, t, h)) return fmi3Error;
    *reached = t + h;
    return fmi3OK;
}
