/* SPDX-License-Identifier: Apache-2.0
 *
 * Between the signals and the FMUs: inputs are set if they have changed, outputs are read if somebody takes them.
 */
typedef Status (*Access2)(void *, const ValueReference *, size_t, void *);
typedef Status (*Access3)(void *, const ValueReference *, size_t, void *, size_t);
typedef Status (*AccessBinary)(void *, const ValueReference *, size_t, size_t *, void *, size_t);

RARE bool refused(Engine *engine, const Component *component, const Group *group, Status status) {
    engine->failure.function = ACCESS;
    engine->failure.group = group->number;
    engine->failure.status = status;
    return fail(engine, component, CALL_FAILED);
}

OFTEN bool call(Engine *engine, const Component *component, const Group *group, const Extent *extent) {
    const size_t n = (size_t)extent->references, n_values = (size_t)extent->values;
    void *const instance = component->instance;
    if (WATCHED) engine->at.call = group->call;
    const ValueReference *const references = group->references;
    const Status status =
        component->fmi < 3 ? ((Access2)group->access)(instance, references, n, group->memory)
        : group->type == BINARY
            ? ((AccessBinary)group->access)(instance, references, n, group->sizes, group->memory, n_values)
            : ((Access3)group->access)(instance, references, n, group->memory, n_values);
    return status < FAILED || refused(engine, component, group, status);
}

/* Fractions are cut off before the range is looked at, as int() does. The limits are written so that they are exact. */
#define STORE(type, lowest, beyond)                                                                  \
    for (int64_t i = 0; i < count; i++) {                                                            \
        const double given = group->doubles[i], whole = trunc(given);                                \
        if (!(whole >= (lowest) && whole < (beyond))) return does_not_fit(engine, component, group, given); \
        ((type *)group->memory)[i] = (type)whole;                                                    \
    }                                                                                                \
    return true

RARE bool does_not_fit(Engine *engine, const Component *component, const Group *group, double value) {
    engine->failure.group = group->number;
    engine->failure.value = value;
    return fail(engine, component, OUT_OF_RANGE);
}

static bool store_binaries(Engine *engine, const Component *component, const Group *group) {
    for (int64_t i = 0; i < group->extents[WHOLE].values; i++) {
        const Text *text = text_of(engine, group->wires[i].source);
        if (text->size > group->limits[i]) return does_not_fit(engine, component, group, (double)text->size);
        ((const char **)group->memory)[i] = text->bytes;
        group->sizes[i] = text->size;
    }
    return true;
}

static bool store(Engine *engine, const Component *component, const Group *group) {
    const int64_t count = group->extents[WHOLE].values;
    switch ((Type)group->type) {
        case FLOAT64: return true;
        case FLOAT32:
            for (int64_t i = 0; i < count; i++) ((float *)group->memory)[i] = (float)group->doubles[i];
            return true;
        case INT8: STORE(int8_t, -0x1p7, 0x1p7);
        case UINT8: STORE(uint8_t, 0.0, 0x1p8);
        case INT16: STORE(int16_t, -0x1p15, 0x1p15);
        case UINT16: STORE(uint16_t, 0.0, 0x1p16);
        case INT32: STORE(int32_t, -0x1p31, 0x1p31);
        case UINT32: STORE(uint32_t, 0.0, 0x1p32);
        case INT64: STORE(int64_t, -0x1p63, 0x1p63);
        case UINT64: STORE(uint64_t, 0.0, 0x1p64);
        case TEXT:
            for (int64_t i = 0; i < count; i++) {
                ((const char **)group->memory)[i] = text_of(engine, group->wires[i].source)->bytes;
            }
            return true;
        case BINARY: return store_binaries(engine, component, group);
    }
    return true;
}

#define LOAD(type)                                                                                       \
    for (int64_t i = 0; i < count; i++) group->doubles[i] = (double)((const type *)group->memory)[i]; \
    break

static bool load_texts(Engine *engine, const Component *component, const Group *group, int64_t count) {
    const int64_t first = group->doubles - engine->values;
    for (int64_t i = 0; i < count; i++) {
        const char *bytes = ((const char *const *)group->memory)[i];
        const size_t size = group->type == BINARY ? group->sizes[i] : bytes ? strlen(bytes) : 0;
        if (!put_text(engine, first + i, bytes, size)) return fail(engine, component, OUT_OF_MEMORY);
    }
    return true;
}

static bool load(Engine *engine, const Component *component, const Group *group, int64_t count) {
    switch ((Type)group->type) {
        case FLOAT64: break;
        case FLOAT32: LOAD(float);
        case INT8: LOAD(int8_t);
        case UINT8: LOAD(uint8_t);
        case INT16: LOAD(int16_t);
        case UINT16: LOAD(uint16_t);
        case INT32: LOAD(int32_t);
        case UINT32: LOAD(uint32_t);
        case INT64: LOAD(int64_t);
        case UINT64: LOAD(uint64_t);
        case TEXT:
        case BINARY: return load_texts(engine, component, group, count);
    }
    return true;
}

/* Doubles are set and read where they lie. */
OFTEN bool write_inputs(Engine *engine, const Component *component) {
    if (ANY(component->n_faulty)) refresh(engine, component->faulty, component->n_faulty);
    const double *const values = engine->values;
    const Group *const end = component->inputs + component->n_inputs;
    for (const Group *group = component->inputs; group < end; group++) {
        const Extent *extent = &group->extents[WHOLE];
        bool changed = false;
        for (int64_t i = 0; i < extent->values; i++) {
            const double value = handed_on(&group->wires[i], values);
            if (value != group->doubles[i]) {
                group->doubles[i] = value;
                changed = true;
            }
        }
        if (!changed) continue;
        if (group->type != FLOAT64 && !store(engine, component, group)) return false;
        if (!call(engine, component, group, extent)) return false;
    }
    return true;
}

OFTEN bool read_outputs(Engine *engine, Component *component, bool recording) {
    int strange = 0;
    const Group *const end = component->outputs + component->n_outputs[recording];
    for (const Group *group = component->outputs; group < end; group++) {
        const Extent *extent = &group->extents[recording];
        if (!call(engine, component, group, extent)) return false;
        if (group->type != FLOAT64 && !load(engine, component, group, extent->values)) return false;
        if (group->type <= FLOAT32) {
            for (int64_t i = 0; i < extent->values; i++) strange |= isnan(group->doubles[i]);
        }
    }
    engine->not_a_number |= strange;
    component->stale = !recording;
    return true;
}

/* Read the texts and Binary outputs that somebody takes, and nothing else. */
static bool read_texts(Engine *engine, const Component *component) {
    const Group *const end = component->outputs + component->n_outputs[false];
    for (const Group *group = component->outputs; group < end; group++) {
        if (group->type != TEXT && group->type != BINARY) continue;
        const Extent *extent = &group->extents[false];
        if (!call(engine, component, group, extent) || !load(engine, component, group, extent->values)) return false;
    }
    return true;
}

static inline bool triggered(Engine *engine, const Component *component) {
    if (component->n_triggers > 0 && ANY(component->n_faulty)) refresh(engine, component->faulty, component->n_faulty);
    for (int64_t i = 0; i < component->n_triggers; i++) {
        const Trigger *trigger = &component->triggers[i];
        if (handed_on(&trigger->wire, engine->values) != *trigger->input) return true;
    }
    return false;
}
