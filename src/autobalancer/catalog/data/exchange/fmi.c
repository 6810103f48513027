/* The machine as a functional mock-up unit: the interface of FMI 2.0 (FMI_VERSION 2) or 3.0 (3) around a
   machine (AB_SOURCE "autobalancer.c") or balls alone ("balancer.c").

   Value references: 0 time; FIRST_STATE and FIRST_RATE + number of a state; FIRST_OUTPUT, FIRST_PARAMETER,
   FIRST_INPUT and FIRST_INDICATOR + number. */

#ifndef AB_API
#define AB_API static
#endif
#include AB_SOURCE

#include <stdarg.h>
#include <stdio.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { FIRST_STATE = 1000, FIRST_RATE = 2000, FIRST_OUTPUT = 3000, FIRST_PARAMETER = 4000, FIRST_INPUT = 5000,
       FIRST_INDICATOR = 6000 };
enum { OK, WARNING, DISCARD, FAILED, FATAL };
#define NEAR 1e-6 /* step of a difference, relative to the size of a number */

#if FMI_VERSION == 2
typedef int boolean;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;
#define NAME(name) fmi2##name
#else
typedef _Bool boolean;
typedef void logger(void *, int, const char *, const char *);
#define NAME(name) fmi3##name
#endif

typedef struct {
    ab_machine *machine;
    double time;                   /* Model Exchange: that of the host */
    double state[AB_STATE_COUNT];  /* Model Exchange */
    double outputs[AB_OUTPUT_COUNT + 1];
    int exchange, known;           /* whether the outputs are those of now */
    char *name;
#if FMI_VERSION == 2
    callbacks with;
#else
    logger *log;
    void *environment;
#endif
} unit;

static int complain(unit *u, int status, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
#if FMI_VERSION == 2
    if (u->with.logger) u->with.logger(u->with.environment, u->name, status, "logStatusError", "%s", text);
#else
    if (u->log) u->log(u->environment, status, "logStatusError", text);
#endif
    return status;
}

static unit *create(const char *name, int exchange) {
    unit *u = calloc(1, sizeof *u);
    if (u == NULL) return NULL;
    u->machine = ab_create();
    u->name = malloc(strlen(name) + 1);
    if (u->machine == NULL || u->name == NULL) {
        ab_free(u->machine), free(u->name), free(u);
        return NULL;
    }
    strcpy(u->name, name);
    u->exchange = u->machine->held = exchange;
    ab_state(u->machine, u->state);
    return u;
}

static void release(unit *u) {
    if (u == NULL) return;
    ab_free(u->machine);
    free(u->name), free(u);
}

/* In Model Exchange the machine is at the state of the host when somebody asks. */
static void bring(unit *u) {
    if (!u->exchange) return;
    memcpy(u->machine->state, u->state, sizeof u->state);
    u->machine->time = u->time;
}

static int rates_of(unit *u, const double *state, double *rates) {
    if (u->exchange) return host_rates(u->machine, u->time, state, rates);
    return ab_derivatives(u->machine, ab_time(u->machine), state, rates);
}

/* Numbers that are positive until an event is due. */
static int indicate(unit *u, double *indicators) {
#if AB_INDICATOR_COUNT
    follow_host(u->machine, u->time, u->state);
    if (ab_indicators(u->machine, u->time, u->state, indicators))
        return complain(u, FAILED, "the rates are not finite at %g s", u->time);
#endif
    (void)u, (void)indicators;
    return OK;
}

/* What is due happens; whether the state changed by it. */
static int happen(unit *u, boolean *changed) {
    double before[AB_STATE_COUNT];
    memcpy(before, u->state, sizeof before);
#if AB_INDICATOR_COUNT
    if (u->exchange) follow_host(u->machine, u->time, u->state);
    if (u->exchange && ab_event(u->machine, u->time, u->state))
        return complain(u, FAILED, "the rates are not finite at %g s", u->time);
#endif
    u->known = 0, *changed = memcmp(before, u->state, sizeof before) != 0;
    return OK;
}

