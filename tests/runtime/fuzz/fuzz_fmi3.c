/* FMI 3.0 in its own words. */
#include "fmi3Functions.h"
#include "fuzz.h"

static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    Subject *s = environment;
    if (s && category && message) hear(s, message);
    (void)status;
}

void *make(Subject *s)
{
    bool fine = true;
    const char *token = chance(0.03) ? (fine = false, "{other}") : perhaps((void *)MODEL_TOKEN, &fine);
    const char *name = chance(0.03) ? (fine = false, "") : perhaps((void *)"it", &fine);
    s->exchange = chance(0.5);
    s->events = !s->exchange && chance(0.5);
    s->early = s->events && chance(0.5);
    s->logs = chance(0.8);
    s->known = (Known){.state = SET_UP, .next = INFINITY};
    fmi3LogMessageCallback say = s->logs ? log_message : NULL;
    s->fmu = s->exchange ? fmi3InstantiateModelExchange(name, token, NULL, false, chance(0.5), s, say)
                         : fmi3InstantiateCoSimulation(name, token, NULL, false, chance(0.5), s->events, s->early, NULL,
                                                       0, s, say, NULL);
    judge_instance(fine, s->fmu);
    return s->fmu;
}

void unmake(Subject *s)
{
    fmi3FreeInstance(s->fmu);
    s->fmu = NULL;
}

static int complete_step(void *fmu, bool missing)
{
    fmi3Boolean enter, end;
    return (int)fmi3CompletedIntegratorStep(fmu, chance(0.5), missing ? NULL : &enter, &end);
}

static int update(void *fmu, bool missing, bool *defined, double *next)
{
    fmi3Boolean need, end, nominals, values;
    return (int)fmi3UpdateDiscreteStates(fmu, &need, missing ? NULL : &end, &nominals, &values, defined, next);
}

static int set_log(void *fmu, size_t n, const char *const *categories)
{
    return (int)fmi3SetDebugLogging(fmu, chance(0.5), n, (const fmi3String *)categories);
}

#define ALIKE(RESULT, NAME, FUNCTION, PARAMETERS, ARGUMENTS) \
    static RESULT NAME PARAMETERS                            \
    {                                                        \
        return (RESULT)FUNCTION ARGUMENTS;                   \
    }
ALIKE(int, enter_event_mode, fmi3EnterEventMode, (void *fmu), (fmu))
ALIKE(int, enter_continuous, fmi3EnterContinuousTimeMode, (void *fmu), (fmu))
ALIKE(int, exit_initialization, fmi3ExitInitializationMode, (void *fmu), (fmu))
ALIKE(int, set_time, fmi3SetTime, (void *fmu, double t), (fmu, t))
ALIKE(int, set_states, fmi3SetContinuousStates, (void *fmu, const double *x, size_t n), (fmu, x, n))
ALIKE(int, get_states, fmi3GetContinuousStates, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, get_derivatives, fmi3GetContinuousStateDerivatives, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, get_indicators, fmi3GetEventIndicators, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, get_nominals, fmi3GetNominalsOfContinuousStates, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, terminate, fmi3Terminate, (void *fmu), (fmu))
ALIKE(int, reset, fmi3Reset, (void *fmu), (fmu))
ALIKE(int, save, fmi3GetFMUState, (void *fmu, void **s), (fmu, s))
ALIKE(int, restore, fmi3SetFMUState, (void *fmu, void *s), (fmu, s))
ALIKE(int, forget, fmi3FreeFMUState, (void *fmu, void **s), (fmu, s))
ALIKE(int, size, fmi3SerializedFMUStateSize, (void *fmu, void *s, size_t *n), (fmu, s, n))
ALIKE(int, serialize, fmi3SerializeFMUState, (void *fmu, void *s, unsigned char *b, size_t n), (fmu, s, b, n))
ALIKE(int, deserialize, fmi3DeserializeFMUState, (void *fmu, const unsigned char *b, size_t n, void **s),
      (fmu, b, n, s))

const Fmi fmi = {
    .name = "fmi3", .enter_event_mode = enter_event_mode, .enter_continuous_time_mode = enter_continuous,
    .exit_initialization = exit_initialization, .set_time = set_time, .set_states = set_states,
    .get_states = get_states, .get_derivatives = get_derivatives, .get_indicators = get_indicators,
    .get_nominals = get_nominals, .complete_step = complete_step, .update = update, .terminate = terminate,
    .reset = reset, .log = set_log, .save = save, .restore = restore, .forget = forget, .size = size,
    .serialize = serialize, .deserialize = deserialize, .event_mode_from = "C", .time_from = "C",
    .states_in_event_mode = true,
};

