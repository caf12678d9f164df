/* SPDX-License-Identifier: MIT-0
 * sizes: NX=1 NP=1 ND=1 NG=3 NA=2 NE=1 NVARIABLES=9
 *
 * One model for each way to go wrong, chosen by the parameter `kind`.
 */
#define SAMPLE_DISCRETE
#define SAMPLE_INITIAL
#include "sample.h"

enum {
    FINE,
    NOT_A_NUMBER,
    CHATTER,
    BLOW_UP,
    FLIP_FLOP,
    TERMINATE,
    ASSERTIONS,
    NO_INITIAL_STATE,
    PARADOX,
    RUNAWAY,
    BAD_REINIT,
    BAD_DISCRETE,
    SINGULAR_START,
    TERMINATE_AT_ONCE
};

const ModelVariable model_variables[MODEL_NVARIABLES] = {
    REAL(STORE_TIME, 0, SET_NEVER),
    REAL(STORE_UNKNOWN, 0, SET_NEVER),
    REAL(STORE_PARAMETER, 0, SET_BEFORE_INITIALIZATION_ENDS),
    COUNTER_VARIABLES,
};
const double model_start_parameters[1] = {FINE};
const double model_nominal[1] = {1.0};
const char *const model_unknown_names[1] = {"tank.level"};
const char *const model_discrete_names[1] = {"tank.alarm"};
const char *const model_initial_texts[1] = {"tank.level^2 = -1"};
const unsigned char model_relation_strict[3] = {1, 1, 1};
const char *const model_relation_texts[3] = {"tank.level > 0.5", "valve.open", "valve.shut"};
const char *const model_assertion_messages[2] = {"The tank overflows.", "The tank is nearly full."};
const unsigned char model_assertion_is_error[2] = {1, 0};
const char *const model_termination_messages[1] = {"The tank is half full."};

void model_start(const double *p, double *v, double *d)
{
    (void)p;
    v[0] = 0.0;
    d[0] = 0.0;
}

void model_rhs(MODEL_CONTINUOUS_ARGUMENTS, double *f)
{
    ARGUMENTS_UNUSED;
    switch ((int)p[0]) {
    case NOT_A_NUMBER: f[0] = 1.0 + 0.0 * sqrt(0.7 - v[0]); break;
    case CHATTER: f[0] = c[0] != 0.0 ? -1.0 : 1.0; break;
    case BLOW_UP: f[0] = 1.0 + v[0] * v[0]; break;
    default: f[0] = 1.0;
    }
}

void model_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = p[0] == BLOW_UP ? 2.0 * v[0] : 0.0;
}

void model_initial_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r)
{
    ARGUMENTS_UNUSED;
    r[0] = p[0] == SINGULAR_START ? 1.0 : p[0] == NO_INITIAL_STATE ? v[0] * v[0] + v[0] + 1.0 : v[0];
}

void model_initial_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)
{
    ARGUMENTS_UNUSED;
    J[0] = p[0] == SINGULAR_START ? 0.0 : p[0] == NO_INITIAL_STATE ? 2.0 * v[0] + 1.0 : 1.0;
}

void model_indicators(MODEL_CONTINUOUS_ARGUMENTS, double *g)
{
    ARGUMENTS_UNUSED;
    g[0] = v[0] - 0.5;
    g[1] = p[0] != PARADOX || c[0] == 0.0 ? -1.0 : c[2] != 0.0 ? -1.0 : 1.0;
    g[2] = p[0] != PARADOX || c[0] == 0.0 ? -1.0 : c[1] != 0.0 ? 1.0 : -1.0;
}

int model_violated_assertion(MODEL_CONTINUOUS_ARGUMENTS)
{
    ARGUMENTS_UNUSED;
    if (p[0] == ASSERTIONS && v[0] > 0.75) return 0;
    if (p[0] == ASSERTIONS && v[0] > 0.25) return 1;
    return -1;
}

int model_discrete(MODEL_CONTINUOUS_ARGUMENTS, const double *pre, const double *fired, int initial, double *d_new,
                   double *x_new)
{
    ARGUMENTS_UNUSED, (void)fired, (void)initial;
    int high = c[0] != 0.0;
    d_new[0] = p[0] == FLIP_FLOP && high ? 1.0 - d[0] : p[0] == RUNAWAY && high ? pre[0] + 1.0 : 0.0;
    if (p[0] == BAD_DISCRETE && high) d_new[0] = NAN;
    x_new[0] = p[0] == BAD_REINIT && high ? NAN : v[0];
    if (model_has_nan(d_new, 1)) return MODEL_NOT_A_NUMBER;
    return (p[0] == TERMINATE && high) || p[0] == TERMINATE_AT_ONCE;
}
