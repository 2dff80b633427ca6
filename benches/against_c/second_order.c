/* A second-order actuator as a minimal FMI 2.0 unit, written by hand: the peer that the packaged FMU is timed against.
 *
 *   y'' = w^2 (k u - y) - 2 z w y'        exactly over a step, with the transition computed once for a step size
 *
 * It checks nothing, logs nothing and saves a state by copying it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double command, position, rate;
    double step, a, b, c, d; /* transition of (position - k command, rate) over `step` */
    double time;
} Unit;

static const double K = 1.0, OMEGA = 120.0, ZETA = 0.7; /* as benches/table/fmu.py sets them in the FMU to compare outputs */

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, const void *functions, int visible, int logging) {
    return calloc(1, sizeof(Unit));
}
void fmi2FreeInstance(void *unit) { free(unit); }
int fmi2SetupExperiment(void *unit, int tolerance_defined, double tolerance, double start, int stop_defined, double stop) {
    ((Unit *)unit)->time = start;
    return 0;
}
int fmi2EnterInitializationMode(void *unit) { return 0; }
int fmi2ExitInitializationMode(void *unit) { return 0; }
int fmi2Terminate(void *unit) { return 0; }

int fmi2SetReal(void *unit, const unsigned *references, size_t n, const double *values) {
    for (size_t i = 0; i < n; i++) {
        if (references[i] != 0) return 3;
        ((Unit *)unit)->command = values[i];
    }
    return 0;
}
int fmi2GetReal(void *unit, const unsigned *references, size_t n, double *values) {
    const Unit *u = unit;
    for (size_t i = 0; i < n; i++) {
        switch (references[i]) {
        case 0: values[i] = u->command; break;
        case 3: values[i] = u->position; break;
        case 5: values[i] = u->rate; break;
        default: return 3;
        }
    }
    return 0;
}
int fmi2DoStep(void *unit, double time, double step, int no_set_state_prior) {
    Unit *u = unit;
    if (step != u->step) {
        double s = ZETA * OMEGA, w = OMEGA * sqrt(1.0 - ZETA * ZETA), e = exp(-s * step);
        double co = e * cos(w * step), si = e * sin(w * step) / w;
        u->step = step;
        u->a = co + s * si;
        u->b = si;
        u->c = -OMEGA * OMEGA * si;
        u->d = co - s * si;
    }
    double target = K * u->command, x = u->position - target, v = u->rate;
    u->position = target + u->a * x + u->b * v;
    u->rate = u->c * x + u->d * v;
    u->time = time + step;
    return 0;
}
int fmi2GetFMUstate(void *unit, void **state) {
    if (!*state) *state = malloc(sizeof(Unit));
    memcpy(*state, unit, sizeof(Unit));
    return 0;
}
int fmi2SetFMUstate(void *unit, void *state) {
    memcpy(unit, state, sizeof(Unit));
    return 0;
}
int fmi2FreeFMUstate(void *unit, void **state) {
    free(*state);
    *state = NULL;
    return 0;
}
