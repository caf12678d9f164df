/* SPDX-License-Identifier: MIT-0
 *
 * driver LIBRARY TOKEN N_INPUTS (REFERENCE VALUE)... REFERENCE...: loads an FMI 3.0 Co-Simulation library, sets inputs, takes
 * 2000 steps of 1 ms, and prints after every hundredth the variables with the other references.
 */
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *symbol(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW); }
static void *symbol(void *library, const char *name) { return dlsym(library, name); }
#endif

#include "fmi3Functions.h"

#define LOOK_UP(name) name##TYPE *const name##_ = (name##TYPE *)symbol(library, #name)
#define MUST(status) \
    if ((status) > fmi3Warning) return fprintf(stderr, "line %d\n", __LINE__), 1

static void say(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    (void)environment, (void)category;
    fprintf(stderr, "%d %s\n", (int)status, message);
}

int main(int argc, char **argv) {
    void *const library = load(argv[1]);
    if (library == NULL) return fprintf(stderr, "cannot load %s\n", argv[1]), 1;
    LOOK_UP(fmi3InstantiateCoSimulation);
    LOOK_UP(fmi3EnterInitializationMode);
    LOOK_UP(fmi3ExitInitializationMode);
    LOOK_UP(fmi3SetFloat64);
    LOOK_UP(fmi3GetFloat64);
    LOOK_UP(fmi3DoStep);
    LOOK_UP(fmi3Terminate);
    LOOK_UP(fmi3FreeInstance);
    fmi3Instance c = fmi3InstantiateCoSimulation_("driven", argv[2], NULL, false, true, false, false, NULL, 0, NULL, say, NULL);
    if (c == NULL) return fprintf(stderr, "no instance\n"), 1;
    const int n_inputs = atoi(argv[3]);
    char **next = argv + 4;
    MUST(fmi3EnterInitializationMode_(c, true, 1e-6, 0.0, false, 0.0));
    for (int i = 0; i < n_inputs; i++, next += 2) {
        const fmi3ValueReference reference = (fmi3ValueReference)atoi(next[0]);
        const fmi3Float64 value = atof(next[1]);
        MUST(fmi3SetFloat64_(c, &reference, 1, &value, 1));
    }
    MUST(fmi3ExitInitializationMode_(c));
    for (int k = 0; k < 2000; k++) {
        fmi3Boolean event, terminate, early;
        fmi3Float64 reached;
        const double t = k / 1000.0; /* quotients, as the engine has them */
        MUST(fmi3DoStep_(c, t, (k + 1) / 1000.0 - t, true, &event, &terminate, &early, &reached));
        if ((k + 1) % 100 != 0) continue;
        for (char **output = next; output < argv + argc; output++) {
            const fmi3ValueReference reference = (fmi3ValueReference)atoi(*output);
            fmi3Float64 value;
            MUST(fmi3GetFloat64_(c, &reference, 1, &value, 1));
            printf("%.17g ", value);
        }
        printf("\n");
    }
    MUST(fmi3Terminate_(c));
    fmi3FreeInstance_(c);
    return 0;
}
