/* Random sequences of FMI calls, right and wrong ones, against what the standard says of each.
 *
 * A subject is an instance and what the driver knows of it, from its own reading of the standard: in which state it is,
 * at what time, and how far it may go back. A call that is wrong has to return an error, say why, and change nothing; a
 * call that is right has to work. Nothing but making instances and copies of their state may take memory.
 */
#ifndef FUZZ_H
#define FUZZ_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "model.h"

/* Names of the states that are this driver's own; all in one string for a function. */
enum { INSTANTIATED = 'I', SET_UP = 'U', INITIALIZING = 'N', EVENT = 'E', STEP = 'S', CONTINUOUS = 'C', ENDED = 'T',
       BROKEN = 'B' };
#define ALWAYS "IUNESCTB"

typedef struct {
    char state;
    double t, stop;
    double earliest, completed[2]; /* Model Exchange: the last event, the last two completed steps */
    double next;                   /* the next time event */
    bool touched;                  /* something was set since the last update of discrete states */
} Known;

typedef struct {
    void *fmu;
    bool exchange, events, early, logs;
    Known known;
    long said; /* messages so far */
} Subject;

extern Subject *subject; /* of the present call */
void hear(Subject *s, const char *message); /* the log's callback */
extern bool forgiving;   /* the model itself may fail at any time */

/* A right call is one in a state of this type's string, with right arguments. */
bool right(const char *co_simulation, const char *exchange, bool arguments);

/* Look at the status of a call that is right or wrong; tells whether it worked. `may_fail`: a right one need not work. */
bool judge(const char *function, bool is_right, bool may_fail, int status);

/* The same for calls that compute values before they come to what is wrong. */
bool judge_reading(const char *function, bool is_right, bool may_fail, int status);
void judge_instance(bool is_right, const void *fmu);

/* Random numbers. */
unsigned below(unsigned n);
bool chance(double probability);
double between(double low, double high);
double weird(void);
/* Nothing, now and then, in place of a pointer, noting that the call is wrong with it. */
void *perhaps(void *pointer, bool *fine);
size_t perhaps_other(size_t n, bool *fine);

/* What each version of FMI has in its own words. */
void *make(Subject *s); /* NULL if it was asked for in a wrong way */
void unmake(Subject *s);
typedef struct {
    const char *name;
    int (*enter_event_mode)(void *fmu);
    int (*enter_continuous_time_mode)(void *fmu);
    int (*exit_initialization)(void *fmu);
    int (*set_time)(void *fmu, double t);
    int (*set_states)(void *fmu, const double *x, size_t n);
    int (*get_states)(void *fmu, double *x, size_t n);
    int (*get_derivatives)(void *fmu, double *x, size_t n);
    int (*get_indicators)(void *fmu, double *z, size_t n);
    int (*get_nominals)(void *fmu, double *x, size_t n);
    int (*complete_step)(void *fmu, bool missing);
    /* Sets whether there is a next event, and when. */
    int (*update)(void *fmu, bool missing, bool *defined, double *next);
    int (*terminate)(void *fmu);
    int (*reset)(void *fmu);
    int (*log)(void *fmu, size_t n, const char *const *categories);
    int (*save)(void *fmu, void **state);
    int (*restore)(void *fmu, void *state);
    int (*forget)(void *fmu, void **state);
    int (*size)(void *fmu, void *state, size_t *size);
    int (*serialize)(void *fmu, void *state, unsigned char *bytes, size_t size);
    int (*deserialize)(void *fmu, const unsigned char *bytes, size_t size, void **state);
    /* In which states of Model Exchange they are allowed. */
    const char *event_mode_from, *time_from;
    bool states_in_event_mode;
} Fmi;
extern const Fmi fmi;

/* One call of any kind; takes part in the choice by weight. */
typedef struct {
    unsigned weight;
    void (*call)(void);
} Choice;
extern const Choice own_choices[], common_choices[];
extern const size_t n_own, n_common;
void forget_copies(void);
size_t whole_state(void *fmu, unsigned char *bytes, size_t room);
void memory_may_be_taken(void);
long memory_living(long change);

/* Common to both versions of FMI. */
bool settable(const ModelVariable *variable, double value);
bool gettable(const ModelVariable *variable);
double value_for(unsigned reference, bool *fine);
size_t references(unsigned types, unsigned room, unsigned *chosen, bool *fine);

#define ROOM 4
#define TYPES(type) (1u << (type))

#endif