static int get(unit *u, unsigned reference, double *value) {
    unsigned number = reference % 1000;
    double rates[AB_STATE_COUNT], indicators[AB_INDICATOR_COUNT + 1];
    if (!u->exchange) ab_state(u->machine, u->state), u->time = ab_time(u->machine);
    if (reference == 0)
        *value = u->time;
    else if (reference >= FIRST_INDICATOR && number < AB_INDICATOR_COUNT) {
        if (indicate(u, indicators)) return FAILED;
        *value = indicators[number];
    } else if (reference >= FIRST_INPUT && number < AB_INPUT_COUNT)
        *value = u->machine->input[number];
    else if (reference >= FIRST_PARAMETER && number < AB_PARAMETER_COUNT)
        *value = ab_parameter(u->machine, (int)number);
    else if (reference >= FIRST_OUTPUT && reference < FIRST_PARAMETER && number < AB_OUTPUT_COUNT) {
        if (!u->known) bring(u), ab_outputs(u->machine, u->outputs), u->known = 1;
        *value = u->outputs[number];
    } else if (reference >= FIRST_RATE && reference < FIRST_OUTPUT && number < AB_STATE_COUNT) {
        if (rates_of(u, u->state, rates)) return complain(u, FAILED, "the rates are not finite at %g s", u->time);
        *value = rates[number];
    } else if (reference >= FIRST_STATE && reference < FIRST_RATE && number < AB_STATE_COUNT)
        *value = u->state[number];
    else
        return complain(u, FAILED, "value reference %u: there is none", reference);
    return OK;
}

static int set(unit *u, unsigned reference, double value) {
    unsigned number = reference % 1000;
    u->known = 0;
    if (reference >= FIRST_PARAMETER && reference < FIRST_INPUT) {
        if (ab_set_parameter(u->machine, (int)number, value) != AB_OK)
            return complain(u, FAILED, "parameter %s: given %g, allowed from %g to %g", ab_parameter_list[number].name, value,
                            ab_parameter_list[number].least, ab_parameter_list[number].greatest);
        if (u->time == 0.0) ab_state(u->machine, u->state);
        return OK;
    }
    if (reference >= FIRST_INPUT) {
        if (ab_set_input(u->machine, (int)number, value) != AB_OK) return complain(u, FAILED, "input %u: given %g", number, value);
        return OK;
    }
    if (reference >= FIRST_STATE && reference < FIRST_RATE && number < AB_STATE_COUNT) {
        double state[AB_STATE_COUNT];
        ab_state(u->machine, state);
        state[number] = u->state[number] = value;
        if (ab_set_state(u->machine, ab_time(u->machine), state) != AB_OK)
            return complain(u, FAILED, "state %s: given %g", ab_states[number].name, value);
        return OK;
    }
    return complain(u, FAILED, "value reference %u cannot be set", reference);
}

static int get_all(unit *u, const unsigned *references, size_t count, double *values) {
    for (size_t i = 0; i < count; i++)
        if (get(u, references[i], values + i) != OK) return FAILED;
    return OK;
}

static int set_all(unit *u, const unsigned *references, size_t count, const double *values) {
    for (size_t i = 0; i < count; i++)
        if (set(u, references[i], values[i]) != OK) return FAILED;
    return OK;
}

static int step(unit *u, double time, double length) {
    u->known = 0;
    if (fabs(time - ab_time(u->machine)) > 1e-9 * (fabs(time) + length))
        return complain(u, FAILED, "a step from %g s, but the machine is at %g s", time, ab_time(u->machine));
    int status = ab_step(u->machine, time + length);
    if (status == AB_OK) return OK;
    return complain(u, FAILED, status == AB_STEP_TOO_SMALL   ? "at %g s the step size fell below rounding"
                               : status == AB_TOO_MANY_STEPS ? "at %g s ten million steps were taken for one of the host"
                                                             : "at %g s the motion grew without limit", ab_time(u->machine));
}

/* A host may ask for smaller errors than the machine's own; where it integrates itself, events are judged by its errors. */
static void follow_tolerance(unit *u, double tolerance) {
    if (u->exchange || tolerance < AB_TOLERANCE) ab_set_tolerance(u->machine, tolerance);
}

