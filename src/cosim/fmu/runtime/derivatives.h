/* SPDX-License-Identifier: MIT-0
 *
 * Directional and adjoint derivatives at the present instant, exact, with the algebraic unknowns eliminated.
 *
 * After initialisation, unknowns are functions of time, states, inputs and parameters; in Initialization Mode of time,
 * inputs and parameters, through the initial equations. Discrete variables and relations keep their values.
 */
#ifndef COSIM_DERIVATIVES_H
#define COSIM_DERIVATIVES_H

#include "simulation.h"

/* Rates or weights of everything that derivatives are taken of or by. v: of the knowns only states count. */
typedef struct {
    double t, v[MODEL_ROOM(MODEL_NV)], u[MODEL_ROOM(MODEL_NU)], p[MODEL_ROOM(MODEL_NP)];
} Knowns;
typedef struct {
    Knowns same; /* unknowns that are knowns, or algebraic unknowns, themselves */
    double f[MODEL_ROOM(MODEL_NV)], y[MODEL_ROOM(MODEL_NY)];
} Unknowns;

/* The rates of the unknowns from those of t, states and inputs; only after initialisation. p has to be at rest. */
int simulation_forward(Simulation *m, const Knowns *rates, Unknowns *result);

/* The weights of the knowns from those of the unknowns; initial says which knowns and equations. */
int simulation_reverse(Simulation *m, int initial, const Unknowns *weights, Knowns *result);

/* For the shells. Each returns a status; every reference is a position in model_variables. */
int derivatives_forward(Simulation *m, const char *function, const unsigned *unknowns, size_t n_unknowns,
                        const unsigned *knowns, size_t n_knowns, const double *seed, double *sensitivity);
int derivatives_adjoint(Simulation *m, const char *function, const unsigned *unknowns, size_t n_unknowns,
                        const unsigned *knowns, size_t n_knowns, const double *seed, double *sensitivity);
/* d/dt of outputs while inputs stand still. */
int derivatives_in_time(Simulation *m, const char *function, const unsigned *references, size_t n, const int *orders,
                        double *values);

#endif
