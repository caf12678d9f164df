/* SPDX-License-Identifier: MIT-0
 *
 * What a simulation tells the person: why it failed, which relations changed, which assertion does not hold.
 */
#include <stdarg.h>
#include <stdio.h>

#include "simulation.h"

int simulation_fail(Simulation *m, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(m->message, sizeof m->message, format, arguments);
    va_end(arguments);
    return 0;
}

const char *simulation_changing_relations(const Simulation *m, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int k = 0; k < MODEL_NG && used < size; k++)
        if (m->changing[k])
            used += (size_t)snprintf(text + used, size - used, "%s'%s'", used ? ", " : "", model_relation_texts[k]);
    return text;
}

void simulation_log_termination(Simulation *m, LogKind kind)
{
    if (!m->log || MODEL_NE == 0) return;
    char text[1024];
    snprintf(text, sizeof text, "At t = %.9g s the model ends the simulation: %s", m->s.t,
             model_termination_messages[m->s.terminate - 1]);
    m->log(m->log_context, kind, text);
}

int simulation_check_assertions(Simulation *m)
{
    if (MODEL_NA == 0) return 1;
    State *s = &m->s;
    int k = model_violated_assertion(s->t, s->v, s->u, s->p, s->d, s->c);
    if (k < 0 || k >= MODEL_NA) return 1;
    if (model_assertion_is_error[k])
        return simulation_fail(m, "At t = %.9g s an assertion of the model is violated: %s", s->t,
                               model_assertion_messages[k]);
    if (!s->warned[k] && m->log) {
        char text[1024];
        snprintf(text, sizeof text, "At t = %.9g s: %s", s->t, model_assertion_messages[k]);
        m->log(m->log_context, LOG_WARNING, text);
    }
    s->warned[k] = 1;
    return 1;
}
