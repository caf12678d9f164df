/* SPDX-License-Identifier: MIT-0
 *
 * FMI's state machines: which call is allowed in which state, for all versions of FMI and both types of interface.
 */
#ifndef COSIM_CALLS_H
#define COSIM_CALLS_H

#include <stdbool.h>

typedef enum { CO_SIMULATION, MODEL_EXCHANGE } InterfaceType;

/* FMI's states; bits, so that a call can name all in which it is allowed. */
enum {
    INSTANTIATED = 1, /* FMI 2.0: the experiment is not known yet */
    SET_UP = 2,
    INITIALIZATION_MODE = 4,
    EVENT_MODE = 8,
    STEP_MODE = 16,            /* Co-Simulation */
    CONTINUOUS_TIME_MODE = 32, /* Model Exchange */
    TERMINATED = 64,
    FAILED = 128, /* a step or an event has failed: only reset, restoring a state and looking are left */
    INTERMEDIATE_UPDATE = 256, /* FMI 3.0: the importer is called back inside a step */
    BEFORE_INITIALIZATION = INSTANTIATED | SET_UP
};

/* One name for what is called alike, or differently, in the versions of FMI. */
typedef enum {
    CALL_ANY_TIME,  /* logging, reading variables */
    CALL_NEW_STATE, /* reset, copies of the state */
    CALL_SET_UP_EXPERIMENT,
    CALL_ENTER_INITIALIZATION,
    CALL_EXIT_INITIALIZATION,
    CALL_SET_VARIABLES,
    CALL_ENTER_EVENT_MODE,
    CALL_ENTER_EVENT_MODE_AGAIN, /* FMI 2.0 */
    CALL_UPDATE_DISCRETE_STATES,
    CALL_ENTER_STEP_MODE,
    CALL_STEP,
    CALL_STEP_STATUS,
    CALL_ENTER_CONTINUOUS_TIME,
    CALL_SET_TIME,
    CALL_SET_TIME_AFTER_EVENT, /* FMI 2.0 */
    CALL_SET_STATES,
    CALL_COMPLETED_STEP,
    CALL_GET_CONTINUOUS, /* states, their derivatives, event indicators */
    CALL_GET_SIZES,      /* how many there are, and their nominal values */
    CALL_GET_DIRECTIONAL_DERIVATIVES,
    CALL_GET_OUTPUT_DERIVATIVES,
    CALL_TERMINATE,
    CALLS
} Call;

bool call_is_allowed(Call call, InterfaceType type, int mode);
/* Whether there is any state in which it is. */
bool call_exists(Call call, InterfaceType type);

#endif
