/* SPDX-License-Identifier: MIT-0
 *
 * exchange_driver LIBRARY TOKEN N_INPUTS (REFERENCE VALUE)... REFERENCE...: as driver.c does, for Model Exchange in FMI 3.0,
 * by the solver of the engine's native library.
 */
#include "engine.c"

#include <dlfcn.h>
#include <stdio.h>

#include "fmi3Functions.h"

#define MUST(status) \
    if ((status) > fmi3Warning) return fprintf(stderr, "line %d\n", __LINE__), 1
#define LOOK_UP(name) name##TYPE *const name##_ = (name##TYPE *)dlsym(library, #name)

#define ACCESSED(Type) "fmi3Get" #Type, "fmi3Set" #Type,
static const char *const NAMES[FMU_FUNCTIONS] = {
    "fmi3SetTime", "fmi3SetContinuousStates", "fmi3GetContinuousStates", "fmi3GetNominalsOfContinuousStates",
    "fmi3GetContinuousStateDerivatives", "fmi3GetEventIndicators", "fmi3GetDirectionalDerivative", "fmi3EnterEventMode",
    "fmi3EnterContinuousTimeMode", "fmi3UpdateDiscreteStates", "fmi3CompletedIntegratorStep", "fmi3GetFMUState",
    "fmi3SetFMUState", "fmi3FreeFMUState", "fmi3SerializedFMUStateSize", "fmi3SerializeFMUState",
    "fmi3DeserializeFMUState", VARIABLE_TYPES(ACCESSED)};

static void say(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    (void)environment, (void)category;
    fprintf(stderr, "%d %s\n", (int)status, message);
}

int main(int argc, char **argv) {
    void *const library = dlopen(argv[1], RTLD_NOW);
    if (library == NULL) return fprintf(stderr, "cannot load %s\n", argv[1]), 1;
    LOOK_UP(fmi3InstantiateModelExchange);
    LOOK_UP(fmi3EnterInitializationMode);
    LOOK_UP(fmi3ExitInitializationMode);
    LOOK_UP(fmi3GetNumberOfContinuousStates);
    LOOK_UP(fmi3GetNumberOfEventIndicators);
    LOOK_UP(fmi3SetFloat64);
    fmi3Instance c = fmi3InstantiateModelExchange_("driven", argv[2], NULL, false, true, NULL, say);
    if (c == NULL) return fprintf(stderr, "no instance\n"), 1;
    const int n_inputs = atoi(argv[3]);
    char **next = argv + 4;
    MUST(fmi3EnterInitializationMode_(c, true, 1e-6, 0.0, true, 3.0));
    for (int i = 0; i < n_inputs; i++, next += 2) {
        const fmi3ValueReference reference = (fmi3ValueReference)atoi(next[0]);
        const fmi3Float64 value = atof(next[1]);
        MUST(fmi3SetFloat64_(c, &reference, 1, &value, 1));
    }
    MUST(fmi3ExitInitializationMode_(c));
    size_t n_states, n_indicators;
    MUST(fmi3GetNumberOfContinuousStates_(c, &n_states));
    MUST(fmi3GetNumberOfEventIndicators_(c, &n_indicators));
    static Position at;
    Known known = {.instance = c, .at = &at, .fmi = 3, .completes = true};
    known.n_states = known.n_colours = (int64_t)n_states; /* no directional derivatives, no claims of dependencies */
    known.n_indicators = (int64_t)n_indicators;
    for (int i = 0; i < FMU_FUNCTIONS; i++) *(void **)&known.functions[i] = dlsym(library, NAMES[i]);
    void *const exchange = cosim_exchange_new(&known);
    if (exchange == NULL) return fprintf(stderr, "no memory\n"), 1;
    MUST(cosim_exchange_begin(exchange, 1e-6, 3.0));
    for (int k = 0; k < 2000; k++) {
        bool event, terminate, early;
        double reached;
        const double t = k / 1000.0;
        MUST(cosim_exchange_DoStep(exchange, t, (k + 1) / 1000.0 - t, true, &event, &terminate, &early, &reached));
        if ((k + 1) % 100 != 0) continue;
        for (char **output = next; output < argv + argc; output++) {
            const ValueReference reference = (ValueReference)atoi(*output);
            double value;
            MUST(cosim_exchange3_GetFloat64(exchange, &reference, 1, &value, 1));
            printf("%.17g ", value);
        }
        printf("\n");
    }
    cosim_exchange_delete(exchange);
    return 0;
}