/* Derivative of some numbers in a direction of states and input, by a central difference. */
static int directional(unit *u, const unsigned *wanted, size_t count, const unsigned *known, size_t given, const double *seed,
                       double *values) {
    double *before = malloc((count + 1) * sizeof *before), kept[AB_STATE_COUNT], input[AB_INPUT_COUNT + 1], size = 0.0;
    int status = before == NULL ? FAILED : OK;
    if (!u->exchange) ab_state(u->machine, u->state);
    memcpy(kept, u->state, sizeof kept), memcpy(input, u->machine->input, sizeof input);
    for (size_t i = 0; i < given; i++) size = fmax(size, fabs(seed[i]));
    for (int side = -1; side <= 1 && status == OK && size > 0.0; side += 2) {
        double by = side * NEAR / size;
        for (size_t i = 0; i < given; i++) {
            if (known[i] >= FIRST_INPUT)
                u->machine->input[known[i] - FIRST_INPUT] = input[known[i] - FIRST_INPUT] + by * seed[i];
            else if (known[i] >= FIRST_STATE && known[i] < FIRST_RATE)
                u->state[known[i] - FIRST_STATE] = kept[known[i] - FIRST_STATE] + by * seed[i];
        }
        int exchange = u->exchange;
        u->known = 0, u->exchange = 1;
        status = get_all(u, wanted, count, side < 0 ? before : values);
        u->exchange = exchange;
        memcpy(u->state, kept, sizeof kept), memcpy(u->machine->input, input, sizeof input);
    }
    for (size_t i = 0; i < count && status == OK; i++)
        values[i] = size > 0.0 ? (values[i] - before[i]) / (2.0 * NEAR / size) : 0.0;
    free(before);
    u->known = 0;
    bring(u);
    return status;
}

/* All of a unit as bytes. */
typedef struct {
    size_t size;
    unit kept;
    char machine[];
} saved;

static saved *save(unit *u, saved *old) {
    saved *s = old != NULL ? old : malloc(sizeof *s + ab_saved_size());
    if (s == NULL) return NULL;
    s->size = sizeof *s + ab_saved_size();
    s->kept = *u;
    ab_save(u->machine, s->machine);
    return s;
}

static int restore(unit *u, const saved *s) {
    if (ab_restore(u->machine, s->machine) != AB_OK) return complain(u, FAILED, "this state is of another unit");
    u->time = s->kept.time, u->known = 0, u->exchange = s->kept.exchange;
    memcpy(u->state, s->kept.state, sizeof u->state);
    return OK;
}

/* Below are the functions of the standard: the same two times, as versions differ in their arguments. */

EXPORT const char *NAME(GetVersion)(void) { return FMI_VERSION == 2 ? "2.0" : "3.0"; }
EXPORT void NAME(FreeInstance)(unit *u) { release(u); }
EXPORT int NAME(Terminate)(unit *u) { return u ? OK : FAILED; }
EXPORT int NAME(Reset)(unit *u) {
    for (int i = 0; i < AB_PARAMETER_COUNT; i++) u->machine->parameters[i] = ab_parameter_list[i].start;
    ab_reset(u->machine);
    ab_state(u->machine, u->state);
    u->time = 0.0, u->known = 0;
    return OK;
}
EXPORT int NAME(ExitInitializationMode)(unit *u) {
    u->known = 0;
    return OK;
}
EXPORT int NAME(SetTime)(unit *u, double time) {
    u->time = time, u->known = 0;
    return OK;
}
EXPORT int NAME(SetContinuousStates)(unit *u, const double *states, size_t count) {
    (void)count;
    memcpy(u->state, states, sizeof u->state);
    u->known = 0;
    return OK;
}
EXPORT int NAME(GetContinuousStates)(unit *u, double *states, size_t count) {
    (void)count;
    memcpy(states, u->state, sizeof u->state);
    return OK;
}
EXPORT int NAME(GetNominalsOfContinuousStates)(unit *u, double *nominals, size_t count) {
    (void)u, (void)count;
    for (int i = 0; i < AB_STATE_COUNT; i++) {
        double size = size_of(i);
        nominals[i] = size > 0.0 ? size : 1.0;
    }
    return OK;
}
EXPORT int NAME(GetEventIndicators)(unit *u, double *indicators, size_t count) {
    (void)count;
    return indicate(u, indicators);
}

static int rates_of_host(unit *u, double *rates) {
    if (rates_of(u, u->state, rates)) return complain(u, FAILED, "the rates are not finite at %g s", u->time);
    return OK;
}

