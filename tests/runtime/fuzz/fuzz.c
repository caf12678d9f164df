/* What does not depend on the version of FMI: the driver, its memory watch, the judge. */
#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUBJECTS = 3, STATE_ROOM = 1 << 22 };

Subject *subject;
bool forgiving;
static bool faulty;
static Subject subjects[SUBJECTS];
static uint64_t random_state;
static const char *last = "nothing";
static long calls, wrong_calls, seed;

static char heard[2048];

void hear(Subject *s, const char *message)
{
    s->said += message[0] != '\0';
    snprintf(heard, sizeof heard, "%s", message);
}

/* Memory: the linker leads malloc, calloc and free here. */

static long living, taken;
static bool may_take;
void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void __real_free(void *pointer);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t n, size_t size);
void __wrap_free(void *pointer);

void *__wrap_malloc(size_t size)
{
    living++, taken++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t n, size_t size)
{
    living++, taken++;
    return __real_calloc(n, size);
}

void __wrap_free(void *pointer)
{
    living -= pointer != NULL;
    __real_free(pointer);
}

void memory_may_be_taken(void)
{
    may_take = true;
}

long memory_living(long change)
{
    return living += change;
}

static void fail(const char *what)
{
    printf("seed %ld, call %ld, %s in state %c of %s: %s; the last message was: %s\n", seed, calls, last,
           subject->known.state, subject->exchange ? "Model Exchange" : "Co-Simulation", what, heard);
    exit(1);
}

/* xorshift64* */
static uint64_t next_random(void)
{
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return random_state * UINT64_C(2685821657736338717);
}

unsigned below(unsigned n)
{
    return (unsigned)((next_random() >> 33) % n);
}

double between(double low, double high)
{
    return low + (high - low) * (double)(next_random() >> 11) / 9007199254740992.0;
}

bool chance(double probability)
{
    return between(0.0, 1.0) < probability;
}

double weird(void)
{
    const double values[] = {NAN, INFINITY, -INFINITY};
    return values[below(3)];
}

void *perhaps(void *pointer, bool *fine)
{
    if (!chance(0.02)) return pointer;
    *fine = false;
    return NULL;
}

size_t perhaps_other(size_t n, bool *fine)
{
    if (!chance(0.03)) return n;
    *fine = false;
    return n > 0 && chance(0.5) ? n - 1 : n + 1 + below(1000);
}

/* The judge. */

static unsigned char before[STATE_ROOM], after[STATE_ROOM];
static size_t size_before;
static long said_before;

bool right(const char *co_simulation, const char *exchange, bool arguments)
{
    const char *states = subject->exchange ? exchange : co_simulation;
    size_before = whole_state(subject->fmu, before, sizeof before);
    said_before = subject->said;
    may_take = false;
    taken = 0;
    return arguments && strchr(states, subject->known.state);
}

bool judge_reading(const char *function, bool is_right, bool may_fail, int status)
{
    last = function;
    calls++;
    wrong_calls += !is_right;
    if (taken && !may_take) fail("it has taken memory");
    if (status < 0 || status > 3) fail("the status is none that a call may return");
    if (status > 0 && subject->logs && subject->said == said_before) fail("it does not work, and has not said why");
    if (!is_right && status < 2) fail("it is wrong and yet works");
    if (is_right && status > 1 && !may_fail && !forgiving) fail("it is right and does not work");
    return status < 2;
}

bool judge(const char *function, bool is_right, bool may_fail, int status)
{
    bool works = judge_reading(function, is_right, may_fail, status);
    if (!is_right && (whole_state(subject->fmu, after, sizeof after) != size_before ||
                      memcmp(before, after, size_before) != 0))
        fail("it is wrong and has changed the instance");
    return works;
}

void judge_instance(bool is_right, const void *fmu)
{
    last = "Instantiate";
    calls++;
    wrong_calls += !is_right;
    if (is_right && !fmu) fail("it is right and does not work");
    if (!is_right && fmu) fail("it is wrong and yet works");
    if (!fmu && subject->logs && subject->said == 0) fail("it does not work, and has not said why");
}

/* Variables. */

bool gettable(const ModelVariable *variable)
{
    bool early = subject->known.state == INSTANTIATED || subject->known.state == SET_UP;
    return !early || variable->store == STORE_TIME || variable->store == STORE_INPUT ||
           variable->store == STORE_PARAMETER || variable->store == STORE_COUNTER;
}

