/* ---- FMI 3.0: the declarations of its binary interface, then its functions ------------------------------------ */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#if defined _WIN32
#define FMI_EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define FMI_EXPORT __attribute__((visibility("default")))
#else
#define FMI_EXPORT
#endif

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*fmi3LogMessageCallback)(void *, fmi3Status, const char *, const char *);
typedef uint32_t fmi3ValueReference;

#define FMI3_STATUS FMI_EXPORT fmi3Status
#define BK_UNIT bk_unit *u = (bk_unit *)instance

static void bk_say3(const bk_unit *u, const char *text) {
    fmi3LogMessageCallback log;
    memcpy(&log, u->callbacks, sizeof log);
    if (log) {
        log(u->environment, fmi3Error, "logStatusError", text);
    }
}

static fmi3Status bk_status3(const bk_unit *u, int fault) {
    return bk_fails(u, fault) ? fmi3Error : fmi3OK;
}

static void *bk_instance3(const char *token, void *environment, fmi3LogMessageCallback log, int is_exchange) {
    bk_unit *u;
    if (!token || strcmp(token, BK_TOKEN) != 0) {
        if (log) {
            log(environment, fmi3Error, "logStatusError", "the instantiation token is of another unit");
        }
        return NULL;
    }
    u = (bk_unit *)calloc(1, sizeof *u);
    if (u) {
        u->is_exchange = is_exchange;
        u->environment = environment;
        memcpy(u->callbacks, &log, sizeof log);
        u->say = bk_say3;
        bk_begin(u);
    }
    return u;
}

FMI_EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

FMI3_STATUS fmi3SetDebugLogging(void *instance, bool on, size_t n, const char *const categories[]) {
    (void)instance; (void)on; (void)n; (void)categories;
    return fmi3OK;
}

FMI_EXPORT void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *path, bool visible,
                                              bool logs, void *environment, fmi3LogMessageCallback log) {
    (void)name; (void)path; (void)visible; (void)logs;
    return bk_instance3(token, environment, log, 1);
}

FMI_EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *path, bool visible,
                                             bool logs, bool uses_events, bool may_return,
                                             const fmi3ValueReference required[], size_t n_required,
                                             void *environment, fmi3LogMessageCallback log, void (*update)(void)) {
    bk_unit *u = (bk_unit *)bk_instance3(token, environment, log, 0);
    (void)name; (void)path; (void)visible; (void)logs; (void)required; (void)n_required; (void)update;
    if (u) {
        u->uses_events = uses_events;
        u->may_return = may_return;
    }
    return u;
}

FMI_EXPORT void *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *path,
                                                   bool visible, bool logs, void *environment,
                                                   fmi3LogMessageCallback log, void (*update)(void),
                                                   void (*lock)(void), void (*unlock)(void)) {
    (void)name; (void)token; (void)path; (void)visible; (void)logs; (void)environment; (void)log; (void)update;
    (void)lock; (void)unlock;
    return NULL;
}

FMI_EXPORT void fmi3FreeInstance(void *instance) { free(instance); }

FMI3_STATUS fmi3EnterInitializationMode(void *instance, bool has_tolerance, double tolerance, double start,
                                        bool has_stop, double stop) {
    BK_UNIT;
    (void)has_stop; (void)stop;
    if (u->m.s.phase != BK_INSTANTIATED) {
        return bk_status3(u, -1);
    }
    if (has_tolerance && tolerance > 0.0) {
        u->m.s.tolerance = fmin(fmax(tolerance, 1e-12), 1e-2);
    }
    u->m.s.t_start = start;
    u->m.s.is_stale = 1;
    u->m.s.phase = BK_INITIALIZATION;
    return fmi3OK;
}

FMI3_STATUS fmi3ExitInitializationMode(void *instance) {
    BK_UNIT;
    const int found = u->m.s.phase == BK_INITIALIZATION ? bk_start_unit(u) : -1;
    if (found == BK_OK) {
        u->m.s.phase = u->is_exchange || u->uses_events ? BK_EVENT : BK_STEP;
    }
    return bk_status3(u, found);
}

FMI3_STATUS fmi3EnterEventMode(void *instance) {
    BK_UNIT;
    u->m.s.phase = BK_EVENT;
    return fmi3OK;
}

