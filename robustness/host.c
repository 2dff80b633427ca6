/* A host in C: loads the library of an unpacked FMU, calls every function rightly and wrongly, frees an instance within its logger, and
   loads the library again. For valgrind and for compilers that instrument this side of the boundary:

       cc -g -fsanitize=address,undefined -o host robustness/host.c -ldl && ./host BactActuator.so GUID
*/
#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void *library;
static Component freed_in_logger;
static unsigned messages, refusals;

#define FUNCTION(result, name, ...)                                                                                                            \
    static result (*name)(__VA_ARGS__);
#define FUNCTIONS(F)                                                                                                                           \
    F(Component, fmi2Instantiate, const char *, int, const char *, const char *, const Callbacks *, int, int)                                  \
    F(void, fmi2FreeInstance, Component)                                                                                                       \
    F(int, fmi2SetDebugLogging, Component, int, size_t, const char *const *)                                                                   \
    F(int, fmi2SetupExperiment, Component, int, double, double, int, double)                                                                   \
    F(int, fmi2EnterInitializationMode, Component)                                                                                             \
    F(int, fmi2ExitInitializationMode, Component)                                                                                              \
    F(int, fmi2Terminate, Component)                                                                                                           \
    F(int, fmi2Reset, Component)                                                                                                               \
    F(int, fmi2GetReal, Component, const unsigned *, size_t, double *)                                                                         \
    F(int, fmi2GetInteger, Component, const unsigned *, size_t, int *)                                                                         \
    F(int, fmi2SetReal, Component, const unsigned *, size_t, const double *)                                                                   \
    F(int, fmi2SetInteger, Component, const unsigned *, size_t, const int *)                                                                   \
    F(int, fmi2GetFMUstate, Component, void **)                                                                                                \
    F(int, fmi2SetFMUstate, Component, void *)                                                                                                 \
    F(int, fmi2FreeFMUstate, Component, void **)                                                                                               \
    F(int, fmi2SerializedFMUstateSize, Component, void *, size_t *)                                                                            \
    F(int, fmi2SerializeFMUstate, Component, void *, char *, size_t)                                                                           \
    F(int, fmi2DeSerializeFMUstate, Component, const char *, size_t, void **)                                                                  \
    F(int, fmi2GetDirectionalDerivative, Component, const unsigned *, size_t, const unsigned *, size_t, const double *, double *)             \
    F(int, fmi2SetRealInputDerivatives, Component, const unsigned *, size_t, const int *, const double *)                                      \
    F(int, fmi2GetRealOutputDerivatives, Component, const unsigned *, size_t, const int *, double *)                                           \
    F(int, fmi2DoStep, Component, double, double, int)                                                                                         \
    F(int, fmi2GetRealStatus, Component, int, double *)                                                                                        \
    F(int, fmi2NewDiscreteStates, Component, void *)                                                                                           \
    F(int, fmi2EnterContinuousTimeMode, Component)                                                                                             \
    F(int, fmi2CompletedIntegratorStep, Component, int, int *, int *)                                                                          \
    F(int, fmi2SetTime, Component, double)                                                                                                     \
    F(int, fmi2SetContinuousStates, Component, const double *, size_t)                                                                         \
    F(int, fmi2GetDerivatives, Component, double *, size_t)                                                                                    \
    F(int, fmi2GetEventIndicators, Component, double *, size_t)                                                                                \
    F(int, fmi2GetContinuousStates, Component, double *, size_t)

FUNCTIONS(FUNCTION)

#define EXPECT(condition)                                                                                                                      \
    do {                                                                                                                                       \
        if (!(condition)) {                                                                                                                    \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                                                                    \
            exit(1);                                                                                                                           \
        }                                                                                                                                      \
    } while (0)