static void enter_initialization(void)
{
    double start = between(0.0, 1.0), stop = start + between(0.1, 20.0), tolerance = 1e-5;
    bool fine = true, has_stop = chance(0.7), has_tolerance = chance(0.5);
    if (chance(0.03)) start = weird(), fine = false;
    if (has_stop && chance(0.03)) stop = start - 1.0, fine = false;
    if (has_tolerance && chance(0.05)) tolerance = chance(0.5) ? NAN : -1.0, fine = false;
    bool is_right = right("U", "U", fine);
    int status = fmi3EnterInitializationMode(subject->fmu, has_tolerance, tolerance, start, has_stop, stop);
    if (!judge("EnterInitializationMode", is_right, false, status)) return;
    Known *k = &subject->known;
    *k = (Known){.state = INITIALIZING, .t = start, .stop = has_stop ? stop : INFINITY, .earliest = start,
                 .completed = {start, start}, .next = start};
}

static void enter_step_mode(void)
{
    bool is_right = right("E", "", true);
    if (judge("EnterStepMode", is_right, false, (int)fmi3EnterStepMode(subject->fmu))) subject->known.state = STEP;
}

static void do_step(void)
{
    Known *k = &subject->known;
    bool fine = true;
    double t = k->t, h = between(1e-3, 0.1), last = 0.0;
    fmi3Boolean event, end, early;
    if (chance(0.03)) t += chance(0.5) ? 0.01 : -0.01, fine = false;
    if (chance(0.03)) h = chance(0.5) ? weird() : -h, fine = false;
    if (t + h > k->stop) fine = false;
    fmi3Boolean *place = perhaps(&early, &fine);
    bool is_right = right("S", "", fine);
    int status = (int)fmi3DoStep(subject->fmu, t, h, chance(0.5), &event, &end, place, &last);
    if (judge("DoStep", is_right, false, status)) k->t = last;
    else if (is_right) k->state = BROKEN;
}

typedef union {
    double real[ROOM];
    int32_t integer[ROOM];
    bool boolean[ROOM];
    int64_t enumeration[ROOM];
    uint64_t counter[ROOM];
} Values;

static const unsigned types_of[] = {TYPES(TYPE_REAL), TYPES(TYPE_INTEGER), TYPES(TYPE_BOOLEAN), TYPES(TYPE_ENUMERATION),
                                    TYPES(TYPE_COUNTER)};

static void get_variables(void)
{
    fmi3ValueReference vr[ROOM];
    Values v;
    bool fine = true;
    unsigned type = below(5);
    size_t n = references(types_of[type], ROOM, vr, &fine), count = perhaps_other(n, &fine);
    for (size_t k = 0; k < n; k++) fine &= vr[k] < MODEL_NVARIABLES && gettable(&model_variables[vr[k]]);
    fmi3ValueReference *place = n > 0 ? perhaps(vr, &fine) : vr;
    bool is_right = right(ALWAYS, ALWAYS, fine), broken = subject->known.state == BROKEN;
    int status;
    switch (type) {
    case 0: status = (int)fmi3GetFloat64(subject->fmu, place, n, v.real, count); break;
    case 1: status = (int)fmi3GetInt32(subject->fmu, place, n, v.integer, count); break;
    case 2: status = (int)fmi3GetBoolean(subject->fmu, place, n, v.boolean, count); break;
    case 3: status = (int)fmi3GetInt64(subject->fmu, place, n, v.enumeration, count); break;
    default: status = (int)fmi3GetUInt64(subject->fmu, place, n, v.counter, count);
    }
    judge_reading("Get", is_right, broken, status);
}

