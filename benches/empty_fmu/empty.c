/* An FMU for co-simulation that does nothing: what remains of a step through an importer is the importer itself. */
#include <stddef.h>

#define DOES_NOTHING(name)                                                                                                                                     \
    int name(void) { return 0; }

static double numbers[2];
static int instance;

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, const void *functions, int visible, int logging) {
    return &instance;
}
void fmi2FreeInstance(void *unit) {}
int fmi2SetReal(void *unit, const unsigned *references, size_t n, const double *values) {
    for (size_t i = 0; i < n; i++) numbers[references[i]] = values[i];
    return 0;
}
int fmi2GetReal(void *unit, const unsigned *references, size_t n, double *values) {
    for (size_t i = 0; i < n; i++) values[i] = numbers[references[i]];
    return 0;
}
DOES_NOTHING(fmi2SetDebugLogging)
DOES_NOTHING(fmi2SetupExperiment)
DOES_NOTHING(fmi2EnterInitializationMode)
DOES_NOTHING(fmi2ExitInitializationMode)
DOES_NOTHING(fmi2Terminate)
DOES_NOTHING(fmi2Reset)
DOES_NOTHING(fmi2DoStep)
DOES_NOTHING(fmi2CancelStep)
DOES_NOTHING(fmi2GetInteger)
DOES_NOTHING(fmi2GetBoolean)
DOES_NOTHING(fmi2GetString)
DOES_NOTHING(fmi2SetInteger)
DOES_NOTHING(fmi2SetBoolean)
DOES_NOTHING(fmi2SetString)
DOES_NOTHING(fmi2GetFMUstate)
DOES_NOTHING(fmi2SetFMUstate)
DOES_NOTHING(fmi2FreeFMUstate)
DOES_NOTHING(fmi2SerializedFMUstateSize)
DOES_NOTHING(fmi2SerializeFMUstate)
DOES_NOTHING(fmi2DeSerializeFMUstate)
DOES_NOTHING(fmi2GetDirectionalDerivative)
DOES_NOTHING(fmi2SetRealInputDerivatives)
DOES_NOTHING(fmi2GetRealOutputDerivatives)
DOES_NOTHING(fmi2GetStatus)
DOES_NOTHING(fmi2GetRealStatus)
DOES_NOTHING(fmi2GetIntegerStatus)
DOES_NOTHING(fmi2GetBooleanStatus)
DOES_NOTHING(fmi2GetStringStatus)
