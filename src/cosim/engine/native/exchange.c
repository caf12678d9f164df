/* SPDX-License-Identifier: Apache-2.0
 *
 * A Model Exchange FMU as CVode sees it: the derivatives of its states, and its event indicators as roots. The same calls
 * in the same order as in cosim/engine/_integration.py, without Python in between.
 */
#define DISCARD 2 /* the FMU cannot be evaluated there: a shorter step may help */
#define NOWHERE (-1)

typedef enum { SET_TIME, SET_STATES, GET_RATES, GET_INDICATORS } Evaluation;
typedef Status (*SetTime)(void *, double);
typedef Status (*Vector)(void *, double *, size_t);

typedef struct {
    void *instance;
    Function functions[4];       /* of the FMU, in the order of Evaluation */
    double *(*data)(void *vector); /* N_VGetArrayPointer of SUNDIALS */
    Position *at;                /* where it is noted which function runs, and that it is another call */
    int64_t n_states, n_indicators, evaluations;
    int32_t number;              /* of the component */
    int32_t numbers[4];          /* of the functions */
    int32_t failed, status;      /* function and status of what stopped the solver */
} Exchange;

static int outcome(Exchange *x, Evaluation function, Status status) {
    x->at->call.component = NOWHERE;
    if (status < FAILED) return 0;
    if (status == DISCARD) return 1;
    x->failed = (int32_t)function;
    x->status = status;
    return -1;
}

static void tell(const Exchange *x, Evaluation function) {
    x->at->calls++;
    x->at->call = (Call){x->number, x->numbers[function]};
}

static Status evaluate(const Exchange *x, Evaluation function, double *values, int64_t n) {
    tell(x, function);
    return ((Vector)x->functions[function])(x->instance, values, (size_t)n);
}

/* Put the FMU to a time and states; of the two functions the one that did worse tells. */
static Status place(const Exchange *x, double t, void *states) {
    tell(x, SET_TIME);
    const Status timed = ((SetTime)x->functions[SET_TIME])(x->instance, t);
    if (x->n_states == 0) return timed;
    const Status placed = evaluate(x, SET_STATES, x->data(states), x->n_states);
    return timed > placed ? timed : placed;
}

EXPORT int cosim_rates(double t, void *states, void *rates, void *exchange) {
    Exchange *x = exchange;
    x->evaluations++;
    Status status = place(x, t, states);
    if (x->n_states == 0) {
        *x->data(rates) = 0.0; /* of the state that stands for none */
        return outcome(x, SET_TIME, status);
    }
    if (status < FAILED) status = evaluate(x, GET_RATES, x->data(rates), x->n_states);
    return outcome(x, GET_RATES, status);
}

EXPORT int cosim_indicators(double t, void *states, double *indicators, void *exchange) {
    Exchange *x = exchange;
    Status status = place(x, t, states);
    if (status < FAILED) status = evaluate(x, GET_INDICATORS, indicators, x->n_indicators);
    return outcome(x, GET_INDICATORS, status);
}

EXPORT int64_t cosim_exchange_size(void) { return sizeof(Exchange); }
