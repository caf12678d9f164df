/* FMI 2.0 in its own words. */
#include "fmi2Functions.h"
#include "fuzz.h"

static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...)
{
    Subject *s = environment;
    if (s && name && category && message) hear(s, message);
    (void)status;
}

void *make(Subject *s)
{
    bool fine = true;
    const char *token = chance(0.03) ? (fine = false, "{other}") : perhaps((void *)MODEL_TOKEN, &fine);
    const char *name = chance(0.03) ? (fine = false, "") : perhaps((void *)"it", &fine);
    s->exchange = chance(0.5);
    s->logs = chance(0.8);
    s->known = (Known){.state = INSTANTIATED, .next = INFINITY};
    fmi2CallbackFunctions callbacks = {.logger = s->logs ? log_message : NULL, .componentEnvironment = s};
    fmi2Type type = s->exchange ? fmi2ModelExchange : fmi2CoSimulation;
    if (chance(0.03)) type = (fmi2Type)7, fine = false;
    const fmi2CallbackFunctions *place = chance(0.02) ? (fine = false, s->logs = false, NULL) : &callbacks;
    s->fmu = fmi2Instantiate(name, type, token, NULL, place, 0, chance(0.5));
    judge_instance(fine, s->fmu);
    return s->fmu;
}

void unmake(Subject *s)
{
    fmi2FreeInstance(s->fmu);
    s->fmu = NULL;
}

static int complete_step(void *fmu, bool missing)
{
    fmi2Boolean enter, end;
    return (int)fmi2CompletedIntegratorStep(fmu, chance(0.5), missing ? NULL : &enter, &end);
}

static int update(void *fmu, bool missing, bool *defined, double *next)
{
    fmi2EventInfo info = {0};
    int status = (int)fmi2NewDiscreteStates(fmu, missing ? NULL : &info);
    *defined = info.nextEventTimeDefined;
    *next = info.nextEventTime;
    return status;
}

static int set_log(void *fmu, size_t n, const char *const *categories)
{
    return (int)fmi2SetDebugLogging(fmu, chance(0.5), n, (const fmi2String *)categories);
}

#define ALIKE(RESULT, NAME, FUNCTION, PARAMETERS, ARGUMENTS) \
    static RESULT NAME PARAMETERS                            \
    {                                                        \
        return (RESULT)FUNCTION ARGUMENTS;                   \
    }
ALIKE(int, enter_event_mode, fmi2EnterEventMode, (void *fmu), (fmu))
ALIKE(int, enter_continuous, fmi2EnterContinuousTimeMode, (void *fmu), (fmu))
ALIKE(int, exit_initialization, fmi2ExitInitializationMode, (void *fmu), (fmu))
ALIKE(int, set_time, fmi2SetTime, (void *fmu, double t), (fmu, t))
ALIKE(int, set_states, fmi2SetContinuousStates, (void *fmu, const double *x, size_t n), (fmu, x, n))
ALIKE(int, get_states, fmi2GetContinuousStates, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, get_derivatives, fmi2GetDerivatives, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, get_indicators, fmi2GetEventIndicators, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, get_nominals, fmi2GetNominalsOfContinuousStates, (void *fmu, double *x, size_t n), (fmu, x, n))
ALIKE(int, terminate, fmi2Terminate, (void *fmu), (fmu))
ALIKE(int, reset, fmi2Reset, (void *fmu), (fmu))
ALIKE(int, save, fmi2GetFMUstate, (void *fmu, void **s), (fmu, s))
ALIKE(int, restore, fmi2SetFMUstate, (void *fmu, void *s), (fmu, s))
ALIKE(int, forget, fmi2FreeFMUstate, (void *fmu, void **s), (fmu, s))
ALIKE(int, size, fmi2SerializedFMUstateSize, (void *fmu, void *s, size_t *n), (fmu, s, n))
ALIKE(int, serialize, fmi2SerializeFMUstate, (void *fmu, void *s, unsigned char *b, size_t n), (fmu, s, (fmi2Byte *)b, n))
ALIKE(int, deserialize, fmi2DeSerializeFMUstate, (void *fmu, const unsigned char *b, size_t n, void **s),
      (fmu, (const fmi2Byte *)b, n, s))

