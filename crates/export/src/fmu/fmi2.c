
/* FMI 2.0 for co-simulation: a variable's value reference is its place in `values`. No header is needed. */

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

/* Names of functions in programs that hold several FMUs begin with what the importer defines, as in the standard's own header. */
#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
#ifdef FMI2_FUNCTION_PREFIX
#define FMI(name) JOIN(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI(name) name
#endif

enum { VALUES = STATES + INPUTS + COEFFICIENTS };

typedef struct {
    double values[VALUES];
    double time;
} State;

typedef struct {
    State now;
    const fmi2CallbackFunctions *callbacks;
} Instance;

static fmi2Status failed(const Instance *instance, const char *why)
{
    const fmi2CallbackFunctions *to = instance->callbacks;
    if (to != NULL && to->logger != NULL) to->logger(to->componentEnvironment, "sindyna", fmi2Error, "logStatusError", "%s", why);
    return fmi2Error;
}

static void begin(State *state)
{
    int i;
    for (i = 0; i < VALUES; i++) state->values[i] = start[i];
    state->time = 0.0;
}

EXPORT const char *FMI(fmi2GetTypesPlatform)(void) { return "default"; }
EXPORT const char *FMI(fmi2GetVersion)(void) { return "2.0"; }

EXPORT fmi2Status FMI(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)c; (void)on; (void)count; (void)categories;
    return fmi2OK;
}

EXPORT fmi2Component FMI(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    Instance *instance;
    (void)name; (void)resources; (void)visible; (void)logging;
    if (type != fmi2CoSimulation || guid == NULL || strcmp(guid, GUID) != 0) return NULL;
    instance = malloc(sizeof(Instance));
    if (instance == NULL) return NULL;
    instance->callbacks = callbacks;
    begin(&instance->now);
    return instance;
}

EXPORT void FMI(fmi2FreeInstance)(fmi2Component c) { free(c); }

EXPORT fmi2Status FMI(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
    fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    (void)toleranceDefined; (void)tolerance; (void)stopTimeDefined; (void)stopTime;
    ((Instance *)c)->now.time = startTime;
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2EnterInitializationMode)(fmi2Component c) { (void)c; return fmi2OK; }
EXPORT fmi2Status FMI(fmi2ExitInitializationMode)(fmi2Component c) { (void)c; return fmi2OK; }
EXPORT fmi2Status FMI(fmi2Terminate)(fmi2Component c) { (void)c; return fmi2OK; }

EXPORT fmi2Status FMI(fmi2Reset)(fmi2Component c)
{
    begin(&((Instance *)c)->now);
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Real value[])
{
    Instance *instance = c;
    size_t i;
    for (i = 0; i < count; i++) {
        if (vr[i] >= VALUES) return failed(instance, "no such variable");
        value[i] = instance->now.values[vr[i]];
    }
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Real value[])
{
    Instance *instance = c;
    size_t i;
    for (i = 0; i < count; i++) {
        if (vr[i] >= VALUES) return failed(instance, "no such variable");
        instance->now.values[vr[i]] = value[i];
    }
    return fmi2OK;
}

/* All variables are real. */
#define NONE_OF(type, Type) \
    EXPORT fmi2Status FMI(fmi2Get##Type)(fmi2Component c, const fmi2ValueReference vr[], size_t count, type value[]) \
    { \
        (void)vr; (void)value; \
        return count == 0 ? fmi2OK : failed(c, "all variables are real"); \
    } \
    EXPORT fmi2Status FMI(fmi2Set##Type)(fmi2Component c, const fmi2ValueReference vr[], size_t count, const type value[]) \
    { \
        (void)vr; (void)value; \
        return count == 0 ? fmi2OK : failed(c, "all variables are real"); \
    }
NONE_OF(fmi2Integer, Integer)
NONE_OF(fmi2Boolean, Boolean)
NONE_OF(fmi2String, String)

EXPORT fmi2Status FMI(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    if (*state == NULL) *state = malloc(sizeof(State));
    if (*state == NULL) return failed(c, "no memory");
    *(State *)*state = ((Instance *)c)->now;
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    ((Instance *)c)->now = *(const State *)state;
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c; (void)state;
    *size = sizeof(State);
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (size != sizeof(State)) return failed(c, "a state of another size");
    memcpy(bytes, state, size);
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    if (size != sizeof(State)) return failed(c, "a state of another size");
    if (*state == NULL) *state = malloc(sizeof(State));
    if (*state == NULL) return failed(c, "no memory");
    memcpy(*state, bytes, size);
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
    const fmi2ValueReference known[], size_t knowns, const fmi2Real by[], fmi2Real derivative[])
{
    (void)unknown; (void)unknowns; (void)known; (void)knowns; (void)by; (void)derivative;
    return failed(c, "no derivatives");
}

EXPORT fmi2Status FMI(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
    const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr; (void)count; (void)order; (void)value;
    return failed(c, "inputs are held");
}

EXPORT fmi2Status FMI(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
    const fmi2Integer order[], fmi2Real value[])
{
    (void)vr; (void)count; (void)order; (void)value;
    return failed(c, "no derivatives");
}

/* Steps of one control interval each; where the equations are rates, of the length next to it that divides the communication step. */
EXPORT fmi2Status FMI(fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean noSetPrior)
{
    Instance *instance = c;
    double *x = instance->now.values, u[INPUTS + 1], next[STATES];
    const double *coefficients = x + STATES + INPUTS;
    double steps = floor(length / DT + 0.5), done;
    int i;
    (void)noSetPrior;
    if (length == 0.0) return fmi2OK;
    if (!(length > 0.0)) return failed(instance, "a step backwards");
    if (steps < 1.0) steps = 1.0;
    /* Times of communication are sums of steps, so they are rounded. */
    if (ONLY_WHOLE && fabs(length / DT - steps) > 1e-6 * steps) return failed(instance, "the step is no multiple of the control interval");
    for (i = 0; i < INPUTS; i++) u[i] = x[STATES + i];
    clip_control(u);
    for (done = 0.0; done < steps; done += 1.0) {
        sindyna_step(coefficients, ONLY_WHOLE ? DT : length / steps, x, u, next);
        clip_state(next);
        for (i = 0; i < STATES; i++) {
            if (!(fabs(next[i]) <= 1.7976931348623157e308)) return failed(instance, "a state is no longer finite");
        }
        for (i = 0; i < STATES; i++) x[i] = next[i];
    }
    instance->now.time = time + length;
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2CancelStep)(fmi2Component c) { return failed(c, "no step is under way"); }

EXPORT fmi2Status FMI(fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

EXPORT fmi2Status FMI(fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((Instance *)c)->now.time;
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

EXPORT fmi2Status FMI(fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = 0;
    return fmi2OK;
}

EXPORT fmi2Status FMI(fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}
