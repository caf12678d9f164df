/* SPDX-License-Identifier: Apache-2.0
 *
 * The energy that goes over power connections, as both sides see it: cosim/engine/coupling/_power_meter.py has the equations.
 */
static void begin_power(const Engine *engine) {
    for (const Bond *bond = engine->bonds; bond < engine->bonds + engine->n_bonds; bond++) {
        bond->start[0] = engine->values[bond->effort];
        bond->start[1] = engine->values[bond->flow];
    }
}

/* Add what went over: after a macro step of h, while the inputs are still what was held. */
static void end_power(const Engine *engine, double h) {
    for (const Bond *bond = engine->bonds; bond < engine->bonds + engine->n_bonds; bond++) {
        const double effort = 0.5 * (bond->start[0] + engine->values[bond->effort]);
        const double flow = 0.5 * (bond->start[1] + engine->values[bond->flow]);
        const double held_effort = (*bond->held_effort - bond->effort_offset) / bond->effort_factor;
        const double held_flow = (*bond->held_flow - bond->flow_offset) / bond->flow_factor;
        const double given = bond->watts * effort * held_flow * h;
        const double taken = bond->watts * held_effort * flow * h;
        bond->energies[0] += given;
        bond->energies[1] += taken;
        bond->energies[2] += 0.5 * (fabs(given) + fabs(taken));
    }
    begin_power(engine); /* of the next step */
}
