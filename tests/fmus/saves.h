/* SPDX-License-Identifier: MIT-0
 *
 * Saving and restoring the state of a test FMU: a copy of its model, with the instance's own way to the importer.
 */
#if FMI == 2
#define STATUS fmi2Status
#define INSTANCE fmi2Component
#define STATE fmi2FMUstate
#define BYTE fmi2Byte
#define NAME(two, three) fmi2##two
#else
#define STATUS fmi3Status
#define INSTANCE fmi3Instance
#define STATE fmi3FMUState
#define BYTE fmi3Byte
#define NAME(two, three) fmi3##three
#endif

STATUS NAME(GetFMUstate, GetFMUState)(INSTANCE c, STATE *state) {
    if (!*state) *state = malloc(sizeof(Model));
    memcpy(*state, c, sizeof(Model));
    return OK;
}
STATUS NAME(SetFMUstate, SetFMUState)(INSTANCE c, STATE state) {
    Model *m = c;
    void *const environment = m->environment, *const logger = m->logger;
    memcpy(m, state, sizeof(Model));
    m->environment = environment;
    m->logger = logger;
    return OK;
}
STATUS NAME(FreeFMUstate, FreeFMUState)(INSTANCE c, STATE *state) {
    free(*state);
    *state = NULL;
    return OK;
}
STATUS NAME(SerializedFMUstateSize, SerializedFMUStateSize)(INSTANCE c, STATE state, size_t *size) {
    *size = sizeof(Model);
    return OK;
}
STATUS NAME(SerializeFMUstate, SerializeFMUState)(INSTANCE c, STATE state, BYTE bytes[], size_t size) {
    AT("Serialize");
    Model model = *(Model *)state;
    model.environment = model.logger = NULL;
    memcpy(bytes, &model, size);
    return OK;
}
STATUS NAME(DeSerializeFMUstate, DeserializeFMUState)(INSTANCE c, const BYTE bytes[], size_t size, STATE *state) {
    if (size != sizeof(Model)) {
        say(c, "these bytes are no state");
        return ERROR;
    }
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return OK;
}
