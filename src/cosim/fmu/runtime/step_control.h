/* SPDX-License-Identifier: MIT-0
 *
 * Step sizes for a method of order 5 with an error estimate of order 4.
 */
#ifndef COSIM_STEP_CONTROL_H
#define COSIM_STEP_CONTROL_H

/* The memory of the step size control. */
typedef struct {
    double h;              /* to be tried next, 0 = not known */
    double h_accepted;     /* the last accepted step, 0 = none since the last discontinuity */
    double error_accepted; /* and its error */
    int rejected;          /* the last attempt was rejected */
} StepControl;

/* Learn from an attempt with the step h, which is control->h unless it had to be cut. */
void control_accept(StepControl *control, double h, double error);
void control_reject(StepControl *control, double h, double error);

/* Forget what was learnt about the solution's smoothness. */
void control_restart(StepControl *control);

#endif