FMI3_STATUS fmi3Terminate(void *instance) {
    BK_UNIT;
    u->m.s.phase = BK_TERMINATED;
    return fmi3OK;
}

FMI3_STATUS fmi3Reset(void *instance) {
    BK_UNIT;
    bk_begin(u);
    return fmi3OK;
}

FMI3_STATUS fmi3GetFloat64(void *instance, const fmi3ValueReference vr[], size_t n, double values[], size_t n_values) {
    BK_UNIT;
    size_t i;
    int found = n == n_values ? BK_OK : -1;
    for (i = 0; i < n && found == BK_OK; i++) {
        found = bk_get(u, vr[i], values + i);
    }
    return bk_status3(u, found);
}

FMI3_STATUS fmi3SetFloat64(void *instance, const fmi3ValueReference vr[], size_t n, const double values[],
                           size_t n_values) {
    BK_UNIT;
    size_t i;
    int found = n == n_values ? BK_OK : -1;
    for (i = 0; i < n && found == BK_OK; i++) {
        found = bk_put(u, vr[i], values[i]);
    }
    return bk_status3(u, found);
}

/* There are no variables of other types. */
#define BK_NONE(name, type)                                                                                        \
    FMI3_STATUS fmi3Get##name(void *instance, const fmi3ValueReference vr[], size_t n, type values[], size_t m) {  \
        (void)instance; (void)vr; (void)values; (void)m;                                                           \
        return n == 0 ? fmi3OK : fmi3Error;                                                                        \
    }                                                                                                              \
    FMI3_STATUS fmi3Set##name(void *instance, const fmi3ValueReference vr[], size_t n, const type values[],        \
                              size_t m) {                                                                          \
        (void)instance; (void)vr; (void)values; (void)m;                                                           \
        return n == 0 ? fmi3OK : fmi3Error;                                                                        \
    }
typedef const char *bk_text;
BK_NONE(Float32, float)
BK_NONE(Int8, int8_t)
BK_NONE(UInt8, uint8_t)
BK_NONE(Int16, int16_t)
BK_NONE(UInt16, uint16_t)
BK_NONE(Int32, int32_t)
BK_NONE(UInt32, uint32_t)
BK_NONE(Int64, int64_t)
BK_NONE(UInt64, uint64_t)
BK_NONE(Boolean, bool)
BK_NONE(String, bk_text)