const Fmi fmi = {
    .name = "fmi2", .enter_event_mode = enter_event_mode, .enter_continuous_time_mode = enter_continuous,
    .exit_initialization = exit_initialization, .set_time = set_time, .set_states = set_states,
    .get_states = get_states, .get_derivatives = get_derivatives, .get_indicators = get_indicators,
    .get_nominals = get_nominals, .complete_step = complete_step, .update = update, .terminate = terminate,
    .reset = reset, .log = set_log, .save = save, .restore = restore, .forget = forget, .size = size,
    .serialize = serialize, .deserialize = deserialize, .event_mode_from = "CE", .time_from = MODEL_NX + MODEL_NG > 0 ? "C" : "CE",
};

static void set_up_experiment(void)
{
    double start = between(0.0, 1.0), stop = start + between(0.1, 20.0), tolerance = 1e-5;
    bool fine = true, has_stop = chance(0.7), has_tolerance = chance(0.5);
    if (chance(0.03)) start = weird(), fine = false;
    if (has_stop && chance(0.03)) stop = start - 1.0, fine = false;
    if (has_tolerance && chance(0.05)) tolerance = chance(0.5) ? NAN : -1.0, fine = false;
    bool is_right = right("IU", "IU", fine);
    int status = (int)fmi2SetupExperiment(subject->fmu, has_tolerance, tolerance, start, has_stop, stop);
    if (!judge("SetupExperiment", is_right, false, status)) return;
    subject->known = (Known){.state = SET_UP, .t = start, .stop = has_stop ? stop : INFINITY, .earliest = start,
                             .completed = {start, start}, .next = start};
}

static void enter_initialization(void)
{
    bool is_right = right("U", "U", true);
    int status = (int)fmi2EnterInitializationMode(subject->fmu);
    if (judge("EnterInitializationMode", is_right, false, status)) subject->known.state = INITIALIZING;
}

static void do_step(void)
{
    Known *k = &subject->known;
    bool fine = true;
    double t = k->t, h = between(1e-3, 0.1);
    if (chance(0.03)) t += chance(0.5) ? 0.01 : -0.01, fine = false;
    if (chance(0.03)) h = chance(0.5) ? weird() : -h, fine = false;
    if (t + h > k->stop) fine = false;
    bool is_right = right("S", "", fine);
    int status = (int)fmi2DoStep(subject->fmu, t, h, chance(0.5));
    if (judge("DoStep", is_right, false, status)) k->t = t + h;
    else if (is_right && status == fmi2Discard) fmi2GetRealStatus(subject->fmu, fmi2LastSuccessfulTime, &k->t);
    else if (is_right) k->state = BROKEN;
}

static const unsigned types_of[] = {TYPES(TYPE_REAL),
                                    TYPES(TYPE_INTEGER) | TYPES(TYPE_ENUMERATION) | TYPES(TYPE_COUNTER),
                                    TYPES(TYPE_BOOLEAN)};

static void get_variables(void)
{
    fmi2ValueReference vr[ROOM];
    double real[ROOM];
    int whole[ROOM];
    bool fine = true;
    unsigned type = below(3);
    size_t n = references(types_of[type], ROOM, vr, &fine);
    for (size_t k = 0; k < n; k++) fine &= vr[k] < MODEL_NVARIABLES && gettable(&model_variables[vr[k]]);
    fmi2ValueReference *place = n > 0 ? perhaps(vr, &fine) : vr;
    bool is_right = right(ALWAYS, ALWAYS, fine), broken = subject->known.state == BROKEN;
    int status;
    switch (type) {
    case 0: status = (int)fmi2GetReal(subject->fmu, place, n, real); break;
    case 1: status = (int)fmi2GetInteger(subject->fmu, place, n, whole); break;
    default: status = (int)fmi2GetBoolean(subject->fmu, place, n, whole);
    }
    judge_reading("Get", is_right, broken, status);
}

