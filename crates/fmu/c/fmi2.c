/* ---- FMI 2.0: the declarations of its binary interface, then its functions ------------------------------------ */

#include <stddef.h>
#include <stdlib.h>

#if defined _WIN32
#define FMI_EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define FMI_EXPORT __attribute__((visibility("default")))
#else
#define FMI_EXPORT
#endif

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef void (*fmi2CallbackLogger)(void *, const char *, fmi2Status, const char *, const char *, ...);
typedef struct {
    fmi2CallbackLogger logger;
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(void *, fmi2Status);
    void *componentEnvironment;
} fmi2CallbackFunctions;
typedef struct {
    int newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged;
    int valuesOfContinuousStatesChanged, nextEventTimeDefined;
    double nextEventTime;
} fmi2EventInfo;
typedef unsigned int fmi2ValueReference;

#define FMI2_STATUS FMI_EXPORT fmi2Status
#define BK_UNIT bk_unit *u = (bk_unit *)c

static void bk_say2(const bk_unit *u, const char *text) {
    fmi2CallbackLogger log;
    memcpy(&log, u->callbacks, sizeof log);
    if (log) {
        log(u->environment, BK_IDENTIFIER, fmi2Error, "logStatusError", "%s", text);
    }
}

static fmi2Status bk_status2(const bk_unit *u, int fault) {
    return bk_fails(u, fault) ? fmi2Error : fmi2OK;
}

FMI_EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI_EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

FMI2_STATUS fmi2SetDebugLogging(void *c, int on, size_t n, const char *const categories[]) {
    (void)c; (void)on; (void)n; (void)categories;
    return fmi2OK;
}

FMI_EXPORT void *fmi2Instantiate(const char *name, fmi2Type type, const char *guid, const char *resources,
                                 const fmi2CallbackFunctions *functions, int visible, int logs) {
    bk_unit *u;
    (void)name; (void)resources; (void)visible; (void)logs;
    if (!guid || strcmp(guid, BK_TOKEN) != 0) {
        if (functions && functions->logger) {
            functions->logger(functions->componentEnvironment, BK_IDENTIFIER, fmi2Error, "logStatusError",
                              "the GUID is of another unit");
        }
        return NULL;
    }
    u = (bk_unit *)calloc(1, sizeof *u);
    if (u) {
        u->is_exchange = type == fmi2ModelExchange;
        u->say = bk_say2;
        if (functions) {
            u->environment = functions->componentEnvironment;
            memcpy(u->callbacks, &functions->logger, sizeof functions->logger);
        }
        bk_begin(u);
    }
    return u;
}

FMI_EXPORT void fmi2FreeInstance(void *c) { free(c); }

FMI2_STATUS fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop,
                                double stop) {
    BK_UNIT;
    (void)has_stop; (void)stop;
    if (u->m.s.phase != BK_INSTANTIATED) {
        return bk_status2(u, -1);
    }
    if (has_tolerance && tolerance > 0.0) {
        u->m.s.tolerance = fmin(fmax(tolerance, 1e-12), 1e-2);
    }
    u->m.s.t_start = start;
    u->m.s.is_stale = 1;
    return fmi2OK;
}

FMI2_STATUS fmi2EnterInitializationMode(void *c) {
    BK_UNIT;
    if (u->m.s.phase != BK_INSTANTIATED) {
        return bk_status2(u, -1);
    }
    u->m.s.phase = BK_INITIALIZATION;
    return fmi2OK;
}

FMI2_STATUS fmi2ExitInitializationMode(void *c) {
    BK_UNIT;
    const int found = u->m.s.phase == BK_INITIALIZATION ? bk_start_unit(u) : -1;
    if (found == BK_OK) {
        u->m.s.phase = u->is_exchange ? BK_EVENT : BK_STEP;
    }
    return bk_status2(u, found);
}

FMI2_STATUS fmi2Terminate(void *c) {
    BK_UNIT;
    u->m.s.phase = BK_TERMINATED;
    return fmi2OK;
}

