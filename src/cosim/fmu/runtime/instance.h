/* SPDX-License-Identifier: MIT-0
 *
 * An FMI 3.0 instance: a simulation, where it is in FMI's state machine, and the importer's callbacks.
 */
#ifndef COSIM_INSTANCE_H
#define COSIM_INSTANCE_H

#include "fmi3Functions.h"
#include "hybrid.h"

/* FMI's states; bits, so that a function can name all in which it is allowed. */
enum {
    INSTANTIATED = 1,
    INITIALIZATION_MODE = 2,
    EVENT_MODE = 4,
    STEP_MODE = 8,
    TERMINATED = 16,
    FAILED = 32, /* a step or an event has failed: only reset, restoring a state and looking are left */
    ANY_MODE = 63
};

typedef struct {
    Simulation sim;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log_message;
    bool event_mode_used, early_return_allowed;
} Instance;

/* The instance if the function is allowed now, else NULL after having said why not. */
Instance *instance_entering(fmi3Instance instance, int allowed_modes, const char *function);

/* Report an error of the caller (the instance stays as it is) and return fmi3Error. */
fmi3Status instance_error(Instance *i, const char *format, ...) PRINTF_LIKE(2, 3);

#endif
