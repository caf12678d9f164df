/* SPDX-License-Identifier: MIT-0
 *
 * Saving, restoring and serialising the state of an instance.
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

#define ENTER                                                        \
    Simulation *m = instance_entering(instance, CALL_NEW_STATE, function); \
    if (!m) return STATUS_ERROR

int instance_save(void *instance, const char *function, void **state)
{
    ENTER;
    if (!state) return instance_error(m, "%s: FMUState is null.", function);
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return instance_error(m, "%s: out of memory.", function);
    memcpy(*state, &m->s, sizeof(State));
    return STATUS_OK;
}

int instance_restore(void *instance, const char *function, const void *state)
{
    ENTER;
    if (!state) return instance_error(m, "%s: FMUState is null.", function);
    if (((const State *)state)->type != m->s.type)
        return instance_error(m, "%s: the state is one of the other type, Co-Simulation or Model Exchange.", function);
    memcpy(&m->s, state, sizeof(State));
    m->tangent = TANGENT_UNKNOWN;
    m->have = 0;
    return STATUS_OK;
}

int instance_forget(void *instance, const char *function, void **state)
{
    ENTER;
    if (!state) return STATUS_OK;
    free(*state);
    *state = NULL;
    return STATUS_OK;
}

int instance_serialized_size(void *instance, const char *function, const void *state, size_t *size)
{
    ENTER;
    if (!state || !size) return instance_error(m, "%s: an argument is null.", function);
    *size = sizeof(Header) + sizeof(State);
    return STATUS_OK;
}

int instance_serialize(void *instance, const char *function, const void *state, void *bytes, size_t size)
{
    ENTER;
    if (!state || !bytes) return instance_error(m, "%s: an argument is null.", function);
    if (size < sizeof(Header) + sizeof(State))
        return instance_error(m, "%s: %zu bytes are too few, %zu are needed.", function, size,
                              sizeof(Header) + sizeof(State));
    Header header = {.size = sizeof(State), .token = hash(shell_token, strlen(shell_token))};
    memcpy(header.magic, MAGIC, sizeof header.magic);
    header.checksum = hash(state, sizeof(State));
    memcpy(bytes, &header, sizeof header);
    memcpy((char *)bytes + sizeof header, state, sizeof(State));
    return STATUS_OK;
}

int instance_deserialize(void *instance, const char *function, const void *bytes, size_t size, void **state)
{
    ENTER;
    if (!bytes || !state) return instance_error(m, "%s: an argument is null.", function);
    const char *content = (const char *)bytes + sizeof(Header);
    Header header;
    if (size >= sizeof header) memcpy(&header, bytes, sizeof header);
    if (size < sizeof header + sizeof(State) || memcmp(header.magic, MAGIC, sizeof header.magic) != 0 ||
        header.size != sizeof(State) || header.token != hash(shell_token, strlen(shell_token)))
        return instance_error(m, "%s: this is not a state of this build of %s.", function, MODEL_NAME);
    if (header.checksum != hash(content, sizeof(State)))
        return instance_error(m, "%s: the state is damaged (its checksum is wrong).", function);
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return instance_error(m, "%s: out of memory.", function);
    memcpy(*state, content, sizeof(State));
    return STATUS_OK;
}