static void set_variables(void)
{
    fmi2ValueReference vr[ROOM];
    double real[ROOM];
    int whole[ROOM];
    bool fine = true;
    unsigned type = below(3);
    size_t n = references(types_of[type], ROOM, vr, &fine);
    for (size_t k = 0; k < n; k++) {
        bool usable = true;
        real[k] = type == 0 ? value_for(vr[k], &usable) : below(2);
        whole[k] = type == 0 ? 0 : (int)real[k];
        fine &= usable && vr[k] < MODEL_NVARIABLES && settable(&model_variables[vr[k]], real[k]);
    }
    fmi2ValueReference *place = n > 0 ? perhaps(vr, &fine) : vr;
    bool is_right = right("IUNS", "IUNEC", fine);
    int status;
    switch (type) {
    case 0: status = (int)fmi2SetReal(subject->fmu, place, n, real); break;
    case 1: status = (int)fmi2SetInteger(subject->fmu, place, n, whole); break;
    default: status = (int)fmi2SetBoolean(subject->fmu, place, n, whole);
    }
    if (judge("Set", is_right, false, status)) subject->known.touched = true;
}

static void unsupported(void)
{
    void *fmu = subject->fmu;
    fmi2ValueReference vr[1] = {0};
    fmi2String string[1] = {0};
    fmi2Integer order[1] = {1};
    double number[1] = {0.0};
    bool is_right = right("", "", true);
    int status = 3;
    switch (below(8)) {
    case 0: status = (int)fmi2GetString(fmu, vr, 1, string); break;
    case 1: status = (int)fmi2SetString(fmu, vr, 1, NULL); break;
    case 2: status = (int)fmi2CancelStep(fmu); break;
    case 3: status = (int)fmi2SetRealInputDerivatives(fmu, vr, 1, order, number); break;
    case 4: status = (int)fmi2GetStatus(fmu, fmi2DoStepStatus, NULL); break;
    case 5: status = (int)fmi2GetRealStatus(fmu, fmi2LastSuccessfulTime, NULL); break;
    case 6: status = (int)fmi2GetStringStatus(fmu, (fmi2StatusKind)9, string); break;
    default: status = (int)fmi2GetBooleanStatus(fmu, fmi2Terminated, NULL);
    }
    judge("a function that is not supported", is_right, false, status);
}

static void directional(void)
{
    fmi2ValueReference unknown[ROOM], knowns[ROOM];
    double seed[ROOM], result[ROOM];
    bool fine = true;
    size_t n = references(types_of[0], ROOM, unknown, &fine), m = references(types_of[0], ROOM, knowns, &fine);
    for (size_t k = 0; k < ROOM; k++) seed[k] = chance(0.1) ? weird() : between(-1.0, 1.0);
    bool nothing = chance(0.05);
    right(ALWAYS, ALWAYS, true);
    judge_reading("a directional derivative", true, true,
                  (int)fmi2GetDirectionalDerivative(subject->fmu, unknown, n, knowns, m, nothing ? NULL : seed, result));
}

static void no_instance(void)
{
    right("", "", true);
    long said = subject->said;
    double x[1] = {0.0};
    int status = 3;
    switch (below(5)) {
    case 0: status = (int)fmi2SetTime(NULL, 0.0); break;
    case 1: status = (int)fmi2GetReal(NULL, NULL, 0, x); break;
    case 2: status = (int)fmi2Terminate(NULL); break;
    case 3: status = (int)fmi2GetContinuousStates(NULL, x, 1); break;
    default: fmi2FreeInstance(NULL);
    }
    subject->said = said + 1; /* there is nobody to say anything */
    judge("a call without instance", false, false, status);
}

const Choice own_choices[] = {
    {40, set_up_experiment}, {40, enter_initialization}, {60, do_step},   {50, get_variables},
    {60, set_variables},     {10, unsupported},          {10, directional}, {3, no_instance},
};
const size_t n_own = sizeof own_choices / sizeof *own_choices;