bool settable(const ModelVariable *variable, double value)
{
    char state = subject->known.state;
    if (!isfinite(value) || !strchr("IUNESC", state)) return false;
    if (variable->store == STORE_INPUT && variable->settable == SET_ALWAYS)
        return state != CONTINUOUS || (variable->type == TYPE_REAL && MODEL_NV > 0);
    if (variable->store == STORE_UNKNOWN && (int)variable->index < MODEL_NX && subject->exchange)
        return state == CONTINUOUS || (state == EVENT && fmi.states_in_event_mode);
    if (variable->store == STORE_PARAMETER && variable->settable == SET_ALWAYS) return state != CONTINUOUS;
    if (variable->store == STORE_PARAMETER && variable->settable == SET_BEFORE_INITIALIZATION_ENDS)
        return strchr("IUN", state);
    return false;
}

double value_for(unsigned reference, bool *fine)
{
    if (chance(0.02)) {
        *fine = false;
        return weird();
    }
    const ModelVariable *variable = &model_variables[reference < MODEL_NVARIABLES ? reference : 0];
    if (variable->type != TYPE_REAL) return below(2);
    if (variable->store == STORE_PARAMETER && faulty) return below(20);
    if (variable->store == STORE_PARAMETER) return model_start_parameters[variable->index] * between(0.99, 1.01);
    if (variable->store == STORE_INPUT) return model_start_inputs[variable->index] + between(-0.1, 0.1);
    double x[MODEL_ROOM(MODEL_NX)] = {0};
    if (variable->store != STORE_UNKNOWN || (int)variable->index >= MODEL_NX || fmi.get_states(subject->fmu, x, MODEL_NX) > 1)
        return 0.0;
    return x[variable->index] + 1e-3 * model_nominal[variable->index] * between(-1.0, 1.0);
}

size_t references(unsigned types, unsigned room, unsigned *chosen, bool *fine)
{
    size_t n = 0, wanted = below(room + 1);
    bool right_ones = !chance(0.1);
    for (unsigned tries = 0; n < wanted && tries < 100; tries++) {
        unsigned reference = below(MODEL_NVARIABLES);
        if (right_ones && !(types & TYPES(model_variables[reference].type))) continue;
        if (!right_ones && chance(0.3)) reference = chance(0.5) ? MODEL_NVARIABLES : UINT32_MAX - below(3);
        chosen[n++] = reference;
        *fine &= reference < MODEL_NVARIABLES && (types & TYPES(model_variables[reference].type));
    }
    return n;
}

/* The driver. */

static void play(long steps)
{
    unsigned total = 0;
    for (size_t k = 0; k < n_own; k++) total += own_choices[k].weight;
    for (size_t k = 0; k < n_common; k++) total += common_choices[k].weight;
    for (long step = 0; step < steps; step++) {
        subject = &subjects[below(SUBJECTS)];
        if (!subject->fmu || chance(0.002)) {
            if (subject->fmu) unmake(subject);
            memset(subject, 0, sizeof *subject);
            subject->fmu = make(subject);
            continue;
        }
        unsigned number = below(total);
        const Choice *choice = own_choices;
        for (size_t k = 0; number >= choice->weight; choice = ++k < n_own ? &own_choices[k] : &common_choices[k - n_own])
            number -= choice->weight;
        choice->call();
    }
}

int main(int count, char **arguments)
{
    if (count < 4) return 2;
    seed = atol(arguments[1]);
    /* Of a faulty model the parameter is which fault it has; others may still have states that cannot be. */
    faulty = strcmp(arguments[3], "faulty") == 0;
    forgiving = faulty || strcmp(arguments[3], "forgiving") == 0;
    random_state = UINT64_C(0x9E3779B97F4A7C15) ^ ((uint64_t)seed << 17);
    play(atol(arguments[2]));
    while (!subject->fmu) subject = &subjects[below(SUBJECTS)];
    forget_copies();
    for (int k = 0; k < SUBJECTS; k++)
        if (subjects[k].fmu) unmake(&subjects[k]);
    if (living != 0) fail("memory is lost at the end");
    printf("%ld calls, %ld of them wrong\n", calls, wrong_calls);
    return 0;
}
