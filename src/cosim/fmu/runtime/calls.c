/* SPDX-License-Identifier: MIT-0
 *
 * The table of the state machines; sections 3.2.3 and 4.2.4 of FMI 2.0, 2.3, 3.2 and 4.2 of FMI 3.0.
 */
#include "calls.h"

enum {
    ANY = BEFORE_INITIALIZATION | INITIALIZATION_MODE | EVENT_MODE | STEP_MODE | CONTINUOUS_TIME_MODE | TERMINATED |
          FAILED,
    NEVER = 0,
    CALLED_BACK = ANY | INTERMEDIATE_UPDATE,
    /* States that exist in one of the types only do no harm to the other: it is never in them. */
    STARTING = BEFORE_INITIALIZATION | INITIALIZATION_MODE,
    RUNNING = EVENT_MODE | STEP_MODE | CONTINUOUS_TIME_MODE,
    LOOKING = INITIALIZATION_MODE | RUNNING | TERMINATED
};

static const unsigned short ALLOWED[CALLS][2] = {
    /*                                     Co-Simulation          Model Exchange */
    [CALL_ANY_TIME]                     = {CALLED_BACK,            ANY},
    [CALL_NEW_STATE]                    = {ANY,                    ANY},
    [CALL_SET_UP_EXPERIMENT]            = {BEFORE_INITIALIZATION,  BEFORE_INITIALIZATION},
    [CALL_ENTER_INITIALIZATION]         = {SET_UP,                 SET_UP},
    [CALL_EXIT_INITIALIZATION]          = {INITIALIZATION_MODE,    INITIALIZATION_MODE},
    [CALL_SET_VARIABLES]                = {STARTING | RUNNING,     STARTING | RUNNING},
    [CALL_ENTER_EVENT_MODE]             = {STEP_MODE,              CONTINUOUS_TIME_MODE},
    [CALL_ENTER_EVENT_MODE_AGAIN]       = {NEVER,                  CONTINUOUS_TIME_MODE | EVENT_MODE},
    [CALL_UPDATE_DISCRETE_STATES]       = {EVENT_MODE,             EVENT_MODE},
    [CALL_ENTER_STEP_MODE]              = {EVENT_MODE,             NEVER},
    [CALL_STEP]                         = {STEP_MODE,              NEVER},
    [CALL_STEP_STATUS]                  = {ANY,                    NEVER},
    [CALL_ENTER_CONTINUOUS_TIME]        = {NEVER,                  EVENT_MODE},
    [CALL_SET_TIME]                     = {NEVER,                  CONTINUOUS_TIME_MODE},
    [CALL_SET_TIME_AFTER_EVENT]         = {NEVER,                  CONTINUOUS_TIME_MODE | EVENT_MODE},
    [CALL_SET_STATES]                   = {NEVER,                  CONTINUOUS_TIME_MODE},
    [CALL_COMPLETED_STEP]               = {NEVER,                  CONTINUOUS_TIME_MODE},
    [CALL_GET_CONTINUOUS]               = {NEVER,                  LOOKING | FAILED},
    [CALL_GET_SIZES]                    = {NEVER,                  ANY},
    [CALL_GET_DIRECTIONAL_DERIVATIVES]  = {LOOKING | INTERMEDIATE_UPDATE, LOOKING},
    [CALL_GET_OUTPUT_DERIVATIVES]       = {STEP_MODE | TERMINATED, NEVER},
    [CALL_TERMINATE]                    = {RUNNING,                RUNNING},
};

bool call_is_allowed(Call call, InterfaceType type, int mode)
{
    return (ALLOWED[call][type] & mode) != 0;
}

bool call_exists(Call call, InterfaceType type)
{
    return ALLOWED[call][type] != NEVER;
}