FMI2_STATUS fmi2Reset(void *c) {
    BK_UNIT;
    bk_begin(u);
    return fmi2OK;
}

FMI2_STATUS fmi2GetReal(void *c, const fmi2ValueReference vr[], size_t n, double values[]) {
    BK_UNIT;
    size_t i;
    int found = BK_OK;
    for (i = 0; i < n && found == BK_OK; i++) {
        found = bk_get(u, vr[i], values + i);
    }
    return bk_status2(u, found);
}

FMI2_STATUS fmi2SetReal(void *c, const fmi2ValueReference vr[], size_t n, const double values[]) {
    BK_UNIT;
    size_t i;
    int found = BK_OK;
    for (i = 0; i < n && found == BK_OK; i++) {
        found = bk_put(u, vr[i], values[i]);
    }
    return bk_status2(u, found);
}

/* There are no variables of other types. */
#define BK_NONE(name, type)                                                                        \
    FMI2_STATUS fmi2Get##name(void *c, const fmi2ValueReference vr[], size_t n, type values[]) {   \
        (void)c; (void)vr; (void)values;                                                           \
        return n == 0 ? fmi2OK : fmi2Error;                                                        \
    }                                                                                              \
    FMI2_STATUS fmi2Set##name(void *c, const fmi2ValueReference vr[], size_t n, const type values[]) { \
        (void)c; (void)vr; (void)values;                                                           \
        return n == 0 ? fmi2OK : fmi2Error;                                                        \
    }
typedef const char *bk_text;
BK_NONE(Integer, int)
BK_NONE(Boolean, int)
BK_NONE(String, bk_text)

FMI2_STATUS fmi2GetFMUstate(void *c, void **state) {
    BK_UNIT;
    if (!*state) {
        *state = malloc(sizeof u->m.s);
    }
    if (!*state) {
        return fmi2Error;
    }
    memcpy(*state, &u->m.s, sizeof u->m.s);
    return fmi2OK;
}

FMI2_STATUS fmi2SetFMUstate(void *c, void *state) {
    BK_UNIT;
    if (!state) {
        return bk_status2(u, -1);
    }
    memcpy(&u->m.s, state, sizeof u->m.s);
    return fmi2OK;
}

FMI2_STATUS fmi2FreeFMUstate(void *c, void **state) {
    (void)c;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

FMI2_STATUS fmi2SerializedFMUstateSize(void *c, void *state, size_t *size) {
    (void)c; (void)state;
    *size = sizeof(bk_state);
    return fmi2OK;
}

FMI2_STATUS fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size) {
    (void)c;
    if (!state || size != sizeof(bk_state)) {
        return fmi2Error;
    }
    memcpy(bytes, state, size);
    return fmi2OK;
}

FMI2_STATUS fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state) {
    (void)c;
    if (size != sizeof(bk_state)) {
        return fmi2Error;
    }
    if (!*state) {
        *state = malloc(size);
    }
    if (!*state) {
        return fmi2Error;
    }
    memcpy(*state, bytes, size);
    return fmi2OK;
}

FMI2_STATUS fmi2GetDirectionalDerivative(void *c, const fmi2ValueReference unknowns[], size_t n_unknowns,
                                         const fmi2ValueReference knowns[], size_t n_knowns, const double seed[],
                                         double out[]) {
    BK_UNIT;
    return bk_status2(u, bk_direction(u, unknowns, n_unknowns, knowns, n_knowns, seed, out));
}

FMI2_STATUS fmi2EnterEventMode(void *c) {
    BK_UNIT;
    u->m.s.phase = BK_EVENT;
    return fmi2OK;
}

FMI2_STATUS fmi2NewDiscreteStates(void *c, fmi2EventInfo *info) {
    BK_UNIT;
    int is_moved = 0;
    const int found = bk_update(u, &is_moved);
    info->newDiscreteStatesNeeded = 0;
    info->terminateSimulation = 0;
    info->nominalsOfContinuousStatesChanged = 0;
    info->valuesOfContinuousStatesChanged = is_moved;
    info->nextEventTimeDefined = found == BK_OK && bk_next_time(u, &info->nextEventTime);
    return bk_status2(u, found);
}

