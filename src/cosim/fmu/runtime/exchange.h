/* SPDX-License-Identifier: MIT-0
 *
 * Model Exchange, whatever the FMI version: the importer integrates, the model tells derivatives and event indicators.
 *
 * The continuous states are the MODEL_NX states x of v, in this order, for the whole life of an instance. The algebraic
 * unknowns z are solved for wherever something that depends on them is asked for, from those of the last completed
 * step: an importer's trial points leave no trace.
 *
 * The functions return a status; those that compute something return STATUS_DISCARD where the equations have no solution,
 * so that the importer can try a smaller step.
 */
#ifndef COSIM_EXCHANGE_H
#define COSIM_EXCHANGE_H

#include "instance.h"

size_t exchange_indicators(void);

int exchange_set_time(Simulation *m, const char *function, double t);
int exchange_set_states(Simulation *m, const char *function, const double *x, size_t n);
int exchange_get_states(Simulation *m, const char *function, double *x, size_t n);
int exchange_get_nominals(Simulation *m, const char *function, double *nominals, size_t n);
int exchange_get_derivatives(Simulation *m, const char *function, double *derivatives, size_t n);
int exchange_get_indicators(Simulation *m, const char *function, double *z, size_t n);

/* The point that the instance is at is part of the solution. */
int exchange_complete_step(Simulation *m, const char *function);

/* The importer has found an event, or wants to change inputs. */
int exchange_enter_event_mode(Simulation *m, const char *function);
int exchange_enter_continuous_time_mode(Simulation *m, const char *function);

#endif
