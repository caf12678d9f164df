/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0: getting and setting variables. All are scalars.
 */
#include <math.h>

#include "instance.h"

static const char *type_name(int type)
{
    switch (type) {
    case TYPE_REAL: return "Float64";
    case TYPE_INTEGER: return "Int32";
    case TYPE_BOOLEAN: return "Boolean";
    case TYPE_ENUMERATION: return "Int64 (enumeration)";
    default: return "UInt64";
    }
}

/* The description of a variable that is accessed as `type`, or NULL after having said what is wrong. */
static const ModelVariable *find(Instance *i, const char *function, fmi3ValueReference reference, int type)
{
    if (reference >= MODEL_NVARIABLES) {
        instance_error(i, "%s: there is no variable with value reference %u.", function, (unsigned)reference);
        return NULL;
    }
    const ModelVariable *variable = &model_variables[reference];
    if (variable->type == type) return variable;
    instance_error(i, "%s: the variable with value reference %u is a %s.", function, (unsigned)reference,
                   type_name(variable->type));
    return NULL;
}

static bool counts_agree(Instance *i, const char *function, const void *references, size_t n, const void *values,
                         size_t n_values)
{
    if (n != n_values)
        instance_error(i, "%s: %zu values for %zu variables; all variables are scalars.", function, n_values, n);
    else if (n > 0 && (!references || !values))
        instance_error(i, "%s: an array is null.", function);
    else
        return true;
    return false;
}

static bool get(Instance *i, const char *function, fmi3ValueReference reference, int type, double *value)
{
    const ModelVariable *variable = find(i, function, reference, type);
    if (!variable) return false;
    State *s = &i->sim.s;
    switch (variable->store) {
    case STORE_TIME: *value = s->t; return true;
    case STORE_INPUT: *value = s->u[variable->index]; return true;
    case STORE_PARAMETER: *value = s->p[variable->index]; return true;
    case STORE_COUNTER: *value = (double)s->counters[variable->index]; return true;
    default: break;
    }
    if (s->mode == INSTANTIATED) {
        instance_error(i, "%s: the variable with value reference %u has no value before Initialization Mode.", function,
                       (unsigned)reference);
        return false;
    }
    const double *values = simulation_values(&i->sim, (ModelStore)variable->store);
    if (!values) {
        instance_error(i, "%s: %s", function, i->sim.message);
        return false;
    }
    *value = values[variable->index];
    return true;
}

/* Integers, Booleans and enumerations are computed as doubles. */
static bool get_whole(Instance *i, const char *function, fmi3ValueReference reference, int type, double limit,
                      double *value)
{
    if (!get(i, function, reference, type, value)) return false;
    *value = round(*value);
    if (fabs(*value) <= limit) return true;
    instance_error(i, "%s: the variable with value reference %u has the value %g, which is not a %s.", function,
                   (unsigned)reference, *value, type_name(type));
    return false;
}