static void set_variables(void)
{
    fmi3ValueReference vr[ROOM];
    Values v;
    bool fine = true;
    unsigned type = below(4);
    size_t n = references(types_of[type], ROOM, vr, &fine), count = perhaps_other(n, &fine);
    for (size_t k = 0; k < n; k++) {
        bool usable = true;
        double value = type == 0 ? value_for(vr[k], &usable) : below(2);
        fine &= usable && vr[k] < MODEL_NVARIABLES && settable(&model_variables[vr[k]], value);
        switch (type) {
        case 0: v.real[k] = value; break;
        case 1: v.integer[k] = (int32_t)value; break;
        case 2: v.boolean[k] = value != 0.0; break;
        default: v.enumeration[k] = (int64_t)value;
        }
    }
    fmi3ValueReference *place = n > 0 ? perhaps(vr, &fine) : vr;
    bool is_right = right("UNES", "UNEC", fine);
    int status;
    switch (type) {
    case 0: status = (int)fmi3SetFloat64(subject->fmu, place, n, v.real, count); break;
    case 1: status = (int)fmi3SetInt32(subject->fmu, place, n, v.integer, count); break;
    case 2: status = (int)fmi3SetBoolean(subject->fmu, place, n, v.boolean, count); break;
    default: status = (int)fmi3SetInt64(subject->fmu, place, n, v.enumeration, count);
    }
    if (judge("Set", is_right, false, status)) subject->known.touched = true;
}

/* What no model of ours has, and calls without an instance. */
static void unsupported(void)
{
    void *fmu = subject->fmu;
    fmi3ValueReference vr[1] = {0};
    double number[1] = {0.0};
    size_t size[1] = {0};
    fmi3Binary binary[1] = {0};
    fmi3Clock clock[1] = {0};
    fmi3String string[1] = {0};
    fmi3IntervalQualifier qualifier[1];
    bool is_right = right("", "", true);
    int status = 3;
    switch (below(13)) {
    case 0: status = (int)fmi3GetClock(fmu, vr, 1, clock); break;
    case 1: status = (int)fmi3SetClock(fmu, vr, 1, clock); break;
    case 2: status = (int)fmi3GetBinary(fmu, vr, 1, size, binary, 1); break;
    case 3: status = (int)fmi3SetBinary(fmu, vr, 1, size, binary, 1); break;
    case 4: status = (int)fmi3GetString(fmu, NULL, 1, string, 1); break;
    case 5: status = (int)fmi3SetString(fmu, vr, 1, NULL, 1); break;
    case 6: status = (int)fmi3EnterConfigurationMode(fmu); break;
    case 7: status = (int)fmi3ExitConfigurationMode(fmu); break;
    case 8: status = (int)fmi3EvaluateDiscreteStates(fmu); break;
    case 9: status = (int)fmi3GetIntervalDecimal(fmu, vr, 1, number, qualifier); break;
    case 10: status = (int)fmi3ActivateModelPartition(fmu, 0, 0.0); break;
    case 11: status = (int)fmi3GetNumberOfContinuousStates(fmu, NULL); break;
    default: status = (int)fmi3GetNumberOfEventIndicators(fmu, NULL);
    }
    judge("a function that is not supported", is_right, false, status);
}

static void directional(void)
{
    fmi3ValueReference unknown[ROOM], knowns[ROOM];
    double seed[ROOM], result[ROOM];
    bool fine = true;
    size_t n = references(types_of[0], ROOM, unknown, &fine), m = references(types_of[0], ROOM, knowns, &fine);
    for (size_t k = 0; k < ROOM; k++) seed[k] = chance(0.1) ? weird() : between(-1.0, 1.0);
    bool adjoint = chance(0.5), nothing = chance(0.05);
    right(ALWAYS, ALWAYS, true);
    judge_reading("a directional derivative", true, true,
                  adjoint ? (int)fmi3GetAdjointDerivative(subject->fmu, unknown, n, knowns, m, nothing ? NULL : seed, n,
                                                          result, m)
                          : (int)fmi3GetDirectionalDerivative(subject->fmu, unknown, n, knowns, m, nothing ? NULL : seed, m,
                                                              result, n));
}

static void no_instance(void)
{
    right("", "", true);
    long said = subject->said;
    double x[1] = {0.0};
    int status = 3;
    switch (below(5)) {
    case 0: status = (int)fmi3SetTime(NULL, 0.0); break;
    case 1: status = (int)fmi3GetFloat64(NULL, NULL, 0, x, 0); break;
    case 2: status = (int)fmi3Terminate(NULL); break;
    case 3: status = (int)fmi3GetContinuousStates(NULL, x, 1); break;
    default: fmi3FreeInstance(NULL);
    }
    subject->said = said + 1; /* there is nobody to say anything */
    judge("a call without instance", false, false, status);
}

const Choice own_choices[] = {
    {40, enter_initialization}, {20, enter_step_mode}, {60, do_step},    {50, get_variables},
    {60, set_variables},        {10, unsupported},     {10, directional}, {3, no_instance},
};
const size_t n_own = sizeof own_choices / sizeof *own_choices;