#if FMI_VERSION == 2

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT unit *fmi2Instantiate(const char *name, int type, const char *token, const char *resources, const callbacks *with,
                             boolean visible, boolean logging) {
    (void)resources, (void)visible, (void)logging;
    if (token != NULL && strcmp(token, AB_TOKEN) != 0) return NULL;
    unit *u = create(name, type == 0);
    if (u != NULL && with != NULL) u->with = *with;
    return u;
}
EXPORT int fmi2SetDebugLogging(unit *u, boolean on, size_t count, const char *const *categories) {
    (void)u, (void)on, (void)count, (void)categories;
    return OK;
}
EXPORT int fmi2SetupExperiment(unit *u, boolean has_tolerance, double tolerance, double begin, boolean has_end, double end) {
    (void)has_end, (void)end;
    if (begin != 0.0) return complain(u, FAILED, "the start time must be 0, given %g", begin);
    if (has_tolerance && tolerance > 0.0) follow_tolerance(u, tolerance);
    return OK;
}
EXPORT int fmi2EnterInitializationMode(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi2GetReal(unit *u, const unsigned *references, size_t count, double *values) {
    return get_all(u, references, count, values);
}
EXPORT int fmi2SetReal(unit *u, const unsigned *references, size_t count, const double *values) {
    return set_all(u, references, count, values);
}
#define NONE(type, short)                                                                       \
    EXPORT int fmi2Get##type(unit *u, const unsigned *r, size_t count, short *values) {          \
        (void)r, (void)values;                                                                  \
        return count == 0 ? OK : complain(u, FAILED, "there are real numbers only");            \
    }                                                                                           \
    EXPORT int fmi2Set##type(unit *u, const unsigned *r, size_t count, const short *values) {    \
        (void)r, (void)values;                                                                  \
        return count == 0 ? OK : complain(u, FAILED, "there are real numbers only");            \
    }
NONE(Integer, int)
NONE(Boolean, int)
NONE(String, char *)
EXPORT int fmi2GetFMUstate(unit *u, saved **state) { return (*state = save(u, *state)) ? OK : FAILED; }
EXPORT int fmi2SetFMUstate(unit *u, saved *state) { return restore(u, state); }
EXPORT int fmi2FreeFMUstate(unit *u, saved **state) {
    (void)u;
    free(*state);
    *state = NULL;
    return OK;
}
EXPORT int fmi2SerializedFMUstateSize(unit *u, saved *state, size_t *size) {
    (void)u;
    *size = state->size;
    return OK;
}
EXPORT int fmi2SerializeFMUstate(unit *u, saved *state, char *bytes, size_t size) {
    if (size < state->size) return complain(u, FAILED, "%zu bytes are needed", state->size);
    memcpy(bytes, state, state->size);
    return OK;
}
EXPORT int fmi2DeSerializeFMUstate(unit *u, const char *bytes, size_t size, saved **state) {
    if (size < sizeof(saved) + ab_saved_size()) return complain(u, FAILED, "these are too few bytes");
    if ((*state = malloc(size)) == NULL) return FAILED;
    memcpy(*state, bytes, size);
    return OK;
}
EXPORT int fmi2GetDirectionalDerivative(unit *u, const unsigned *wanted, size_t count, const unsigned *known, size_t given,
                                        const double *seed, double *values) {
    return directional(u, wanted, count, known, given, seed, values);
}
EXPORT int fmi2EnterEventMode(unit *u) { return u ? OK : FAILED; }
typedef struct {
    boolean again, terminate, nominals, values, defined;
    double time;
} event_info;
EXPORT int fmi2NewDiscreteStates(unit *u, event_info *info) {
    memset(info, 0, sizeof *info);
    info->time = corner_after(u->machine, u->time);
    info->defined = isfinite(info->time);
    if (!info->defined) info->time = 0.0;
    return happen(u, &info->values);
}
EXPORT int fmi2EnterContinuousTimeMode(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi2CompletedIntegratorStep(unit *u, boolean final, boolean *event, boolean *terminate) {
    (void)u, (void)final;
    *event = *terminate = 0;
    return OK;
}
EXPORT int fmi2GetDerivatives(unit *u, double *rates, size_t count) {
    (void)count;
    return rates_of_host(u, rates);
}
EXPORT int fmi2SetRealInputDerivatives(unit *u, const unsigned *r, size_t count, const int *order, const double *values) {
    (void)r, (void)order, (void)values;
    return count == 0 ? OK : complain(u, FAILED, "rates of inputs are not used");
}
EXPORT int fmi2GetRealOutputDerivatives(unit *u, const unsigned *r, size_t count, const int *order, double *values) {
    (void)r, (void)order, (void)values;
    return count == 0 ? OK : complain(u, FAILED, "rates of outputs are not given");
}
EXPORT int fmi2DoStep(unit *u, double time, double length, boolean keep) {
    (void)keep;
    return step(u, time, length);
}
EXPORT int fmi2CancelStep(unit *u) { return complain(u, FAILED, "a step is never pending"); }
#define STATUS(name, type)                                            \
    EXPORT int fmi2Get##name##Status(unit *u, int kind, type *value) { \
        (void)u, (void)kind, (void)value;                              \
        return DISCARD;                                               \
    }