#define GETTER(NAME, TYPE, FETCH)                                                                               \
    fmi3Status fmi3Get##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[],                 \
                             size_t nValueReferences, fmi3##NAME values[], size_t nValues)                      \
    {                                                                                                           \
        Instance *i = instance_entering(instance, ANY_MODE, __func__);                                          \
        if (!i || !counts_agree(i, __func__, valueReferences, nValueReferences, values, nValues)) return fmi3Error; \
        for (size_t k = 0; k < nValues; k++) {                                                                  \
            double value;                                                                                       \
            if (!FETCH) return fmi3Error;                                                                       \
            values[k] = (fmi3##NAME)value;                                                                      \
        }                                                                                                       \
        return fmi3OK;                                                                                          \
    }

/* Doubles count exactly up to 2^53. */
#define WHOLE 9007199254740992.0

GETTER(Float64, TYPE_REAL, get(i, __func__, valueReferences[k], TYPE_REAL, &value))
GETTER(Int32, TYPE_INTEGER, get_whole(i, __func__, valueReferences[k], TYPE_INTEGER, 2147483647.0, &value))
GETTER(Boolean, TYPE_BOOLEAN, get_whole(i, __func__, valueReferences[k], TYPE_BOOLEAN, 1.0, &value))
GETTER(Int64, TYPE_ENUMERATION, get_whole(i, __func__, valueReferences[k], TYPE_ENUMERATION, WHOLE, &value))
GETTER(UInt64, TYPE_COUNTER, get_whole(i, __func__, valueReferences[k], TYPE_COUNTER, WHOLE, &value))

static bool may_set(Instance *i, const char *function, fmi3ValueReference reference, int type, double value)
{
    const ModelVariable *variable = find(i, function, reference, type);
    if (!variable) return false;
    int mode = i->sim.s.mode;
    bool early = mode == INSTANTIATED || mode == INITIALIZATION_MODE;
    if (variable->settable == SET_NEVER || (variable->store != STORE_INPUT && variable->store != STORE_PARAMETER))
        instance_error(i, "%s: the variable with value reference %u cannot be set.", function, (unsigned)reference);
    else if (variable->settable == SET_BEFORE_INITIALIZATION_ENDS && !early)
        instance_error(i, "%s: the variable with value reference %u can be set before the end of Initialization Mode "
                       "only.", function, (unsigned)reference);
    else if (!isfinite(value) || (type != TYPE_REAL && fabs(value) > WHOLE))
        instance_error(i, "%s: the variable with value reference %u is set to %g, which is not a usable number.",
                       function, (unsigned)reference, value);
    else
        return true;
    return false;
}

/* Notes in changed[0] a new value of an input, in changed[1] one of a parameter. */
static void set(Instance *i, fmi3ValueReference reference, double value, bool changed[2])
{
    const ModelVariable *variable = &model_variables[reference];
    State *s = &i->sim.s;
    bool parameter = variable->store == STORE_PARAMETER;
    double *place = parameter ? &s->p[variable->index] : &s->u[variable->index];
    changed[parameter] |= *place != value;
    *place = value;
}

static void after_setting(Instance *i, bool parameters)
{
    State *s = &i->sim.s;
    if (s->mode & (INSTANTIATED | INITIALIZATION_MODE)) s->initialised = 0;
    simulation_changed(&i->sim, parameters);
}

/* All values are looked at before the first is set, so that a refused call changes nothing. */
#define SETTER(NAME, TYPE)                                                                                          \
    fmi3Status fmi3Set##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[],                     \
                             size_t nValueReferences, const fmi3##NAME values[], size_t nValues)                    \
    {                                                                                                               \
        Instance *i =                                                                                               \
            instance_entering(instance, INSTANTIATED | INITIALIZATION_MODE | EVENT_MODE | STEP_MODE, __func__);     \
        if (!i || !counts_agree(i, __func__, valueReferences, nValueReferences, values, nValues)) return fmi3Error; \
        for (size_t k = 0; k < nValues; k++)                                                                        \
            if (!may_set(i, __func__, valueReferences[k], TYPE, (double)values[k])) return fmi3Error;               \
        bool changed[2] = {false, false};                                                                           \
        for (size_t k = 0; k < nValues; k++) set(i, valueReferences[k], (double)values[k], changed);                \
        if (changed[0] || changed[1]) after_setting(i, changed[1]);                                                 \
        return fmi3OK;                                                                                              \
    }

SETTER(Float64, TYPE_REAL)
SETTER(Int32, TYPE_INTEGER)
SETTER(Boolean, TYPE_BOOLEAN)
SETTER(Int64, TYPE_ENUMERATION)

/* No model has variables of these types: reading or setting none of them is fine, anything else a mistake. */
static fmi3Status none_of_this_type(fmi3Instance instance, const char *function, size_t n)
{
    Instance *i = instance_entering(instance, ANY_MODE, function);
    if (!i) return fmi3Error;
    return n == 0 ? fmi3OK : instance_error(i, "%s: the model has no variables of this type.", function);
}

#define NO_GETTER(NAME)                                                                                              \
    fmi3Status fmi3Get##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t n,            \
                             fmi3##NAME values[], size_t nValues)                                                    \
    {                                                                                                                \
        (void)valueReferences, (void)values, (void)nValues;                                                          \
        return none_of_this_type(instance, __func__, n);                                                             \
    }
#define NO_SETTER(NAME)                                                                                              \
    fmi3Status fmi3Set##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t n,            \
                             const fmi3##NAME values[], size_t nValues)                                              \
    {                                                                                                                \
        (void)valueReferences, (void)values, (void)nValues;                                                          \
        return none_of_this_type(instance, __func__, n);                                                             \
    }
#define NEITHER(NAME) NO_GETTER(NAME) NO_SETTER(NAME)

NEITHER(Float32)
NEITHER(Int8)
NEITHER(UInt8)
NEITHER(Int16)
NEITHER(UInt16)
NEITHER(UInt32)
NEITHER(String)
NO_SETTER(UInt64)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return none_of_this_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return none_of_this_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return none_of_this_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return none_of_this_type(instance, __func__, nValueReferences);
}
