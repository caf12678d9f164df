/* The calls that both versions of FMI have. */
#include "fuzz.h"

#include <string.h>

enum { INDICATORS_MOST = MODEL_ROOM(MODEL_NG), COPIES = 4 };

static size_t indicators(void)
{
    size_t n = 0;
    for (int k = 0; k < MODEL_NG; k++) {
#if MODEL_HAS_TIME_RELATIONS
        if (model_relation_slope[k] != 0.0) continue;
#endif
        n++;
    }
    return n;
}

static Known *known(void)
{
    return &subject->known;
}

/* A call that goes on in `to` if it works, and breaks the instance if it does not, though it was right. */
static bool go(const char *name, bool is_right, bool may_fail, int status, char to)
{
    bool works = judge(name, is_right, may_fail, status);
    if (works) known()->state = to;
    else if (is_right && status == 3) known()->state = BROKEN;
    return works;
}

static void exit_initialization(void)
{
    bool is_right = right("N", "N", true);
    int status = fmi.exit_initialization(subject->fmu);
    bool works = judge("ExitInitializationMode", is_right, false, status);
    if (works) known()->state = subject->exchange || subject->events ? EVENT : STEP;
}

static void reset(void)
{
    bool is_right = right(ALWAYS, ALWAYS, true);
    judge("Reset", is_right, false, fmi.reset(subject->fmu));
    *known() = (Known){.state = strcmp(fmi.name, "fmi2") == 0 ? INSTANTIATED : SET_UP, .next = INFINITY};
}

static bool beyond_stop(void)
{
    return known()->t > known()->stop + 1e-6;
}

static void enter_event_mode(void)
{
    bool fine = subject->exchange ? !beyond_stop() || known()->state == EVENT : subject->events;
    bool is_right = right(subject->events ? "S" : "", fmi.event_mode_from, fine);
    char from = known()->state;
    if (!go("EnterEventMode", is_right, false, fmi.enter_event_mode(subject->fmu), EVENT)) return;
    if (subject->exchange && from == CONTINUOUS) known()->earliest = known()->t;
}

static void update(void)
{
    bool missing = chance(0.05), defined = false;
    double next = 0.0;
    bool is_right = right("E", "E", !missing);
    if (!go("UpdateDiscreteStates", is_right, false, fmi.update(subject->fmu, missing, &defined, &next), EVENT)) return;
    known()->next = defined ? next : INFINITY;
    known()->touched = false;
}

static void after_events(void)
{
    known()->state = CONTINUOUS;
    known()->earliest = known()->completed[0] = known()->completed[1] = known()->t;
}

static void enter_continuous_time_mode(void)
{
    bool is_right = right("", "E", true), touched = known()->touched;
    int status = fmi.enter_continuous_time_mode(subject->fmu);
    if (judge("EnterContinuousTimeMode", is_right, touched, status)) after_events();
    else if (is_right && forgiving) reset(); /* it is broken if the model fails, and not if states were set */
    else if (is_right) known()->touched = true;
}

static void set_time(void)
{
    Known *k = known();
    double earliest = fmax(k->earliest, k->completed[1]);
    double t = fmin(k->t + between(0.0, 0.05), k->next);
    bool fine = true;
    if (chance(0.2)) t = between(earliest, k->t);
    if (chance(0.05)) t = earliest - between(1e-6, 1.0), fine = false;
    if (chance(0.03)) t = weird(), fine = false;
    bool is_right = right("", fmi.time_from, fine), touched = k->state == EVENT;
    if (!judge("SetTime", is_right, touched, fmi.set_time(subject->fmu, t))) return;
    if (k->state == EVENT) after_events();
    k->t = t;
}

static void set_states(void)
{
    double x[MODEL_ROOM(MODEL_NX) + 1001] = {0};
    bool fine = true;
    if (fmi.get_states(subject->fmu, x, MODEL_NX) > 1) return;
    for (int i = 0; i < MODEL_NX; i++) x[i] += 1e-3 * model_nominal[i] * between(-1.0, 1.0);
    if (MODEL_NX > 0 && chance(0.05)) x[below(MODEL_ROOM(MODEL_NX))] = weird(), fine = false;
    const double *values = MODEL_NX > 0 ? perhaps(x, &fine) : x;
    size_t n = perhaps_other(MODEL_NX, &fine);
    bool is_right = right("", "C", fine);
    judge("SetContinuousStates", is_right, false, fmi.set_states(subject->fmu, values, n));
}

static void get_some(const char *name, int (*get)(void *, double *, size_t), size_t count, const char *states)
{
    double values[MODEL_ROOM(MODEL_NX) + INDICATORS_MOST + 1001];
    bool fine = true;
    double *place = count > 0 ? perhaps(values, &fine) : values;
    size_t n = perhaps_other(count, &fine);
    bool is_right = right("", states, fine);
    judge(name, is_right, known()->state == BROKEN, get(subject->fmu, place, n));
}

static void get_continuous(void)
{
    switch (below(4)) {
    case 0: get_some("GetContinuousStates", fmi.get_states, MODEL_NX, "NECTB"); break;
    case 1: get_some("GetDerivatives", fmi.get_derivatives, MODEL_NX, "NECTB"); break;
    case 2: get_some("GetEventIndicators", fmi.get_indicators, indicators(), "NECTB"); break;
    default: get_some("GetNominalsOfContinuousStates", fmi.get_nominals, MODEL_NX, ALWAYS);
    }
}