STATUS(, int)
STATUS(Real, double)
STATUS(Integer, int)
STATUS(Boolean, int)
STATUS(String, const char *)

#else

EXPORT int fmi3SetDebugLogging(unit *u, boolean on, size_t count, const char *const *categories) {
    (void)u, (void)on, (void)count, (void)categories;
    return OK;
}
static unit *instance(const char *name, const char *token, void *environment, logger *log, int exchange) {
    if (token != NULL && strcmp(token, AB_TOKEN) != 0) return NULL;
    unit *u = create(name, exchange);
    if (u != NULL) u->log = log, u->environment = environment;
    return u;
}
EXPORT unit *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, boolean visible,
                                          boolean logging, void *environment, logger *log) {
    (void)resources, (void)visible, (void)logging;
    return instance(name, token, environment, log, 1);
}
EXPORT unit *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, boolean visible,
                                         boolean logging, boolean events, boolean early, const unsigned *required, size_t count,
                                         void *environment, logger *log, void *update) {
    (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)count, (void)update;
    return instance(name, token, environment, log, 0);
}
EXPORT unit *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources, boolean visible,
                                               boolean logging, void *environment, logger *log, void *a, void *b, void *c) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
    (void)a, (void)b, (void)c;
    return NULL;
}
EXPORT int fmi3EnterInitializationMode(unit *u, boolean has_tolerance, double tolerance, double begin, boolean has_end,
                                       double end) {
    (void)has_end, (void)end;
    if (begin != 0.0) return complain(u, FAILED, "the start time must be 0, given %g", begin);
    if (has_tolerance && tolerance > 0.0) follow_tolerance(u, tolerance);
    return OK;
}
EXPORT int fmi3GetFloat64(unit *u, const unsigned *references, size_t count, double *values, size_t size) {
    (void)size;
    return get_all(u, references, count, values);
}
EXPORT int fmi3SetFloat64(unit *u, const unsigned *references, size_t count, const double *values, size_t size) {
    (void)size;
    return set_all(u, references, count, values);
}
#define NONE(type, short)                                                                                     \
    EXPORT int fmi3Get##type(unit *u, const unsigned *r, size_t count, short *values, size_t size) {           \
        (void)r, (void)values, (void)size;                                                                    \
        return count == 0 ? OK : complain(u, FAILED, "there are numbers of type Float64 only");               \
    }                                                                                                         \
    EXPORT int fmi3Set##type(unit *u, const unsigned *r, size_t count, const short *values, size_t size) {     \
        (void)r, (void)values, (void)size;                                                                    \
        return count == 0 ? OK : complain(u, FAILED, "there are numbers of type Float64 only");               \
    }
NONE(Float32, float)
NONE(Int8, int8_t)
NONE(UInt8, uint8_t)
NONE(Int16, int16_t)
NONE(UInt16, uint16_t)
NONE(Int32, int32_t)
NONE(UInt32, uint32_t)
NONE(Int64, int64_t)
NONE(UInt64, uint64_t)
NONE(Boolean, boolean)
NONE(String, char *)
#define ABSENT(name, ...)                                                         \
    EXPORT int fmi3##name(unit *u, __VA_ARGS__) {                                 \
        return complain(u, FAILED, "%s: there is nothing of this kind", #name);   \
    }
ABSENT(GetBinary, const unsigned *r, size_t n, size_t *sizes, const uint8_t **values, size_t size)
ABSENT(SetBinary, const unsigned *r, size_t n, const size_t *sizes, const uint8_t *const *values, size_t size)
ABSENT(GetClock, const unsigned *r, size_t n, boolean *values)
ABSENT(SetClock, const unsigned *r, size_t n, const boolean *values)
ABSENT(GetAdjointDerivative, const unsigned *a, size_t na, const unsigned *b, size_t nb, const double *c, size_t nc, double *d,
       size_t nd)
