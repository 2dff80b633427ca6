/* Steps all 17 sets of BactActuator.dll and prints the bits of every position: a host as small as one can be, for systems on which
   no importer is at hand. `step_all_sets LIBRARY GUID STEPS COMMAND POSITION SET_NUMBER`, the last three
   being value references; test_platforms.py compiles it and knows the same commands. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger log; void *(*allocate)(size_t, size_t); void (*release)(void *); void (*finished)(void *, int); void *host; } Callbacks;

enum { OK = 0, CO_SIMULATION = 1, SETS = 17 };
static const double STEP_S = 0.005;

static void print_message(void *host, const char *instance, int status, const char *category, const char *message, ...) {
    fprintf(stderr, "%s: %d %s: %s\n", instance, status, category, message);
}

static void expect(int holds, const char *what) {
    if (!holds) { fprintf(stderr, "%s failed\n", what); exit(1); }
}

/* Every value of a step has an exact double: multiples of 1/200 deg between -5 and 5. */
static double command(int set, int step) { return ((step * 7919 + set * 104729) % 2001 - 1000) / 200.0; }

int main(int count, char **arguments) {
    expect(count == 7, "LIBRARY GUID STEPS COMMAND POSITION SET_NUMBER");
    HMODULE library = LoadLibraryA(arguments[1]);
    if (!library) { fprintf(stderr, "%s does not load: error %lu\n", arguments[1], GetLastError()); return 2; }
#define FUNCTION(result, name, ...) \
    result (*name)(__VA_ARGS__) = (result (*)(__VA_ARGS__))(void *)GetProcAddress(library, "fmi2" #name); \
    expect(name != NULL, #name)
    FUNCTION(void *, Instantiate, const char *, int, const char *, const char *, const Callbacks *, int, int);
    FUNCTION(int, SetupExperiment, void *, int, double, double, int, double);
    FUNCTION(int, EnterInitializationMode, void *);
    FUNCTION(int, ExitInitializationMode, void *);
    FUNCTION(int, SetInteger, void *, const unsigned *, size_t, const int *);
    FUNCTION(int, SetReal, void *, const unsigned *, size_t, const double *);
    FUNCTION(int, GetReal, void *, const unsigned *, size_t, double *);
    FUNCTION(int, DoStep, void *, double, double, int);
    FUNCTION(int, Terminate, void *);
    FUNCTION(void, FreeInstance, void *);
    const Callbacks callbacks = {print_message, calloc, free, NULL, NULL};
    const unsigned command_reference = atoi(arguments[4]), position_reference = atoi(arguments[5]);
    const unsigned set_reference = atoi(arguments[6]);
    const int steps = atoi(arguments[3]);
    for (int set = 1; set <= SETS; set++) {
        void *slave = Instantiate("actuator", CO_SIMULATION, arguments[2], "", &callbacks, 0, 0);
        expect(slave != NULL, "fmi2Instantiate");
        expect(SetInteger(slave, &set_reference, 1, &set) == OK, "fmi2SetInteger");
        expect(SetupExperiment(slave, 0, 0.0, 0.0, 0, 0.0) == OK, "fmi2SetupExperiment");
        expect(EnterInitializationMode(slave) == OK && ExitInitializationMode(slave) == OK, "initialization");
        for (int step = 0; step < steps; step++) {
            double value = command(set, step);
            expect(SetReal(slave, &command_reference, 1, &value) == OK, "fmi2SetReal");
            expect(DoStep(slave, step * STEP_S, STEP_S, 1) == OK, "fmi2DoStep");
            expect(GetReal(slave, &position_reference, 1, &value) == OK, "fmi2GetReal");
            unsigned long long bits;
            memcpy(&bits, &value, sizeof bits);
            printf("%08x%08x\n", (unsigned)(bits >> 32), (unsigned)bits);
        }
        expect(Terminate(slave) == OK, "fmi2Terminate");
        FreeInstance(slave);
    }
    return 0;
}
