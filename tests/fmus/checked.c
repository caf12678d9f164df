/* SPDX-License-Identifier: MIT-0
 *
 * x' = u1, y = gain u1 + u1 u2, z = |u2|, with state, derivatives and events as the standard has them; the environment
 * variable CHECKED_LIE names one thing that it does otherwise.
 */
#include <stdlib.h>
#include <string.h>

static int lies(const char *how) {
    const char *told = getenv("CHECKED_LIE");
    return told && strcmp(told, how) == 0;
}

#define IS_WRONG(token) (!lies("ANY_TOKEN") && strcmp(token, "test"))
#define REFUSAL(m) (lies("REFUSES") ? refusal(m) : OK)
#define OWN_RESET
static int refusal(void *instance);
#include "shell.h"

enum { U1 = 1, U2, GAIN, X, Y, Z, FLAG, EVENTS, FIRST, X0 };

static int runs;

static void start(Model *m) {
    m->v[U1] = 0.5;
    m->v[GAIN] = lies("START_VALUE") ? 2.5 : 2.0;
    if (lies("NOT_REPEATED")) m->v[X] = m->v[X0] = 1e-9 * runs++;
}

static void reset(Model *m) {
    const double x = m->v[X], x0 = m->v[X0];
    memset(m->v, 0, sizeof m->v);
    start(m);
    m->v[X] = m->v[X0] = x0;
    if (lies("NOT_RESET")) m->v[X] = x;
}

static int refusal(void *instance) {
    say(instance, "the pump is not primed");
    return ERROR;
}

static int event(Model *m) {
    m->v[EVENTS] += 1.0;
    m->update_needed = lies("ENDLESS_EVENTS");
    return OK;
}

static void outputs(Model *m) {
    m->v[Y] = m->v[GAIN] * m->v[U1] + m->v[U1] * m->v[U2];
    m->v[Z] = fabs(m->v[U2]);
}

static int step(Model *m, double h) {
    if (lies("CRASH")) *(volatile int *)8 = 1;
    if (lies("ABORT")) abort();
    if (lies("EXIT")) exit(7);
    while (lies("HANG")) {}
    if (m->v[FIRST] == 0.0) m->v[FIRST] = h;
    if (lies("EQUAL_STEPS") && fabs(h - m->v[FIRST]) > 1e-9) {
        say(m, "all steps have to be equal");
        return ERROR;
    }
    m->v[X] = lies("NO_NUMBER") ? NAN : m->v[X] + h * m->v[U1];
    return OK;
}

static double slope(const Model *m, unsigned unknown, unsigned known) {
    const double *v = m->v;
    if (unknown == Y && known == U1) return v[GAIN] + v[U2];
    if (unknown == Y && known == U2 && lies("OPPOSITE_DERIVATIVE")) return -v[U1];
    if (unknown == Y && known == U2) return lies("WRONG_DERIVATIVE") ? 1.01 * v[U1] : v[U1];
    if (unknown == Z && known == U2) return v[U2] < 0.0 ? -1.0 : 1.0;
    return 0.0;
}

#if FMI == 2
#define STATUS fmi2Status
#define INSTANCE fmi2Component
#define STATE fmi2FMUstate
#define BYTE fmi2Byte
#define NAME(two, three) fmi2##two
#define REFERENCE fmi2ValueReference
#define REAL fmi2Real
#else
#define STATUS fmi3Status
#define INSTANCE fmi3Instance
#define STATE fmi3FMUState
#define BYTE fmi3Byte
#define NAME(two, three) fmi3##three
#define REFERENCE fmi3ValueReference
#define REAL fmi3Float64
#endif

STATUS NAME(GetFMUstate, GetFMUState)(INSTANCE c, STATE *state) {
    if (lies("CRASH_IN_STATE")) *(volatile int *)8 = 1;
    *state = malloc(sizeof(Model));
    memcpy(*state, c, sizeof(Model));
    return OK;
}
STATUS NAME(SetFMUstate, SetFMUState)(INSTANCE c, STATE state) {
    const double x = ((Model *)c)->v[X];
    memcpy(((Model *)c)->v, ((Model *)state)->v, sizeof((Model *)c)->v);
    if (lies("NOT_RESTORED")) ((Model *)c)->v[X] = x;
    return OK;
}
STATUS NAME(FreeFMUstate, FreeFMUState)(INSTANCE c, STATE *state) {
    free(*state);
    *state = NULL;
    return OK;
}
STATUS NAME(SerializedFMUstateSize, SerializedFMUStateSize)(INSTANCE c, STATE state, size_t *size) {
    *size = sizeof(Model);
    return OK;
}
STATUS NAME(SerializeFMUstate, SerializeFMUState)(INSTANCE c, STATE state, BYTE bytes[], size_t size) {
    memcpy(bytes, state, size);
    if (lies("NOT_SERIALIZED")) memset(bytes + offsetof(Model, v) + X * sizeof(double), 0, sizeof(double));
    return OK;
}
STATUS NAME(DeSerializeFMUstate, DeserializeFMUState)(INSTANCE c, const BYTE bytes[], size_t size, STATE *state) {
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return OK;
}
STATUS NAME(GetDirectionalDerivative, GetDirectionalDerivative)(INSTANCE c, const REFERENCE unknown[], size_t nu,
                                                                const REFERENCE known[], size_t nk, const REAL seed[],
#if FMI == 3
                                                                size_t n_seed, REAL out[], size_t n_out) {
#else
                                                                REAL out[]) {
#endif
    for (size_t i = 0; i < nu; i++) {
        out[i] = 0.0;
        for (size_t k = 0; k < nk; k++) out[i] += slope(c, unknown[i], known[k]) * seed[k];
    }
    return OK;
}
STATUS NAME(GetRealOutputDerivatives, GetOutputDerivatives)(INSTANCE c, const REFERENCE vr[], size_t n,
#if FMI == 3
                                                            const fmi3Int32 order[], REAL value[], size_t nv) {
#else
                                                            const fmi2Integer order[], REAL value[]) {
#endif
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == X ? ((Model *)c)->v[U1] : 0.0;
    return lies("NO_SLOPES") ? ERROR : OK;
}
#if FMI == 3
fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const REFERENCE unknown[], size_t nu, const REFERENCE known[],
                                    size_t nk, const REAL seed[], size_t n_seed, REAL out[], size_t n_out) {
    for (size_t k = 0; k < nk; k++) {
        out[k] = 0.0;
        for (size_t i = 0; i < nu; i++) out[k] += slope(c, unknown[i], known[k]) * seed[i];
        if (lies("WRONG_ADJOINT")) out[k] = -out[k];
    }
    return OK;
}
#endif
