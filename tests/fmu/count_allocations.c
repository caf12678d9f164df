/* Runs an FMI 3.0 Co-Simulation FMU and prints how often its steps have asked for memory.
 *
 * usage: count_allocations LIBRARY TOKEN REFERENCE STEP COUNT; REFERENCE is a Float64 input that changes, or -1.
 * The functions here take the place of those of the C library (glibc) in the whole process. */
#include <dlfcn.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi3FunctionTypes.h"

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t n, size_t size);
extern void *__libc_realloc(void *memory, size_t size);

static long allocations;

void *malloc(size_t size) { allocations++; return __libc_malloc(size); }
void *calloc(size_t n, size_t size) { allocations++; return __libc_calloc(n, size); }
void *realloc(void *memory, size_t size) { allocations++; return __libc_realloc(memory, size); }

#define FIND(name) name##TYPE *name = (name##TYPE *)dlsym(library, #name)

int main(int argc, char **argv)
{
    if (argc != 6) return 2;
    void *library = dlopen(argv[1], RTLD_NOW);
    if (!library) return 3;
    FIND(fmi3InstantiateCoSimulation);
    FIND(fmi3EnterInitializationMode);
    FIND(fmi3ExitInitializationMode);
    FIND(fmi3SetFloat64);
    FIND(fmi3DoStep);
    long before = allocations;
    fmi3Instance fmu = fmi3InstantiateCoSimulation("i", argv[2], NULL, fmi3False, fmi3False, fmi3False, fmi3False,
                                                   NULL, 0, NULL, NULL, NULL);
    if (!fmu || allocations == before) return 4; /* nothing is counted */
    if (fmi3EnterInitializationMode(fmu, fmi3False, 0.0, 0.0, fmi3False, 0.0) > fmi3Warning) return 5;
    if (fmi3ExitInitializationMode(fmu) > fmi3Warning) return 6;
    fmi3ValueReference reference = (fmi3ValueReference)atol(argv[3]);
    double h = atof(argv[4]);
    long count = atol(argv[5]);
    before = allocations;
    for (long k = 0; k < count; k++) {
        fmi3Boolean event, terminate, early;
        double t, value = k / 500 % 2 ? 0.2 : 0.9;
        if (argv[3][0] != '-' && fmi3SetFloat64(fmu, &reference, 1, &value, 1) > fmi3Warning) return 7;
        if (fmi3DoStep(fmu, k * h, h, fmi3True, &event, &terminate, &early, &t) > fmi3Warning) return 8;
    }
    printf("%ld\n", allocations - before);
    return 0;
}
