/* SPDX-License-Identifier: Apache-2.0
 *
 * The record of why a run ended early; Python makes the message of it.
 */
#include "engine.h"

bool fail(Engine *engine, const Component *component, FailureKind kind) {
    engine->failure.kind = kind;
    engine->failure.component = component->number;
    return false;
}