FMI3_STATUS fmi3GetBinary(void *instance, const fmi3ValueReference vr[], size_t n, size_t sizes[],
                          const uint8_t *values[], size_t m) {
    (void)instance; (void)vr; (void)sizes; (void)values; (void)m;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3SetBinary(void *instance, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                          const uint8_t *const values[], size_t m) {
    (void)instance; (void)vr; (void)sizes; (void)values; (void)m;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3GetClock(void *instance, const fmi3ValueReference vr[], size_t n, bool values[]) {
    (void)instance; (void)vr; (void)values;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3SetClock(void *instance, const fmi3ValueReference vr[], size_t n, const bool values[]) {
    (void)instance; (void)vr; (void)values;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3GetNumberOfVariableDependencies(void *instance, fmi3ValueReference vr, size_t *n) {
    (void)instance; (void)vr; (void)n;
    return fmi3Error;
}

FMI3_STATUS fmi3GetVariableDependencies(void *instance, fmi3ValueReference vr, size_t elements[],
                                        fmi3ValueReference independents[], size_t others[], int kinds[], size_t n) {
    (void)instance; (void)vr; (void)elements; (void)independents; (void)others; (void)kinds; (void)n;
    return fmi3Error;
}

FMI3_STATUS fmi3GetFMUState(void *instance, void **state) {
    BK_UNIT;
    if (!*state) {
        *state = malloc(sizeof u->m.s);
    }
    if (!*state) {
        return fmi3Error;
    }
    memcpy(*state, &u->m.s, sizeof u->m.s);
    return fmi3OK;
}

/* The state, with the factors that belong to it. */
static int bk_restore(bk_unit *u, const void *state) {
    if (!state) {
        return -1;
    }
    memcpy(&u->m.s, state, sizeof u->m.s);
    return BK_OK;
}

FMI3_STATUS fmi3SetFMUState(void *instance, void *state) {
    BK_UNIT;
    return bk_status3(u, bk_restore(u, state));
}

FMI3_STATUS fmi3FreeFMUState(void *instance, void **state) {
    (void)instance;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

FMI3_STATUS fmi3SerializedFMUStateSize(void *instance, void *state, size_t *size) {
    (void)instance; (void)state;
    *size = sizeof(bk_state);
    return fmi3OK;
}

FMI3_STATUS fmi3SerializeFMUState(void *instance, void *state, uint8_t bytes[], size_t size) {
    (void)instance;
    if (!state || size != sizeof(bk_state)) {
        return fmi3Error;
    }
    memcpy(bytes, state, size);
    return fmi3OK;
}

FMI3_STATUS fmi3DeserializeFMUState(void *instance, const uint8_t bytes[], size_t size, void **state) {
    (void)instance;
    if (size != sizeof(bk_state)) {
        return fmi3Error;
    }
    if (!*state) {
        *state = malloc(size);
    }
    if (!*state) {
        return fmi3Error;
    }
    memcpy(*state, bytes, size);
    return fmi3OK;
}

FMI3_STATUS fmi3GetDirectionalDerivative(void *instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                         const fmi3ValueReference knowns[], size_t n_knowns, const double seed[],
                                         size_t n_seed, double out[], size_t n_out) {
    BK_UNIT;
    if (n_seed != n_knowns || n_out != n_unknowns) {
        return bk_status3(u, -1);
    }
    return bk_status3(u, bk_direction(u, unknowns, n_unknowns, knowns, n_knowns, seed, out));
}

FMI3_STATUS fmi3GetAdjointDerivative(void *instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                     const fmi3ValueReference knowns[], size_t n_knowns, const double seed[],
                                     size_t n_seed, double out[], size_t n_out) {
    (void)instance; (void)unknowns; (void)n_unknowns; (void)knowns; (void)n_knowns; (void)seed; (void)n_seed;
    (void)out; (void)n_out;
    return fmi3Error;
}

FMI3_STATUS fmi3EnterConfigurationMode(void *instance) { (void)instance; return fmi3Error; }
FMI3_STATUS fmi3ExitConfigurationMode(void *instance) { (void)instance; return fmi3Error; }

FMI3_STATUS fmi3GetIntervalDecimal(void *instance, const fmi3ValueReference vr[], size_t n, double intervals[],
                                   int qualifiers[]) {
    (void)instance; (void)vr; (void)intervals; (void)qualifiers;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3GetIntervalFraction(void *instance, const fmi3ValueReference vr[], size_t n, uint64_t counters[],
                                    uint64_t resolutions[], int qualifiers[]) {
    (void)instance; (void)vr; (void)counters; (void)resolutions; (void)qualifiers;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3GetShiftDecimal(void *instance, const fmi3ValueReference vr[], size_t n, double shifts[]) {
    (void)instance; (void)vr; (void)shifts;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3GetShiftFraction(void *instance, const fmi3ValueReference vr[], size_t n, uint64_t counters[],
                                 uint64_t resolutions[]) {
    (void)instance; (void)vr; (void)counters; (void)resolutions;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3SetIntervalDecimal(void *instance, const fmi3ValueReference vr[], size_t n, const double intervals[]) {
    (void)instance; (void)vr; (void)intervals;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3SetIntervalFraction(void *instance, const fmi3ValueReference vr[], size_t n,
                                    const uint64_t counters[], const uint64_t resolutions[]) {
    (void)instance; (void)vr; (void)counters; (void)resolutions;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3SetShiftDecimal(void *instance, const fmi3ValueReference vr[], size_t n, const double shifts[]) {
    (void)instance; (void)vr; (void)shifts;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3SetShiftFraction(void *instance, const fmi3ValueReference vr[], size_t n, const uint64_t counters[],
                                 const uint64_t resolutions[]) {
    (void)instance; (void)vr; (void)counters; (void)resolutions;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3EvaluateDiscreteStates(void *instance) { (void)instance; return fmi3OK; }

FMI3_STATUS fmi3UpdateDiscreteStates(void *instance, bool *again, bool *ends, bool *nominals, bool *values,
                                     bool *has_next, double *next) {
    BK_UNIT;
    int is_moved = 0;
    const int found = bk_update(u, &is_moved);
    *again = false;
    *ends = false;
    *nominals = false;
    *values = is_moved != 0;
    *has_next = found == BK_OK && bk_next_time(u, next);
    u->m.s.is_at_event = 0;
    return bk_status3(u, found);
}

FMI3_STATUS fmi3EnterContinuousTimeMode(void *instance) {
    BK_UNIT;
    u->m.s.phase = BK_CONTINUOUS;
    return fmi3OK;
}

FMI3_STATUS fmi3CompletedIntegratorStep(void *instance, bool no_earlier, bool *enter, bool *ends) {
    BK_UNIT;
    int wants = 0;
    const int found = bk_complete_step(u, &wants);
    (void)no_earlier;
    *enter = wants != 0;
    *ends = false;
    return bk_status3(u, found);
}

FMI3_STATUS fmi3SetTime(void *instance, double t) {
    BK_UNIT;
    if (!u->is_exchange) {
        return bk_status3(u, -1);
    }
    if (u->m.s.t != t) {
        u->m.s.t = t;
        u->m.s.is_stale = 1;
    }
    return fmi3OK;
}

FMI3_STATUS fmi3SetContinuousStates(void *instance, const double x[], size_t n) {
    BK_UNIT;
    if (!u->is_exchange || n != BK_NX) {
        return bk_status3(u, -1);
    }
    bk_copy(u->m.s.x, x, BK_NX);
    u->m.s.is_stale = 1;
    return fmi3OK;
}

FMI3_STATUS fmi3GetContinuousStateDerivatives(void *instance, double dx[], size_t n) {
    BK_UNIT;
    return bk_status3(u, n == BK_NX ? bk_state_rates(u, dx) : -1);
}

FMI3_STATUS fmi3GetEventIndicators(void *instance, double z[], size_t n) {
    BK_UNIT;
    int found = n == BK_NZ ? bk_refresh(u) : -1;
    (void)z;
#if BK_NZ > 0
    if (found == BK_OK) {
        bk_events(&u->m, z);
    }
#endif
    return bk_status3(u, found);
}

FMI3_STATUS fmi3GetContinuousStates(void *instance, double x[], size_t n) {
    BK_UNIT;
    if (n != BK_NX || bk_status3(u, u->m.s.phase <= BK_INITIALIZATION ? bk_refresh(u) : BK_OK) != fmi3OK) {
        return fmi3Error;
    }
    bk_copy(x, u->m.s.x, BK_NX);
    return fmi3OK;
}

FMI3_STATUS fmi3GetNominalsOfContinuousStates(void *instance, double nominals[], size_t n) {
    size_t i;
    (void)instance;
    for (i = 0; i < n; i++) {
        nominals[i] = 1.0;
    }
    return n == BK_NX ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3GetNumberOfEventIndicators(void *instance, size_t *n) {
    (void)instance;
    *n = BK_NZ;
    return fmi3OK;
}

FMI3_STATUS fmi3GetNumberOfContinuousStates(void *instance, size_t *n) {
    (void)instance;
    *n = BK_NX;
    return fmi3OK;
}

FMI3_STATUS fmi3EnterStepMode(void *instance) {
    BK_UNIT;
    u->m.s.phase = BK_STEP;
    return fmi3OK;
}

FMI3_STATUS fmi3GetOutputDerivatives(void *instance, const fmi3ValueReference vr[], size_t n, const int32_t orders[],
                                     double values[], size_t n_values) {
    (void)instance; (void)vr; (void)orders; (void)values; (void)n_values;
    return n == 0 ? fmi3OK : fmi3Error;
}

FMI3_STATUS fmi3DoStep(void *instance, double t, double h, bool no_earlier, bool *needs_event, bool *ends,
                       bool *is_early, double *reached) {
    BK_UNIT;
    int event = 0;
    const int found = u->is_exchange ? -1 : bk_do_step(u, t, h, &event);
    (void)no_earlier;
    *needs_event = event && u->uses_events;
    *ends = false;
    *is_early = event && u->m.s.t < t + h;
    *reached = u->m.s.t;
    return bk_status3(u, found);
}

FMI3_STATUS fmi3ActivateModelPartition(void *instance, fmi3ValueReference clock, double t) {
    (void)instance; (void)clock; (void)t;
    return fmi3Error;
}
