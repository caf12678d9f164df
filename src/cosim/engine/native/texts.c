/* SPDX-License-Identifier: Apache-2.0
 *
 * Texts and Binary values: an FMU's own memory of one holds only until its next call, so they are copied.
 */
#include <stdlib.h>
#include <string.h>

static const Text *text_of(const Engine *engine, int64_t slot) {
    static const Text none = {"", 0, 0};
    const Text *text = &engine->texts[slot - engine->first_text];
    return text->bytes ? text : &none;
}

static bool keep(Text *text, const char *bytes, size_t size) {
    if (size >= text->room) {
        const size_t room = size < SIZE_MAX / 4 ? 2 * size + 16 : 0;
        char *grown = room ? realloc(text->bytes, room) : NULL;
        if (!grown) return false;
        text->bytes = grown;
        text->room = room;
    }
    memcpy(text->bytes, bytes, size);
    text->bytes[size] = '\0';
    text->size = size;
    return true;
}

/* A new text of a signal counts if it differs; false if there is no memory for it. */
static bool put_text(Engine *engine, int64_t slot, const char *bytes, size_t size) {
    Text *text = &engine->texts[slot - engine->first_text];
    if (!bytes) bytes = "", size = 0;
    if (text->bytes && text->size == size && memcmp(text->bytes, bytes, size) == 0) return true;
    engine->values[slot] += 1.0;
    return keep(text, bytes, size);
}

#if ONCE
/* The text that a signal has when the run begins. */
EXPORT bool cosim_set_text(Engine *engine, int64_t slot, const char *bytes, size_t size) {
    return keep(&engine->texts[slot - engine->first_text], bytes, size);
}

EXPORT void cosim_free_texts(Engine *engine) {
    for (int64_t i = 0; i < engine->n_values - engine->first_text; i++) {
        free(engine->texts[i].bytes);
        engine->texts[i] = (Text){0};
    }
}
#endif
