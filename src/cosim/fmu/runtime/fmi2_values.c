/* SPDX-License-Identifier: MIT-0
 *
 * FMI 2.0: getting and setting variables. Enumerations and counters are read and set as Integer.
 */
#include "fmi2Functions.h"
#include "values.h"

#define LARGEST_INTEGER 2147483647.0
#define INTEGERS (ONE_OF(TYPE_INTEGER) | ONE_OF(TYPE_ENUMERATION) | ONE_OF(TYPE_COUNTER))

static const int STATES_SET_IN = CONTINUOUS_TIME_MODE;

static const char *type_name(int type)
{
    switch (type) {
    case TYPE_REAL: return "Real";
    case TYPE_BOOLEAN: return "Boolean";
    case TYPE_ENUMERATION: return "Integer (enumeration)";
    default: return "Integer";
    }
}

static bool arrays_exist(Simulation *m, const char *function, const void *references, size_t n, const void *values)
{
    if (n == 0 || (references && values)) return true;
    instance_error(m, "%s: an array is null.", function);
    return false;
}

/* A counter that does not fit any more stays at the largest Integer, rather than to end a long simulation. */
static bool get_integer(Simulation *m, const char *function, unsigned reference, double *value)
{
    if (reference < MODEL_NVARIABLES && model_variables[reference].type == TYPE_COUNTER) {
        bool known = get_whole(m, function, reference, INTEGERS, WHOLE, value);
        *value = fmin(*value, LARGEST_INTEGER);
        return known;
    }
    return get_whole(m, function, reference, INTEGERS, LARGEST_INTEGER, value);
}

#define GETTER(NAME, FETCH)                                                                                            \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2##NAME value[])           \
    {                                                                                                                  \
        Simulation *m = instance_entering(c, CALL_ANY_TIME, __func__);                                                      \
        if (!m || !arrays_exist(m, __func__, vr, nvr, value)) return fmi2Error;                                        \
        for (size_t k = 0; k < nvr; k++) {                                                                             \
            double number = 0.0;                                                                                       \
            if (!FETCH) return fmi2Error;                                                                              \
            value[k] = (fmi2##NAME)number;                                                                             \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }

GETTER(Real, get(m, __func__, vr[k], ONE_OF(TYPE_REAL), &number))
GETTER(Integer, get_integer(m, __func__, vr[k], &number))
GETTER(Boolean, get_whole(m, __func__, vr[k], ONE_OF(TYPE_BOOLEAN), 1.0, &number))

/* From now on inputs go to the side, until the next step begins. */
static void let_inputs_wait(State *s)
{
    if (s->mode != STEP_MODE || s->inputs_wait) return;
    memcpy(s->u_waiting, s->u, sizeof s->u);
    s->inputs_wait = 1;
}

/* All values are looked at before the first is set, so that a refused call changes nothing. */
#define SETTER(NAME, TYPES)                                                                                            \
    fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2##NAME value[])     \
    {                                                                                                                  \
        Simulation *m = instance_entering(c, CALL_SET_VARIABLES, __func__);                                            \
        if (!m || !arrays_exist(m, __func__, vr, nvr, value)) return fmi2Error;                                        \
        for (size_t k = 0; k < nvr; k++)                                                                               \
            if (!may_set(m, __func__, vr[k], TYPES, (double)value[k])) return fmi2Error;                               \
        bool changed[2] = {false, false};                                                                              \
        let_inputs_wait(&m->s);                                                                                        \
        for (size_t k = 0; k < nvr; k++) set(m, vr[k], AS_##NAME(value[k]), changed);                                  \
        after_setting(m, changed);                                                                                     \
        return fmi2OK;                                                                                                 \
    }

#define AS_Real(value) (value)
#define AS_Integer(value) ((double)(value))
#define AS_Boolean(value) ((double)((value) != fmi2False))

SETTER(Real, ONE_OF(TYPE_REAL))
SETTER(Integer, INTEGERS)
SETTER(Boolean, ONE_OF(TYPE_BOOLEAN))

/* No model has Strings: reading or setting none of them is fine, anything else a mistake. */
static fmi2Status no_strings(fmi2Component c, const char *function, size_t n)
{
    Simulation *m = instance_entering(c, CALL_ANY_TIME, function);
    if (!m) return fmi2Error;
    if (n > 0) instance_error(m, "%s: the model has no variables of this type.", function);
    return n > 0 ? fmi2Error : fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)vr, (void)value;
    return no_strings(c, __func__, nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)vr, (void)value;
    return no_strings(c, __func__, nvr);
}