ABSENT(GetIntervalDecimal, const unsigned *r, size_t n, double *a, int *b)
ABSENT(GetIntervalFraction, const unsigned *r, size_t n, uint64_t *a, uint64_t *b, int *c)
ABSENT(GetShiftDecimal, const unsigned *r, size_t n, double *a)
ABSENT(GetShiftFraction, const unsigned *r, size_t n, uint64_t *a, uint64_t *b)
ABSENT(SetIntervalDecimal, const unsigned *r, size_t n, const double *a)
ABSENT(SetIntervalFraction, const unsigned *r, size_t n, const uint64_t *a, const uint64_t *b)
ABSENT(SetShiftDecimal, const unsigned *r, size_t n, const double *a)
ABSENT(SetShiftFraction, const unsigned *r, size_t n, const uint64_t *a, const uint64_t *b)
ABSENT(ActivateModelPartition, unsigned r, double time)
ABSENT(GetVariableDependencies, unsigned r, size_t *a, unsigned *b, size_t *c, int *d, size_t n)
ABSENT(GetOutputDerivatives, const unsigned *r, size_t n, const int32_t *order, double *values, size_t size)
EXPORT int fmi3GetNumberOfVariableDependencies(unit *u, unsigned r, size_t *count) {
    (void)r;
    return complain(u, FAILED, "dependencies: see modelDescription.xml"), *count = 0, FAILED;
}
EXPORT int fmi3GetFMUState(unit *u, saved **state) { return (*state = save(u, *state)) ? OK : FAILED; }
EXPORT int fmi3SetFMUState(unit *u, saved *state) { return restore(u, state); }
EXPORT int fmi3FreeFMUState(unit *u, saved **state) {
    (void)u;
    free(*state);
    *state = NULL;
    return OK;
}
EXPORT int fmi3SerializedFMUStateSize(unit *u, saved *state, size_t *size) {
    (void)u;
    *size = state->size;
    return OK;
}
EXPORT int fmi3SerializeFMUState(unit *u, saved *state, uint8_t *bytes, size_t size) {
    if (size < state->size) return complain(u, FAILED, "%zu bytes are needed", state->size);
    memcpy(bytes, state, state->size);
    return OK;
}
EXPORT int fmi3DeserializeFMUState(unit *u, const uint8_t *bytes, size_t size, saved **state) {
    if (size < sizeof(saved) + ab_saved_size()) return complain(u, FAILED, "these are too few bytes");
    if ((*state = malloc(size)) == NULL) return FAILED;
    memcpy(*state, bytes, size);
    return OK;
}
EXPORT int fmi3GetDirectionalDerivative(unit *u, const unsigned *wanted, size_t count, const unsigned *known, size_t given,
                                        const double *seed, size_t seeds, double *values, size_t size) {
    (void)seeds, (void)size;
    return directional(u, wanted, count, known, given, seed, values);
}
EXPORT int fmi3EnterConfigurationMode(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi3ExitConfigurationMode(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi3EnterEventMode(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi3EnterStepMode(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi3EvaluateDiscreteStates(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi3UpdateDiscreteStates(unit *u, boolean *again, boolean *terminate, boolean *nominals, boolean *values,
                                    boolean *defined, double *time) {
    *again = *terminate = *nominals = *values = 0;
    *time = u->exchange ? corner_after(u->machine, u->time) : INFINITY;
    *defined = isfinite(*time);
    if (!*defined) *time = 0.0;
    return happen(u, values);
}
EXPORT int fmi3EnterContinuousTimeMode(unit *u) { return u ? OK : FAILED; }
EXPORT int fmi3CompletedIntegratorStep(unit *u, boolean final, boolean *event, boolean *terminate) {
    (void)u, (void)final;
    *event = *terminate = 0;
    return OK;
}
EXPORT int fmi3GetContinuousStateDerivatives(unit *u, double *rates, size_t count) {
    (void)count;
    return rates_of_host(u, rates);
}
EXPORT int fmi3GetNumberOfEventIndicators(unit *u, size_t *count) {
    (void)u;
    *count = AB_INDICATOR_COUNT;
    return OK;
}
EXPORT int fmi3GetNumberOfContinuousStates(unit *u, size_t *count) {
    (void)u;
    *count = AB_STATE_COUNT;
    return OK;
}
EXPORT int fmi3DoStep(unit *u, double time, double length, boolean keep, boolean *event, boolean *terminate, boolean *early,
                      double *reached) {
    (void)keep;
    *event = *terminate = *early = 0;
    int status = step(u, time, length);
    *reached = ab_time(u->machine);
    return status;
}

#endif
