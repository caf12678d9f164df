/* SPDX-License-Identifier: Apache-2.0
 *
 * The loop again, as `cosim_run_plain`: for runs without faults, power connections, coupled algorithms, divided
 * intervals and pauses, which pay nothing for what they do not use.
 */
#define PLAIN 1
#include "engine.c"
