/* SPDX-License-Identifier: MIT-0
 *
 * What the shells of all FMI versions share: errors, events, steps, saved states. A binary has one shell.
 *
 * An instance begins with its simulation, so that a pointer to one is a pointer to the other; what else it has, only
 * its shell knows. The simulation's log is where errors go, too. Status numbers are the same in all FMI versions.
 */
#ifndef COSIM_INSTANCE_H
#define COSIM_INSTANCE_H

#include <stdbool.h>

#include "simulation.h"

enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR };

/* The state of the instance as the end of a sentence that refuses a call; defined by the shell. */
const char *instance_mode_name(int mode);

/* The instantiation token; defined by the shell, the only part of an FMU's binary that differs with the FMI version. */
extern const char shell_token[];

/* FMI's category and status for a message. */
const char *log_category(LogKind kind);
int log_status(LogKind kind);

/* Report an error of the caller (the instance stays as it is) and return STATUS_ERROR. */
int instance_error(Simulation *m, const char *format, ...) PRINTF_LIKE(2, 3);

/* The simulation could not go on: report why and return STATUS_ERROR. */
int instance_failed(Simulation *m);

/* The simulation if the call is allowed now, else NULL after having said why not. */
Simulation *instance_entering(void *instance, Call call, const char *function);

/* Whether name and token are fit for a new instance, else after having said why not. */
bool instance_may_begin(Simulation *m, const char *name, const char *token, const char *function);

/* A new instance of `size` bytes with a simulation in its start state, or NULL. */
void *instance_new(size_t size, void (*log)(void *log_context, LogKind kind, const char *text), bool log_events);

/* Back to the start state, in this mode of FMI. */
void instance_begin(Simulation *m, InterfaceType type, int mode);

/* Log events if that is wanted for all categories or for theirs. */
int instance_log_events(Simulation *m, const char *function, bool on, size_t n, const char *const categories[]);

/* Take over start time, stop time and tolerance, unless they make no sense. */
bool instance_set_up(Simulation *m, bool has_tolerance, double tolerance, double start, bool has_stop, double stop);

/* Solve the initial equations if that has not happened yet. */
bool instance_initialise(Simulation *m);

/* What the model does when the simulation ends; false, with the reason logged, if it fails. */
bool instance_end(Simulation *m);

/* One event in Event Mode; a status. */
typedef struct {
    bool terminate, states_changed, has_next;
    double next; /* the next time event */
} Update;
int instance_update(Simulation *m, const char *function, Update *update);

/* Whether a step from t over h can be taken, else after having said why not. */
bool instance_accepts_step(Simulation *m, const char *function, double t, double h);

/* Advance to `to`; the clock ticks at the start take part, those at the end belong to the next step.
 * If stop_at_events, go no farther than to the next tick or state event. */
Advance instance_run(Simulation *m, double to, bool stop_at_events);

/* Copies of the state. Each returns a status. */
int instance_save(void *instance, const char *function, void **state);
int instance_restore(void *instance, const char *function, const void *state);
int instance_forget(void *instance, const char *function, void **state);
int instance_serialized_size(void *instance, const char *function, const void *state, size_t *size);
int instance_serialize(void *instance, const char *function, const void *state, void *bytes, size_t size);
int instance_deserialize(void *instance, const char *function, const void *bytes, size_t size, void **state);

#endif
