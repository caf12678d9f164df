/* SPDX-License-Identifier: MIT-0
 *
 * Reading and setting variables by value reference, for the one file of a shell that does so. Here, and not in a file
 * of their own, since they are called for each single value. All variables are scalars.
 */
#ifndef COSIM_VALUES_H
#define COSIM_VALUES_H

#include <math.h>
#include <string.h>

#include "instance.h"

/* A set of types, for functions that access several. */
#define ONE_OF(type) (1u << (type))

/* Doubles count exactly up to 2^53. */
#define WHOLE 9007199254740992.0

/* FMI's name of a ModelType; defined by the file that includes this one. */
static const char *type_name(int type);

/* In which modes FMI lets continuous states be set one by one, in Model Exchange; defined likewise. */
static const int STATES_SET_IN;

/* The description of a variable that is accessed as one of `types`, or NULL after having said what is wrong. */
static inline const ModelVariable *find(Simulation *m, const char *function, unsigned reference, unsigned types)
{
    if (reference >= MODEL_NVARIABLES) {
        instance_error(m, "%s: there is no variable with value reference %u.", function, reference);
        return NULL;
    }
    const ModelVariable *variable = &model_variables[reference];
    if (ONE_OF(variable->type) & types) return variable;
    instance_error(m, "%s: the variable with value reference %u is a %s.", function, reference,
                   type_name(variable->type));
    return NULL;
}

static inline bool get(Simulation *m, const char *function, unsigned reference, unsigned types, double *value)
{
    const ModelVariable *variable = find(m, function, reference, types);
    if (!variable) return false;
    const State *s = &m->s;
    switch (variable->store) {
    case STORE_TIME: *value = s->t; return true;
    case STORE_INPUT: *value = (s->inputs_wait ? s->u_waiting : s->u)[variable->index]; return true;
    case STORE_PARAMETER: *value = s->p[variable->index]; return true;
    case STORE_COUNTER: *value = (double)s->counters[variable->index]; return true;
    default: break;
    }
    if (s->mode & BEFORE_INITIALIZATION) {
        instance_error(m, "%s: the variable with value reference %u has no value before Initialization Mode.", function,
                       reference);
        return false;
    }
    bool discrete = variable->store == STORE_DISCRETE || variable->type != TYPE_REAL;
    const double *values =
        (discrete && s->kept ? simulation_kept_values : simulation_values)(m, (ModelStore)variable->store);
    if (!values) {
        instance_error(m, "%s: %s", function, m->message);
        return false;
    }
    *value = values[variable->index];
    return true;
}

/* Integers, Booleans and enumerations are computed as doubles. */
static inline bool get_whole(Simulation *m, const char *function, unsigned reference, unsigned types, double limit,
                             double *value)
{
    if (!get(m, function, reference, types, value)) return false;
    *value = round(*value);
    if (fabs(*value) <= limit) return true;
    instance_error(m, "%s: the variable with value reference %u has the value %g, which is not a %s.", function,
                   reference, *value, type_name(model_variables[reference].type));
    return false;
}

/* What FMI lets change in Event Mode only, in Model Exchange: parameters and inputs of discrete variability. */
static inline bool is_held(const ModelVariable *variable)
{
    return variable->store == STORE_PARAMETER ||
           (variable->store == STORE_INPUT && (variable->type != TYPE_REAL || MODEL_NV == 0));
}

static inline bool is_settable_state(const Simulation *m, const ModelVariable *variable)
{
    return variable->store == STORE_UNKNOWN && (int)variable->index < MODEL_NX && m->s.type == MODEL_EXCHANGE &&
           (m->s.mode & STATES_SET_IN);
}

static inline bool may_set(Simulation *m, const char *function, unsigned reference, unsigned types, double value)
{
    const ModelVariable *variable = find(m, function, reference, types);
    if (!variable) return false;
    bool early = m->s.mode & (BEFORE_INITIALIZATION | INITIALIZATION_MODE);
    if (variable->settable == SET_NEVER && !is_settable_state(m, variable))
        instance_error(m, "%s: the variable with value reference %u cannot be set.", function, reference);
    else if (variable->settable == SET_BEFORE_INITIALIZATION_ENDS && !early)
        instance_error(m, "%s: the variable with value reference %u can be set before the end of Initialization Mode "
                       "only.", function, reference);
    else if (m->s.mode == CONTINUOUS_TIME_MODE && is_held(variable))
        instance_error(m, "%s: the variable with value reference %u does not vary continuously: it can be "
                       "set in Event Mode only.",
                       function, reference);
    else if (!isfinite(value) || (variable->type != TYPE_REAL && fabs(value) > WHOLE))
        instance_error(m, "%s: the variable with value reference %u is set to %g, which is not a usable number.",
                       function, reference, value);
    else
        return true;
    return false;
}

/* Notes in changed[0] a new value of an input or a state, in changed[1] one of a parameter. */
static inline void set(Simulation *m, unsigned reference, double value, bool changed[2])
{
    const ModelVariable *variable = &model_variables[reference];
    State *s = &m->s;
    bool parameter = variable->store == STORE_PARAMETER;
    double *u = s->inputs_wait ? s->u_waiting : s->u;
    double *values = parameter ? s->p : variable->store == STORE_UNKNOWN ? s->v : u, *place = &values[variable->index];
    changed[parameter] |= *place != value;
    *place = value;
}

static inline void after_setting(Simulation *m, const bool changed[2])
{
    State *s = &m->s;
    if (!changed[1] && (!changed[0] || s->inputs_wait)) return;
    if (s->mode & (BEFORE_INITIALIZATION | INITIALIZATION_MODE)) s->initialised = 0;
    simulation_changed(m, changed[1]);
}

#endif
