/* SPDX-License-Identifier: MIT-0
 *
 * Model Exchange, whatever the FMI version.
 */
#include "exchange.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

size_t exchange_indicators(void)
{
    size_t n = 0;
    for (int k = 0; k < MODEL_NG; k++) n += simulation_is_watched(k) != 0;
    return n;
}

static bool fits(Simulation *m, const char *function, const double *values, size_t n, size_t expected)
{
    if (n != expected)
        instance_error(m, "%s: %zu values are asked for, or given, where there are %zu.", function, n, expected);
    else if (n > 0 && !values)
        instance_error(m, "%s: an array is null.", function);
    else
        return true;
    return false;
}

/* Nothing can be computed here; a smaller step may help. */
static int discard(Simulation *m, const char *function)
{
    char text[sizeof m->message + 64];
    snprintf(text, sizeof text, "%s: %s", function, m->message);
    if (m->log) m->log(m->log_context, LOG_DISCARD, text);
    return STATUS_DISCARD;
}

int exchange_set_time(Simulation *m, const char *function, double t)
{
    State *s = &m->s;
    double earliest = fmax(s->watched.event, s->watched.completed[1]);
    if (!isfinite(t)) return instance_error(m, "%s: the time %g is not a finite number.", function, t);
    if (t < earliest - SAME_INSTANT)
        return instance_error(m, "%s: the time %.17g s is before %.17g s, and nothing goes back beyond the last event and "
                              "the last but one completed step.", function, t, earliest);
    if (s->mode == EVENT_MODE) {
        int status = exchange_enter_continuous_time_mode(m, function);
        if (status != STATUS_OK) return status;
    }
    if (s->t == t) return STATUS_OK;
    s->t = t;
    m->have = 0;
    return STATUS_OK;
}

int exchange_set_states(Simulation *m, const char *function, const double *x, size_t n)
{
    if (!fits(m, function, x, n, MODEL_NX)) return STATUS_ERROR;
    for (int i = 0; i < MODEL_NX; i++)
        if (!isfinite(x[i]))
            return instance_error(m, "%s: the state %s is set to %g.", function, model_unknown_names[i], x[i]);
    memcpy(m->s.v, x, MODEL_NX * sizeof *x);
    m->have = 0;
    return STATUS_OK;
}

/* The values of a store, which begin at `values`. */
static int fetch(Simulation *m, const char *function, ModelStore store, const double **values)
{
    if (!instance_initialise(m)) return STATUS_ERROR;
    *values = simulation_values(m, store);
    return *values ? STATUS_OK : discard(m, function);
}

int exchange_get_states(Simulation *m, const char *function, double *x, size_t n)
{
    if (!fits(m, function, x, n, MODEL_NX)) return STATUS_ERROR;
    if (!instance_initialise(m)) return STATUS_ERROR;
    if (n > 0) memcpy(x, m->s.v, n * sizeof *x);
    return STATUS_OK;
}

int exchange_get_nominals(Simulation *m, const char *function, double *nominals, size_t n)
{
    if (!fits(m, function, nominals, n, MODEL_NX)) return STATUS_ERROR;
    if (n > 0) memcpy(nominals, model_nominal, n * sizeof *nominals);
    return STATUS_OK;
}

int exchange_get_derivatives(Simulation *m, const char *function, double *derivatives, size_t n)
{
    const double *f;
    if (!fits(m, function, derivatives, n, MODEL_NX)) return STATUS_ERROR;
    if (n == 0) return STATUS_OK;
    int status = fetch(m, function, STORE_DERIVATIVE, &f);
    if (status != STATUS_OK) return status;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(f[i])) {
            simulation_fail(m, "at t = %.9g s the derivative of %s is %g.", m->s.t, model_unknown_names[i], f[i]);
            return discard(m, function);
        }
    memcpy(derivatives, f, n * sizeof *derivatives);
    return STATUS_OK;
}

int exchange_get_indicators(Simulation *m, const char *function, double *z, size_t n)
{
    const double *all;
    if (!fits(m, function, z, n, exchange_indicators())) return STATUS_ERROR;
    if (n == 0) return STATUS_OK;
    int status = fetch(m, function, STORE_INDICATOR, &all);
    if (status != STATUS_OK) return status;
    for (int k = 0; k < MODEL_NG; k++)
        if (simulation_is_watched(k)) *z++ = all[k];
    return STATUS_OK;
}

/* Let the algebraic unknowns of this point be where the next ones are looked for from. */
static bool settle_here(Simulation *m)
{
    const double *v = simulation_values(m, STORE_UNKNOWN);
    if (!v) return false;
    simulation_settle(m, v, 0);
    return true;
}

static bool within_stop(Simulation *m, const char *function)
{
    const State *s = &m->s;
    if (s->t <= s->stop + fmax(SAME_INSTANT, 1e-13 * fabs(s->stop))) return true;
    instance_error(m, "%s: the time %.17g s is beyond the stop time %.17g s.", function, s->t, s->stop);
    return false;
}

int exchange_complete_step(Simulation *m, const char *function)
{
    State *s = &m->s;
    if (!within_stop(m, function)) return STATUS_ERROR;
    if (!settle_here(m)) return instance_failed(m);
    s->counters[COUNTER_STEPS]++;
    /* An importer may go back and complete a shorter step. */
    s->watched.completed[1] = fmin(s->watched.completed[0], s->t);
    s->watched.completed[0] = s->t;
    if (!simulation_check_selection(m) || !simulation_check_assertions(m)) return instance_failed(m);
    simulation_watch_for_reflection(m);
    return STATUS_OK;
}

int exchange_enter_event_mode(Simulation *m, const char *function)
{
    State *s = &m->s;
    if (!within_stop(m, function)) return STATUS_ERROR;
    if (s->mode == EVENT_MODE) return STATUS_OK;
    if (!settle_here(m) || !simulation_note_state_event(m)) return instance_failed(m);
    s->watched.event = s->t;
    s->mode = EVENT_MODE;
    return STATUS_OK;
}

int exchange_enter_continuous_time_mode(Simulation *m, const char *function)
{
    State *s = &m->s;
    if (s->event_due) {
        /* Inputs were set after the event was over. */
        int reinitialised = 0;
        if (!simulation_event(m, 0, &reinitialised)) return instance_failed(m);
        s->watched.reinitialised |= reinitialised;
    }
    if (s->watched.reinitialised)
        return instance_error(m, "%s: the inputs set last have given states new values; update the discrete states once "
                              "more, and take these values over.", function);
    if (MODEL_NG > 0) {
        const double *v = simulation_values(m, STORE_UNKNOWN);
        if (!v) return instance_failed(m);
        simulation_arm_indicators(m, v);
    }
    s->watched.event = s->watched.completed[0] = s->watched.completed[1] = s->t;
    s->trend.points = 0;
    simulation_settle(m, s->v, 1);
    s->mode = CONTINUOUS_TIME_MODE;
    return STATUS_OK;
}