FMI2_STATUS fmi2EnterContinuousTimeMode(void *c) {
    BK_UNIT;
    u->m.s.phase = BK_CONTINUOUS;
    return fmi2OK;
}

FMI2_STATUS fmi2CompletedIntegratorStep(void *c, int no_earlier, int *enter, int *ends) {
    BK_UNIT;
    const int found = bk_complete_step(u, enter);
    (void)no_earlier;
    *ends = 0;
    return bk_status2(u, found);
}

FMI2_STATUS fmi2SetTime(void *c, double t) {
    BK_UNIT;
    if (u->m.s.t != t) {
        u->m.s.t = t;
        u->m.s.is_stale = 1;
    }
    return fmi2OK;
}

FMI2_STATUS fmi2SetContinuousStates(void *c, const double x[], size_t n) {
    BK_UNIT;
    if (n != BK_NX) {
        return bk_status2(u, -1);
    }
    bk_copy(u->m.s.x, x, BK_NX);
    u->m.s.is_stale = 1;
    return fmi2OK;
}

FMI2_STATUS fmi2GetDerivatives(void *c, double dx[], size_t n) {
    BK_UNIT;
    return bk_status2(u, n == BK_NX ? bk_state_rates(u, dx) : -1);
}

FMI2_STATUS fmi2GetEventIndicators(void *c, double z[], size_t n) {
    BK_UNIT;
    int found = n == BK_NZ ? bk_refresh(u) : -1;
    (void)z;
#if BK_NZ > 0
    if (found == BK_OK) {
        bk_events(&u->m, z);
    }
#endif
    return bk_status2(u, found);
}

FMI2_STATUS fmi2GetContinuousStates(void *c, double x[], size_t n) {
    BK_UNIT;
    if (n != BK_NX || bk_status2(u, u->m.s.phase <= BK_INITIALIZATION ? bk_refresh(u) : BK_OK) != fmi2OK) {
        return fmi2Error;
    }
    bk_copy(x, u->m.s.x, BK_NX);
    return fmi2OK;
}

FMI2_STATUS fmi2GetNominalsOfContinuousStates(void *c, double nominals[], size_t n) {
    size_t i;
    (void)c;
    for (i = 0; i < n; i++) {
        nominals[i] = 1.0;
    }
    return n == BK_NX ? fmi2OK : fmi2Error;
}

FMI2_STATUS fmi2SetRealInputDerivatives(void *c, const fmi2ValueReference vr[], size_t n, const int order[],
                                        const double values[]) {
    (void)c; (void)vr; (void)order; (void)values;
    return n == 0 ? fmi2OK : fmi2Error;
}

FMI2_STATUS fmi2GetRealOutputDerivatives(void *c, const fmi2ValueReference vr[], size_t n, const int order[],
                                         double values[]) {
    (void)c; (void)vr; (void)order; (void)values;
    return n == 0 ? fmi2OK : fmi2Error;
}

FMI2_STATUS fmi2DoStep(void *c, double t, double h, int no_earlier) {
    BK_UNIT;
    int event = 0;
    (void)no_earlier;
    return bk_status2(u, u->is_exchange ? -1 : bk_do_step(u, t, h, &event));
}

FMI2_STATUS fmi2CancelStep(void *c) { (void)c; return fmi2Error; }

FMI2_STATUS fmi2GetStatus(void *c, int kind, fmi2Status *value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

FMI2_STATUS fmi2GetRealStatus(void *c, int kind, double *value) {
    BK_UNIT;
    if (kind != 2) {
        return fmi2Discard;
    }
    *value = u->m.s.t;
    return fmi2OK;
}

FMI2_STATUS fmi2GetIntegerStatus(void *c, int kind, int *value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

FMI2_STATUS fmi2GetBooleanStatus(void *c, int kind, int *value) {
    (void)c;
    if (kind != 3) {
        return fmi2Discard;
    }
    *value = 0;
    return fmi2OK;
}

FMI2_STATUS fmi2GetStringStatus(void *c, int kind, const char **value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}
