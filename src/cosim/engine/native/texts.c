/* SPDX-License-Identifier: Apache-2.0
 *
 * Texts: an FMU's own memory of one holds only until its next call, so they are copied.
 */
#include <stdlib.h>
#include <string.h>

static const char *text_of(const Engine *engine, int64_t slot) {
    const char *bytes = engine->texts[slot - engine->first_text].bytes;
    return bytes ? bytes : "";
}

static bool keep(Text *text, const char *bytes) {
    const size_t size = strlen(bytes) + 1;
    if (size > text->room) {
        char *grown = realloc(text->bytes, 2 * size);
        if (!grown) return false;
        text->bytes = grown;
        text->room = 2 * size;
    }
    memcpy(text->bytes, bytes, size);
    return true;
}

/* A new text of a signal counts if it differs; false if there is no memory for it. */
static bool put_text(Engine *engine, int64_t slot, const char *bytes) {
    Text *text = &engine->texts[slot - engine->first_text];
    const char *given = bytes ? bytes : "";
    if (text->bytes && strcmp(text->bytes, given) == 0) return true;
    engine->values[slot] += 1.0;
    return keep(text, given);
}

/* The text that a signal has when the run begins. */
EXPORT bool cosim_set_text(Engine *engine, int64_t slot, const char *bytes) {
    return keep(&engine->texts[slot - engine->first_text], bytes);
}

EXPORT void cosim_free_texts(Engine *engine) {
    for (int64_t i = 0; i < engine->n_values - engine->first_text; i++) {
        free(engine->texts[i].bytes);
        engine->texts[i] = (Text){0};
    }
}
