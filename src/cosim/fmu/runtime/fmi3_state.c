/* SPDX-License-Identifier: MIT-0
 *
 * FMI 3.0: saving, restoring and serialising the state of an instance.
 */
#include <stdlib.h>
#include <string.h>

#include "instance.h"

/* A serialised state is this and the State itself; only the build that wrote it can read it. */
typedef struct {
    char magic[8];
    uint64_t size;
    uint64_t token;
    uint64_t checksum;
} Header;

static const char MAGIC[8] = "cosim3s";

/* FNV-1a */
static uint64_t hash(const void *data, size_t size)
{
    const unsigned char *bytes = data;
    uint64_t value = UINT64_C(14695981039346656037);
    for (size_t k = 0; k < size; k++) value = (value ^ bytes[k]) * UINT64_C(1099511628211);
    return value;
}

#define ENTER                                                      \
    Instance *i = instance_entering(instance, ANY_MODE, __func__); \
    if (!i) return fmi3Error

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ENTER;
    if (!FMUState) return instance_error(i, "fmi3GetFMUState: FMUState is null.");
    if (!*FMUState) *FMUState = malloc(sizeof(State));
    if (!*FMUState) return instance_error(i, "fmi3GetFMUState: out of memory.");
    memcpy(*FMUState, &i->sim.s, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    ENTER;
    if (!FMUState) return instance_error(i, "fmi3SetFMUState: FMUState is null.");
    memcpy(&i->sim.s, FMUState, sizeof(State));
    i->sim.have = 0;
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ENTER;
    if (!FMUState) return fmi3OK;
    free(*FMUState);
    *FMUState = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    ENTER;
    if (!FMUState || !size) return instance_error(i, "fmi3SerializedFMUStateSize: an argument is null.");
    *size = sizeof(Header) + sizeof(State);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    ENTER;
    if (!FMUState || !serializedState) return instance_error(i, "fmi3SerializeFMUState: an argument is null.");
    if (size < sizeof(Header) + sizeof(State))
        return instance_error(i, "fmi3SerializeFMUState: %zu bytes are too few, %zu are needed.", size,
                              sizeof(Header) + sizeof(State));
    Header header = {.size = sizeof(State), .token = hash(MODEL_TOKEN, strlen(MODEL_TOKEN))};
    memcpy(header.magic, MAGIC, sizeof header.magic);
    header.checksum = hash(FMUState, sizeof(State));
    memcpy(serializedState, &header, sizeof header);
    memcpy(serializedState + sizeof header, FMUState, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState)
{
    ENTER;
    if (!serializedState || !FMUState) return instance_error(i, "fmi3DeserializeFMUState: an argument is null.");
    Header header;
    if (size >= sizeof header) memcpy(&header, serializedState, sizeof header);
    if (size < sizeof header + sizeof(State) || memcmp(header.magic, MAGIC, sizeof header.magic) != 0 ||
        header.size != sizeof(State) || header.token != hash(MODEL_TOKEN, strlen(MODEL_TOKEN)))
        return instance_error(i, "fmi3DeserializeFMUState: this is not a state of this build of %s.", MODEL_NAME);
    if (header.checksum != hash(serializedState + sizeof header, sizeof(State)))
        return instance_error(i, "fmi3DeserializeFMUState: the state is damaged (its checksum is wrong).");
    if (!*FMUState) *FMUState = malloc(sizeof(State));
    if (!*FMUState) return instance_error(i, "fmi3DeserializeFMUState: out of memory.");
    memcpy(*FMUState, serializedState + sizeof header, sizeof(State));
    return fmi3OK;
}
