/* SPDX-License-Identifier: MIT-0
 *
 * Life cycle and steps of an instance, whatever the FMI version.
 */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *log_category(LogKind kind)
{
    switch (kind) {
    case LOG_EVENT: return "logEvents";
    case LOG_WARNING: return "logStatusWarning";
    case LOG_DISCARD: return "logStatusDiscard";
    default: return "logStatusError";
    }
}

int log_status(LogKind kind)
{
    switch (kind) {
    case LOG_EVENT: return STATUS_OK;
    case LOG_WARNING: return STATUS_WARNING;
    case LOG_DISCARD: return STATUS_DISCARD;
    default: return STATUS_ERROR;
    }
}

int instance_error(Simulation *m, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (m->log) m->log(m->log_context, LOG_ERROR, text);
    return STATUS_ERROR;
}

int instance_failed(Simulation *m)
{
    m->s.mode = FAILED;
    return instance_error(m, "%s", m->message);
}

Simulation *instance_entering(void *instance, Call call, const char *function)
{
    Simulation *m = instance;
    if (!m) return NULL;
    if (call_is_allowed(call, m->s.type, m->s.mode)) return m;
    if (call_exists(call, m->s.type))
        instance_error(m, "%s is not allowed %s.", function, instance_mode_name(m->s.mode));
    else
        instance_error(m, "%s does not exist in %s.", function,
                       m->s.type == MODEL_EXCHANGE ? "Model Exchange" : "Co-Simulation");
    return NULL;
}

bool instance_may_begin(Simulation *m, const char *name, const char *token, const char *function)
{
    if (!name || name[0] == '\0')
        instance_error(m, "%s: the instance needs a name.", function);
    else if (!token || strcmp(token, shell_token) != 0)
        instance_error(m, "%s: the instantiation token is not that of this FMU (%s); the modelDescription.xml "
                       "belongs to another build.", name, shell_token);
    else
        return true;
    return false;
}

void *instance_new(size_t size, void (*log)(void *log_context, LogKind kind, const char *text), bool log_events)
{
    Simulation *m = calloc(1, size);
    if (!m) return NULL;
    m->log = log;
    m->log_context = m;
    m->log_events = log_events;
    return m;
}

void instance_begin(Simulation *m, InterfaceType type, int mode)
{
    simulation_reset(m);
    m->s.type = type;
    m->s.mode = mode;
}

int instance_log_events(Simulation *m, const char *function, bool on, size_t n, const char *const categories[])
{
    if (n > 0 && !categories) return instance_error(m, "%s: categories is null.", function);
    bool events = n == 0;
    for (size_t k = 0; k < n; k++)
        if (categories[k] && strcmp(categories[k], log_category(LOG_EVENT)) == 0) events = true;
    m->log_events = on && events;
    return STATUS_OK;
}

/* Below this, rounding errors would be taken for errors of the method. */
static const double LEAST_TOLERANCE = 1e-12;

static void raise_tolerance(Simulation *m)
{
    char text[200];
    snprintf(text, sizeof text, "The tolerance %g is below what double precision allows; %g is taken instead.",
             m->s.tolerance, LEAST_TOLERANCE);
    m->s.tolerance = LEAST_TOLERANCE;
    if (m->log) m->log(m->log_context, LOG_WARNING, text);
}

bool instance_set_up(Simulation *m, bool has_tolerance, double tolerance, double start, bool has_stop, double stop)
{
    State *s = &m->s;
    if (!isfinite(start))
        instance_error(m, "The start time %g is not a finite number.", start);
    else if (has_tolerance && !(tolerance > 0.0 && tolerance < 1.0))
        instance_error(m, "The tolerance %g is not between 0 and 1.", tolerance);
    else if (has_stop && !(stop >= start))
        instance_error(m, "The stop time %g s is before the start time %g s.", stop, start);
    else {
        s->t = start;
        s->stop = has_stop ? stop : INFINITY;
        s->watched.event = s->watched.completed[0] = s->watched.completed[1] = start;
        if (has_tolerance) s->tolerance = tolerance;
        if (s->tolerance < LEAST_TOLERANCE) raise_tolerance(m);
        simulation_changed(m, false);
        return true;
    }
    return false;
}

bool instance_initialise(Simulation *m)
{
    if (m->s.initialised || simulation_initialise(m)) return true;
    instance_error(m, "%s", m->message);
    return false;
}

bool instance_end(Simulation *m)
{
    if (simulation_end(m)) return true;
    instance_error(m, "%s", m->message);
    return false;
}

int instance_update(Simulation *m, const char *function, Update *update)
{
    State *s = &m->s;
    int reinitialised = 0;
    if (!simulation_event(m, 1, &reinitialised)) return instance_failed(m);
    update->next = simulation_next_time_event(m);
    if (simulation_tick_is_due(m)) {
        simulation_fail(m, "%s: at t = %.17g s more than one instant of a sample clock has passed since the last event, the "
                        "next at %.17g s. The events at nextEventTime must not be left out.", function, s->t,
                        update->next);
        return instance_failed(m);
    }
    update->terminate = s->terminate != 0;
    if (s->terminate) simulation_log_termination(m, LOG_WARNING);
    update->states_changed = reinitialised || s->watched.reinitialised;
    s->watched.reinitialised = 0;
    update->has_next = isfinite(update->next);
    if (!update->has_next) update->next = 0.0;
    return STATUS_OK;
}

bool instance_accepts_step(Simulation *m, const char *function, double t, double h)
{
    const State *s = &m->s;
    double to = t + h;
    /* The importer's sums of steps may differ from ours by rounding. */
    double same = fmax(SAME_INSTANT, 1e-13 * fabs(to));
    if (!(fabs(t - s->t) <= same))
        instance_error(m, "%s: the communication point %.17g s is not the instance's time %.17g s.", function, t, s->t);
    else if (!(h > 0.0) || !isfinite(to))
        instance_error(m, "%s: the step size %g s is not a positive number.", function, h);
    else if (to > s->stop + same)
        instance_error(m, "%s: the step to %.17g s goes beyond the stop time %.17g s.", function, to, s->stop);
    else
        return true;
    return false;
}

static const double MOST_AHEAD = 100.0;

Advance instance_run(Simulation *m, double to, bool stop_at_events)
{
    while (m->s.t < to && !(m->intermediate && m->s.t >= m->return_at)) {
        if (m->s.terminate) return ADVANCE_TERMINATED;
        if (simulation_time_event_is_due(m) && !simulation_event(m, 1, NULL)) return ADVANCE_FAILED;
        double tick = simulation_next_time_event(m);
        bool tick_inside = tick < to - SAME_INSTANT;
        /* Far beyond the step asked for, an event could no longer be located as accurately as within it. */
        double limit = fmin(fmin(tick, m->s.stop), to + MOST_AHEAD * (to - m->s.t));
        if (limit < to + SAME_INSTANT) limit = to;
        Advance outcome = simulation_advance(m, tick_inside ? tick : to, tick_inside ? tick : limit, stop_at_events);
        if (outcome != ADVANCE_REACHED || (stop_at_events && simulation_time_event_is_due(m))) return outcome;
    }
    /* Relations change where the step ends; clocks that tick there wait for the importer's inputs, and so does what
     * changes together with them. */
    bool relation_due = simulation_time_event_is_due(m) && !simulation_tick_is_due(m);
    if (relation_due && !stop_at_events && !simulation_event(m, 0, NULL)) return ADVANCE_FAILED;
    return ADVANCE_REACHED;
}
