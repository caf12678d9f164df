/* SPDX-License-Identifier: Apache-2.0
 *
 * The engine is one translation unit, so that the compiler sees through all calls of its inner loop but those of the
 * FMUs; this file is what is compiled, and once more each in watched.c and plain.c.
 */
#ifndef WATCHED
#define WATCHED 0
#endif
#ifndef PLAIN
#define PLAIN 0
#endif
#define ONCE (!WATCHED && !PLAIN)
#define ANY(count) (!PLAIN && (count) > 0)
#define _XOPEN_SOURCE 700
#include "engine.h"

/* The record of why a run ended early; Python makes the message of it. */
RARE bool fail(Engine *engine, const Component *component, FailureKind kind) {
    engine->failure.kind = kind;
    engine->failure.component = component->number;
    return false;
}

/* The FMU may take the process down in any call: whoever looks after it finds out in which. */
OFTEN void enter(Engine *engine, const Component *component, CalledFunction function) {
    if (WATCHED) engine->at.call = (Call){component->number, (int32_t)function};
}

#include "texts.c"
#include "channels.c"
#include "wires.c"
#include "signal_faults.c"
#include "access.c"
#include "component.c"
#include "power.c"
#include "record.c"
#include "coupling.c"
#include "agreement.c"
#include "adaptive.c"
#include "advance.c"
#include "loop.c"
#if ONCE
#include "exchange_calls.c"
#include "exchange_rodas.c"
#include "exchange_roots.c"
#include "exchange_steps.c"
#include "exchange.c"
#include "exchange_access.c"
#include "exchange_state.c"
#include "step_control.c"
#include "faults.c"
#endif