static void complete_step(void)
{
    bool missing = chance(0.05);
    bool is_right = right("", "C", !missing && !beyond_stop());
    if (!go("CompletedIntegratorStep", is_right, false, fmi.complete_step(subject->fmu, missing), CONTINUOUS)) return;
    known()->completed[1] = fmin(known()->completed[0], known()->t);
    known()->completed[0] = known()->t;
}

static void terminate(void)
{
    bool is_right = right("ES", "EC", true);
    int status = fmi.terminate(subject->fmu);
    judge("Terminate", is_right, false, status);
    if (is_right) known()->state = ENDED;
}

static void set_logging(void)
{
    const char *categories[3] = {"logEvents", "nonsense", NULL};
    bool fine = true;
    size_t n = below(4);
    const char *const *place = n > 0 ? perhaps(categories, &fine) : categories;
    bool is_right = right(ALWAYS, ALWAYS, fine);
    judge("SetDebugLogging", is_right, false, fmi.log(subject->fmu, n, place));
}

/* Copies of the state. */

typedef struct {
    void *state;
    bool exchange;
    Known known;
} Copy;
static Copy copies[COPIES];
static unsigned char bytes[1 << 22];
static size_t bytes_used;
static Copy bytes_of;

size_t whole_state(void *fmu, unsigned char *content, size_t room)
{
    static void *copy;
    size_t size = 0;
    long living = memory_living(0);
    if (fmi.save(fmu, &copy) || fmi.size(fmu, copy, &size) || size > room || fmi.serialize(fmu, copy, content, size))
        return 0;
    memory_living(living - memory_living(0));
    return size;
}

static void save(void)
{
    Copy *copy = &copies[below(COPIES)];
    bool fine = true;
    void *state = copy->state, **place = perhaps(&state, &fine);
    bool is_right = right(ALWAYS, ALWAYS, fine);
    if (!copy->state) memory_may_be_taken();
    if (!judge("GetFMUState", is_right, false, fmi.save(subject->fmu, place))) return;
    *copy = (Copy){state, subject->exchange, subject->known};
}

static void restore(void)
{
    Copy *copy = &copies[below(COPIES)];
    bool is_right = right(ALWAYS, ALWAYS, copy->state && copy->exchange == subject->exchange);
    if (judge("SetFMUState", is_right, false, fmi.restore(subject->fmu, copy->state))) subject->known = copy->known;
}

static void forget(void)
{
    Copy *copy = &copies[below(COPIES)];
    bool fine = true;
    void **place = perhaps(&copy->state, &fine);
    bool is_right = right(ALWAYS, ALWAYS, true);
    judge("FreeFMUState", is_right, false, fmi.forget(subject->fmu, place));
}

void forget_copies(void)
{
    for (int k = 0; k < COPIES; k++) fmi.forget(subject->fmu, &copies[k].state);
}

static void serialize(void)
{
    Copy *copy = &copies[below(COPIES)];
    size_t size = 0;
    bool fine = copy->state != NULL;
    size_t *place = perhaps(&size, &fine);
    bool is_right = right(ALWAYS, ALWAYS, fine);
    judge("SerializedFMUStateSize", is_right, false, fmi.size(subject->fmu, copy->state, place));
    if (!fine || size > sizeof bytes) return;
    if (chance(0.1)) size -= 1 + below((unsigned)size), fine = false;
    unsigned char *content = perhaps(bytes, &fine);
    is_right = right(ALWAYS, ALWAYS, fine);
    if (!judge("SerializeFMUState", is_right, false, fmi.serialize(subject->fmu, copy->state, content, size))) return;
    bytes_used = size;
    bytes_of = *copy;
}

static void deserialize(void)
{
    Copy *copy = &copies[below(COPIES)];
    if (bytes_used == 0) return;
    bool fine = true;
    size_t size = bytes_used, place = below((unsigned)bytes_used);
    unsigned char damage = chance(0.3) ? (unsigned char)(1 + below(255)) : 0;
    if (chance(0.1)) size = below((unsigned)bytes_used), fine = false;
    /* The header's last byte of the magic is followed by what has to agree; all of it is looked at. */
    bytes[place] ^= damage;
    fine &= !damage;
    const unsigned char *content = perhaps(bytes, &fine);
    void *state = copy->state, **where = perhaps(&state, &fine);
    bool is_right = right(ALWAYS, ALWAYS, fine);
    if (!copy->state) memory_may_be_taken();
    bool works = judge("DeserializeFMUState", is_right, false, fmi.deserialize(subject->fmu, content, size, where));
    if (works) *copy = (Copy){state, bytes_of.exchange, bytes_of.known};
    bytes[place] ^= damage;
}

const Choice common_choices[] = {
    {40, exit_initialization}, {20, enter_event_mode}, {30, update}, {30, enter_continuous_time_mode}, {60, set_time},
    {40, set_states},          {60, get_continuous},   {40, complete_step}, {2, terminate}, {2, reset},
    {5, set_logging},          {10, save},             {5, restore}, {4, forget}, {5, serialize}, {5, deserialize},
};
const size_t n_common = sizeof common_choices / sizeof *common_choices;
