/* SPDX-License-Identifier: MIT-0
 *
 * A PI controller of the crank's speed, computed every 10 ms. What both FMI shells have in common.
 */
#ifndef CONTROLLER_H
#define CONTROLLER_H

#include <stdbool.h>

#define TOKEN "SpeedController-1"
#define PERIOD 0.01 /* [s] */

/* Value references. */
enum { TIME, W_CRANK, W_REF, K_P, K_I, DUTY, ERROR_SUM, N_VALUES };

typedef struct {
    double values[N_VALUES];
    void (*say)(void *environment, const char *text); /* hands a message to the importer */
    void *environment;
    void (*logger)(void); /* of the FMI version's type */
    bool initialized;
} Controller;

/* A new controller with its start values; NULL without memory. Free it with free(). */
Controller *controller_new(const char *token);

/* Tell whether a variable may be set now. */
bool controller_settable(const Controller *c, unsigned reference);

/* Compute the sample at t [s], whose output holds until t + h [s]. False, with a message, unless h is PERIOD. */
bool controller_step(Controller *c, double t, double h);

#endif
