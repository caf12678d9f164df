/* SPDX-License-Identifier: MIT-0
 *
 * An FMI 1.0 Co-Simulation FMU: der(x) = gain u, exactly, u held over the step, x(0) = x0. `begun` is its input as it was
 * when it was initialised; it refuses to give values before that, and steps after t_wrong.
 */
#include <stdio.h>
#include <stdlib.h>

#include "fmi1Functions.h"

enum { U = 1, X0, GAIN, X, POSITIVE, STEPS, BEGUN, T_WRONG, NAME };

typedef struct {
    double v[16], time;
    char name[40];
    int initialized;
    fmi1CallbackLogger logger;
} Model;

#define NAMED(name) first_fmi##name
const char *NAMED(GetTypesPlatform)(void) { return "standard32"; }
const char *NAMED(GetVersion)(void) { return "1.0"; }
fmi1Component NAMED(InstantiateSlave)(fmi1String name, fmi1String guid, fmi1String location, fmi1String mime, double timeout,
                                      fmi1Boolean visible, fmi1Boolean interactive, fmi1CallbackFunctions functions,
                                      fmi1Boolean logging) {
    Model *m = functions.allocateMemory(1, sizeof *m);
    m->v[GAIN] = 1.0;
    m->logger = functions.logger;
    return m;
}
fmi1Status NAMED(InitializeSlave)(fmi1Component c, double t, fmi1Boolean stop_defined, double stop) {
    Model *m = c;
    m->v[X] = m->v[X0];
    m->v[BEGUN] = m->v[U];
    m->initialized = 1;
    return fmi1OK;
}
fmi1Status NAMED(TerminateSlave)(fmi1Component c) { return fmi1OK; }
fmi1Status NAMED(ResetSlave)(fmi1Component c) { return fmi1OK; }
void NAMED(FreeSlaveInstance)(fmi1Component c) { free(c); }
fmi1Status NAMED(SetDebugLogging)(fmi1Component c, fmi1Boolean on) { return fmi1OK; }

#define ACCESS(Type, type)                                                                                  \
    fmi1Status NAMED(Get##Type)(fmi1Component c, const fmi1ValueReference vr[], size_t n, type value[]) {   \
        Model *m = c;                                                                                       \
        m->v[POSITIVE] = m->v[X] > 0.0;                                                                     \
        for (size_t i = 0; i < n; i++) value[i] = (type)m->v[vr[i]];                                        \
        return m->initialized ? fmi1OK : fmi1Error;                                                         \
    }                                                                                                       \
    fmi1Status NAMED(Set##Type)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const type value[]) { \
        for (size_t i = 0; i < n; i++) ((Model *)c)->v[vr[i]] = value[i];                                   \
        return fmi1OK;                                                                                      \
    }
ACCESS(Real, double)
ACCESS(Integer, int)
ACCESS(Boolean, char)
fmi1Status NAMED(GetString)(fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1String value[]) {
    for (size_t i = 0; i < n; i++) value[i] = ((Model *)c)->name;
    return fmi1OK;
}
fmi1Status NAMED(SetString)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1String value[]) {
    for (size_t i = 0; i < n; i++) snprintf(((Model *)c)->name, 40, "%s", value[i]);
    return fmi1OK;
}
fmi1Status NAMED(DoStep)(fmi1Component c, double t, double h, fmi1Boolean new_step) {
    Model *m = c;
    if (m->v[T_WRONG] > 0.0 && t + h > m->v[T_WRONG]) {
        m->logger(c, "first", fmi1Error, "error", "%s cannot go beyond %g s", m->name, m->v[T_WRONG]);
        return fmi1Error;
    }
    m->v[X] += h * m->v[GAIN] * m->v[U];
    m->v[STEPS] += 1.0;
    return fmi1OK;
}
#define UNUSED(name) fmi1Status NAMED(name)(void) { return fmi1Error; }
UNUSED(SetRealInputDerivatives)
UNUSED(GetRealOutputDerivatives)
UNUSED(CancelStep)
UNUSED(GetStatus)
UNUSED(GetRealStatus)
UNUSED(GetIntegerStatus)
UNUSED(GetBooleanStatus)
UNUSED(GetStringStatus)
