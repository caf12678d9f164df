/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0: getting and setting variables. All are scalars.
 */
#include "fmi3Functions.h"
#include "values.h"

static const int STATES_SET_IN = CONTINUOUS_TIME_MODE | EVENT_MODE;

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

static bool counts_agree(Simulation *m, const char *function, const void *references, size_t n, const void *values,
                         size_t n_values)
{
    if (n != n_values)
        instance_error(m, "%s: %zu values for %zu variables; all variables are scalars.", function, n_values, n);
    else if (n > 0 && (!references || !values))
        instance_error(m, "%s: an array is null.", function);
    else
        return true;
    return false;
}

#define GETTER(NAME, FETCH)                                                                                         \
    fmi3Status fmi3Get##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[],                     \
                             size_t nValueReferences, fmi3##NAME values[], size_t nValues)                          \
    {                                                                                                               \
        Simulation *m = instance_entering(instance, CALL_ANY_TIME, __func__);                                       \
        if (!m || !counts_agree(m, __func__, valueReferences, nValueReferences, values, nValues)) return fmi3Error; \
        for (size_t k = 0; k < nValues; k++) {                                                                      \
            double value;                                                                                           \
            if (!FETCH) return fmi3Error;                                                                           \
            values[k] = (fmi3##NAME)value;                                                                          \
        }                                                                                                           \
        return fmi3OK;                                                                                              \
    }

GETTER(Float64, get(m, __func__, valueReferences[k], ONE_OF(TYPE_REAL), &value))
GETTER(Int32, get_whole(m, __func__, valueReferences[k], ONE_OF(TYPE_INTEGER), 2147483647.0, &value))
GETTER(Boolean, get_whole(m, __func__, valueReferences[k], ONE_OF(TYPE_BOOLEAN), 1.0, &value))
GETTER(Int64, get_whole(m, __func__, valueReferences[k], ONE_OF(TYPE_ENUMERATION), WHOLE, &value))
GETTER(UInt64, get_whole(m, __func__, valueReferences[k], ONE_OF(TYPE_COUNTER), WHOLE, &value))

/* All values are looked at before the first is set, so that a refused call changes nothing. */
#define SETTER(NAME, TYPE)                                                                                          \
    fmi3Status fmi3Set##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[],                     \
                             size_t nValueReferences, const fmi3##NAME values[], size_t nValues)                    \
    {                                                                                                               \
        Simulation *m = instance_entering(instance, CALL_SET_VARIABLES, __func__);                                  \
        if (!m || !counts_agree(m, __func__, valueReferences, nValueReferences, values, nValues)) return fmi3Error; \
        for (size_t k = 0; k < nValues; k++)                                                                        \
            if (!may_set(m, __func__, valueReferences[k], ONE_OF(TYPE), (double)values[k])) return fmi3Error;       \
        bool changed[2] = {false, false};                                                                           \
        for (size_t k = 0; k < nValues; k++) set(m, valueReferences[k], (double)values[k], changed);                \
        after_setting(m, changed);                                                                                  \
        return fmi3OK;                                                                                              \
    }

SETTER(Float64, TYPE_REAL)
SETTER(Int32, TYPE_INTEGER)
SETTER(Boolean, TYPE_BOOLEAN)
SETTER(Int64, TYPE_ENUMERATION)

/* No model has variables of these types: reading or setting none of them is fine, anything else a mistake. */
static fmi3Status none_of_this_type(fmi3Instance instance, const char *function, size_t n)
{
    Simulation *m = instance_entering(instance, CALL_ANY_TIME, function);
    if (!m) return fmi3Error;
    if (n > 0) instance_error(m, "%s: the model has no variables of this type.", function);
    return n > 0 ? fmi3Error : fmi3OK;
}

#define NO_GETTER(NAME)                                                                                   \
    fmi3Status fmi3Get##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t n, \
                             fmi3##NAME values[], size_t nValues)                                         \
    {                                                                                                     \
        (void)valueReferences, (void)values, (void)nValues;                                               \
        return none_of_this_type(instance, __func__, n);                                                  \
    }
#define NO_SETTER(NAME)                                                                                   \
    fmi3Status fmi3Set##NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t n, \
                             const fmi3##NAME values[], size_t nValues)                                   \
    {                                                                                                     \
        (void)valueReferences, (void)values, (void)nValues;                                               \
        return none_of_this_type(instance, __func__, n);                                                  \
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
