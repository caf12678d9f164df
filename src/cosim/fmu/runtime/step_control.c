/* SPDX-License-Identifier: MIT-0 */
#include "step_control.h"

#include <math.h>

/* Gustafsson's predictive controller with the limits of Hairer's code. */
static const double SAFETY = 0.9, MOST_GROWTH = 6.0, MOST_SHRINKAGE = 0.2;

static double limited(double factor)
{
    return fmin(MOST_GROWTH, fmax(MOST_SHRINKAGE, factor));
}

void control_accept(StepControl *control, double h, double error)
{
    double factor = limited(SAFETY * pow(error, -0.2));
    if (h < control->h) {
        /* Cut to end where it had to. If that was far too short for its error, it says nothing of the longer step. */
        control->h = factor < MOST_GROWTH ? h * factor : fmax(control->h, h * factor);
        control_restart(control);
        return;
    }
    if (control->h_accepted > 0.0) {
        double predicted = SAFETY * (h / control->h_accepted) * pow(control->error_accepted / (error * error), 0.2);
        factor = fmin(factor, limited(predicted));
    }
    if (control->rejected) factor = fmin(factor, 1.0);
    control->h = h * factor;
    control->h_accepted = h;
    control->error_accepted = fmax(1e-2, error);
    control->rejected = 0;
}

void control_reject(StepControl *control, double h, double error)
{
    control->h = h * (isfinite(error) ? limited(SAFETY * pow(error, -0.2)) : MOST_SHRINKAGE);
    control->rejected = 1;
}

void control_restart(StepControl *control)
{
    control->h_accepted = 0.0;
    control->rejected = 0;
}