static void load(const char *path) {
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
#define LOOK_UP(result, name, ...)                                                                                                             \
    *(void **)&name = dlsym(library, #name);                                                                                                   \
    EXPECT(name);
    FUNCTIONS(LOOK_UP)
}

/* The message is a format, as the standard has it: printed into a place of its own, so that what is missing shows. */
static void logger(void *environment, const char *name, int status, const char *category, const char *message, ...) {
    char text[4096];
    va_list arguments;
    (void)environment;
    va_start(arguments, message);
    vsnprintf(text, sizeof text, message, arguments);
    va_end(arguments);
    EXPECT(strlen(name) && strlen(category) && strlen(text) && status >= 0 && status <= 4);
    messages++;
    if (freed_in_logger) {
        Component gone = freed_in_logger;
        freed_in_logger = NULL;
        fmi2FreeInstance(gone);
    }
}

static const Callbacks callbacks = {logger, calloc, free, NULL, NULL};

static Component initialized(const char *guid, int kind) {
    Component made = fmi2Instantiate("c", kind, guid, "file:///nowhere", &callbacks, 0, 1);
    EXPECT(made);
    EXPECT(fmi2SetupExperiment(made, 0, 0.0, 0.0, 0, 0.0) == 0);
    EXPECT(fmi2EnterInitializationMode(made) == 0);
    EXPECT(fmi2ExitInitializationMode(made) == 0);
    return made;
}

static void refused(int status) {
    EXPECT(status > 1 && status < 4);
    refusals++;
}

enum { VARIABLES = 80, STATES = 7, INDICATORS = 64 };

static void co_simulation(const char *guid) {
    Component one = initialized(guid, 1);
    unsigned command = 0;
    double *values = malloc(VARIABLES * sizeof *values);
    for (int step = 0; step < 200; step++) {
        double value = sin(0.1 * step);
        EXPECT(fmi2SetReal(one, &command, 1, &value) == 0);
        EXPECT(fmi2DoStep(one, 0.005 * step, 0.005, 0) <= 1);
    }
    /* Every reference on its own: those of other types are refused. */
    for (unsigned reference = 0; reference < VARIABLES; reference++) {
        int whole;
        int real = fmi2GetReal(one, &reference, 1, values), integer = fmi2GetInteger(one, &reference, 1, &whole);
        EXPECT(real <= 3 && integer <= 3);
        double seed = 1.0;
        int derivative = fmi2GetDirectionalDerivative(one, &reference, 1, &command, 1, &seed, values);
        EXPECT(derivative <= 3);
        double wrong[] = {NAN, INFINITY, -1e300, 5e-324};
        for (int which = 0; which < 2; which++) refused(fmi2SetReal(one, &reference, 1, &wrong[which]));
    }
    void *state = NULL;
    size_t size = 0;
    EXPECT(fmi2GetFMUstate(one, &state) == 0 && fmi2SerializedFMUstateSize(one, state, &size) == 0);
    char *bytes = malloc(size);
    EXPECT(fmi2SerializeFMUstate(one, state, bytes, size) == 0);
    refused(fmi2SerializeFMUstate(one, state, bytes, size - 1));
    for (size_t place = 0; place < size; place++) {
        void *other = NULL;
        bytes[place] ^= 1;
        refused(fmi2DeSerializeFMUstate(one, bytes, size, &other));
        bytes[place] ^= 1;
        refused(fmi2DeSerializeFMUstate(one, bytes, place, &other));
    }
    EXPECT(fmi2DeSerializeFMUstate(one, bytes, size, &state) == 0 && fmi2SetFMUstate(one, state) == 0);
    EXPECT(fmi2FreeFMUstate(one, &state) == 0 && state == NULL);
    refused(fmi2SetFMUstate(one, (void *)(uintptr_t)12345));
    refused(fmi2GetReal(one, NULL, 1, values));
    refused(fmi2GetReal(NULL, &command, 1, values));
    int order = 1;
    double slope = 2.0;
    EXPECT(fmi2SetRealInputDerivatives(one, &command, 1, &order, &slope) == 0);
    EXPECT(fmi2Terminate(one) == 0 && fmi2Reset(one) == 0);
    freed_in_logger = one;
    refused(fmi2DoStep(one, NAN, NAN, 0));
    EXPECT(!freed_in_logger);
    refused(fmi2DoStep(one, 0.0, 0.1, 0));
    free(bytes);
    free(values);
}

static void model_exchange(const char *guid) {
    Component one = initialized(guid, 0);
    double states[STATES], derivatives[STATES], *indicators = malloc(INDICATORS * sizeof *indicators);
    char info[32];
    size_t number = 0;
    EXPECT(fmi2NewDiscreteStates(one, info) == 0 && fmi2EnterContinuousTimeMode(one) == 0);
    while (number <= INDICATORS && fmi2GetEventIndicators(one, indicators, number) != 0) number++;
    EXPECT(number <= INDICATORS);
    EXPECT(fmi2GetContinuousStates(one, states, STATES) == 0);
    for (int step = 1; step < 200; step++) {
        int enter, terminate;
        EXPECT(fmi2SetTime(one, 1e-4 * step) == 0 && fmi2GetDerivatives(one, derivatives, STATES) == 0);
        for (int state = 0; state < STATES; state++) states[state] += 1e-4 * derivatives[state];
        EXPECT(fmi2SetContinuousStates(one, states, STATES) == 0);
        EXPECT(fmi2CompletedIntegratorStep(one, 1, &enter, &terminate) == 0);
    }
    free(indicators);
    fmi2FreeInstance(one);
    fmi2FreeInstance(one);
}

int main(int count, char **arguments) {
    if (count != 3) {
        fprintf(stderr, "usage: host LIBRARY GUID\n");
        return 2;
    }
    for (int round = 0; round < 3; round++) {
        load(arguments[1]);
        EXPECT(!fmi2Instantiate("c", 1, "another", NULL, &callbacks, 0, 1));
        co_simulation(arguments[2]);
        model_exchange(arguments[2]);
        EXPECT(dlclose(library) == 0);
    }
    printf("%u refusals, %u messages\n", refusals, messages);
    return 0;
}
