/* SPDX-License-Identifier: Apache-2.0
 *
 * The loop again, as `cosim_run_watched`: it writes down each call, for a run that another process looks after. What
 * that takes, a few percent of the least step there is, the other one does not pay.
 */
#define WATCHED 1
#include "engine.c"
