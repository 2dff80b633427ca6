/* One loop for two units: loads both libraries, drives each through the same C code in turns, and prints quartiles: a name, then first
 * quartile, median and third quartile of the FMU [ns], then those of the unit in C (0 where it cannot do that).
 *
 * loop FMU.so GUID PEER.so rate_limit.up rate_limit.down backlash.gap delay.time      (value references of the FMU)
 * loop FMU.so GUID cost [REFERENCE VALUE]...     a step with these parameters set: quartiles [ns]
 * loop FMU.so GUID instances N        N instances that are alive at once: ns for a life, ns for a step of each in turn
 * loop FMU.so GUID steps N            N linear steps and nothing else, to count instructions
 * loop FMU.so GUID states N           N times get and set of a state, likewise
 * loop FMU.so GUID effects N up down gap    N steps with rate limit and backlash, likewise */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

typedef struct {
    void *(*instantiate)(const char *, int, const char *, const char *, const void *, int, int);
    void (*free_instance)(void *);
    int (*setup)(void *, int, double, double, int, double);
    int (*enter)(void *), (*exit)(void *), (*terminate)(void *);
    int (*set)(void *, const unsigned *, size_t, const double *);
    int (*get)(void *, const unsigned *, size_t, double *);
    int (*step)(void *, double, double, int);
    int (*get_state)(void *, void **), (*set_state)(void *, void *), (*free_state)(void *, void **);
    const char *guid;
} Unit;

static const unsigned COMMAND = 0, POSITION = 3;
#define STEPS 4000
#define ROUNDS 41
#define SCALING_ROUNDS 15
#define COST_ROUNDS 7
#define MOST_PARAMETERS 64
static double commands[STEPS];
static const double LIMITS[3] = {60.0, 60.0, 0.5}; /* of the rate upwards and downwards, and of the play */

static void ok(int status, const char *what) {
    if (status != 0) {
        fprintf(stderr, "%s returned %d\n", what, status);
        exit(1);
    }
}
static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return found;
}
static Unit load(const char *path, const char *guid) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    Unit u;
    *(void **)&u.instantiate = symbol(library, "fmi2Instantiate");
    *(void **)&u.free_instance = symbol(library, "fmi2FreeInstance");
    *(void **)&u.setup = symbol(library, "fmi2SetupExperiment");
    *(void **)&u.enter = symbol(library, "fmi2EnterInitializationMode");
    *(void **)&u.exit = symbol(library, "fmi2ExitInitializationMode");
    *(void **)&u.terminate = symbol(library, "fmi2Terminate");
    *(void **)&u.set = symbol(library, "fmi2SetReal");
    *(void **)&u.get = symbol(library, "fmi2GetReal");
    *(void **)&u.step = symbol(library, "fmi2DoStep");
    *(void **)&u.get_state = symbol(library, "fmi2GetFMUstate");
    *(void **)&u.set_state = symbol(library, "fmi2SetFMUstate");
    *(void **)&u.free_state = symbol(library, "fmi2FreeFMUstate");
    u.guid = guid;
    return u;
}
static double read_clock(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec * 1e9 + t.tv_nsec;
}
/* Processor time of this thread: what else the computer does is not in it. */
static double now(void) { return read_clock(CLOCK_THREAD_CPUTIME_ID); }
static void *start(const Unit *u, size_t n, const unsigned *references, const double *values) {
    void *c = u->instantiate("timed", 1, u->guid, NULL, NULL, 0, 0);
    if (!c) {
        fprintf(stderr, "not instantiated\n");
        exit(1);
    }
    ok(u->setup(c, 0, 0.0, 0.0, 0, 0.0), "fmi2SetupExperiment");
    ok(u->enter(c), "fmi2EnterInitializationMode");
    if (n) ok(u->set(c, references, n, values), "fmi2SetReal");
    ok(u->exit(c), "fmi2ExitInitializationMode");
    return c;
}
static void end(const Unit *u, void *c) {
    ok(u->terminate(c), "fmi2Terminate");
    u->free_instance(c);
}

/* ns per set + step + get. */
static double stepping(const Unit *u, size_t n, const unsigned *references, const double *values, double h, double *sum) {
    void *c = start(u, n, references, values);
    double out = 0.0, begin = 0.0;
    for (int pass = 0; pass < 2; pass++) { /* the first one warms up */
        begin = now();
        for (int i = 0; i < STEPS; i++) {
            int status = u->set(c, &COMMAND, 1, &commands[i]);
            status |= u->step(c, (pass * STEPS + i) * h, h, 1);
            status |= u->get(c, &POSITION, 1, &out);
            if (status) ok(status, "a call of the loop");
            *sum += out;
        }
    }
    double ns = (now() - begin) / STEPS;
    end(u, c);
    return ns;
}
/* ns per get + set of a state, into the same object. */
static double states(const Unit *u) {
    void *c = start(u, 0, NULL, NULL), *state = NULL;
    ok(u->step(c, 0.0, 0.005, 1), "fmi2DoStep");
    ok(u->get_state(c, &state), "fmi2GetFMUstate");
    double begin = now();
    for (int i = 0; i < STEPS; i++) {
        int status = u->get_state(c, &state);
        status |= u->set_state(c, state);
        if (status) ok(status, "a state function");
    }
    double ns = (now() - begin) / STEPS;
    ok(u->free_state(c, &state), "fmi2FreeFMUstate");
    end(u, c);
    return ns;
}
static double lives(const Unit *u) {
    const int count = 400;
    double begin = now();
    for (int i = 0; i < count; i++) end(u, start(u, 0, NULL, NULL));
    return (now() - begin) / count;
}

typedef struct {
    const Unit *unit;
    void *component;
    pthread_barrier_t *barrier;
    double ns, sum;
} Job;
static void *job(void *argument) {
    Job *j = argument;
    double out = 0.0, sum = 0.0;
    pthread_barrier_wait(j->barrier);
    double begin = read_clock(CLOCK_MONOTONIC); /* what is asked here is how long it takes */
    for (int i = 0; i < 50 * STEPS; i++) {
        int status = j->unit->set(j->component, &COMMAND, 1, &commands[i % STEPS]);
        status |= j->unit->step(j->component, i * 0.005, 0.005, 1);
        status |= j->unit->get(j->component, &POSITION, 1, &out);
        if (status) ok(status, "a call of the loop");
        sum += out;
    }
    j->ns = read_clock(CLOCK_MONOTONIC) - begin;
    j->sum = sum;
    return NULL;
}
/* ns that `count` threads take for as many instances, each its own. */
static double threads(const Unit *u, int count) {
    pthread_t ids[2];
    Job jobs[2];
    pthread_barrier_t barrier;
    pthread_barrier_init(&barrier, NULL, count);
    for (int i = 0; i < count; i++) {
        jobs[i] = (Job){u, start(u, 0, NULL, NULL), &barrier, 0.0, 0.0};
        pthread_create(&ids[i], NULL, job, &jobs[i]);
    }
    double longest = 0.0;
    for (int i = 0; i < count; i++) {
        pthread_join(ids[i], NULL);
        end(u, jobs[i].component);
        longest = jobs[i].ns > longest ? jobs[i].ns : longest;
    }
    pthread_barrier_destroy(&barrier);
    return longest;
}
/* The same by two processes, which share nothing: what the two processors allow. */
static double processes(const Unit *u) {
    struct {
        pthread_barrier_t barrier;
        double ns[2];
    } *shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    pthread_barrierattr_t attributes;
    pthread_barrierattr_init(&attributes);
    pthread_barrierattr_setpshared(&attributes, PTHREAD_PROCESS_SHARED);
    pthread_barrier_init(&shared->barrier, &attributes, 2);
    for (int i = 0; i < 2; i++) {
        if (fork() == 0) {
            Job j = {u, start(u, 0, NULL, NULL), &shared->barrier, 0.0, 0.0};
            job(&j);
            shared->ns[i] = j.ns;
            _exit(0);
        }
    }
    while (wait(NULL) > 0) {}
    double longest = shared->ns[0] > shared->ns[1] ? shared->ns[0] : shared->ns[1];
    pthread_barrier_destroy(&shared->barrier);
    munmap(shared, sizeof *shared);
    return longest;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
static void print_quartiles(const double *values, int count) {
    double sorted[ROUNDS];
    memcpy(sorted, values, count * sizeof(double));
    qsort(sorted, count, sizeof(double), ascending);
    printf("\t%.3f\t%.3f\t%.3f", sorted[count / 4], sorted[count / 2], sorted[3 * count / 4]);
}

/* Steps per time by two threads and by two processes, each with an instance of its own, in those of one thread. */
static void scaling(const Unit *u, double *by_threads, double *by_processes) {
    for (int r = 0; r < SCALING_ROUNDS; r++) {
        const double one = threads(u, 1);
        by_threads[r] = 2.0 * one / threads(u, 2);
        by_processes[r] = 2.0 * one / processes(u);
    }
}

/* Costs of one parameter set, and of many instances: what grows. */
static int cost(const Unit *u, int argc, char **argv) {
    unsigned references[MOST_PARAMETERS];
    double values[MOST_PARAMETERS], rounds[ROUNDS], sum = 0.0;
    const int count = (argc - 4) / 2;
    if (count > MOST_PARAMETERS) return 1;
    for (int i = 0; i < count; i++) {
        references[i] = atoi(argv[4 + 2 * i]);
        values[i] = atof(argv[5 + 2 * i]);
    }
    for (int r = 0; r < COST_ROUNDS; r++) rounds[r] = stepping(u, count, references, values, 0.005, &sum);
    printf("cost");
    print_quartiles(rounds, COST_ROUNDS);
    printf("\n");
    return sum == sum ? 0 : 1;
}
static int instances(const Unit *u, int count) {
    void **all = malloc(count * sizeof(void *));
    const int steps = 2000000 / count + 2;
    end(u, start(u, 0, NULL, NULL)); /* what is worked out once for all */
    double out = 0.0, begin = now(), ns = 0.0, stepped;
    for (int i = 0; i < count; i++) all[i] = start(u, 0, NULL, NULL);
    ns = now() - begin;
    begin = now();
    for (int n = 0; n < steps; n++) {
        for (int i = 0; i < count; i++) {
            int status = u->set(all[i], &COMMAND, 1, &commands[n % STEPS]);
            status |= u->step(all[i], n * 0.005, 0.005, 1);
            status |= u->get(all[i], &POSITION, 1, &out);
            if (status) ok(status, "a call of the loop");
        }
    }
    stepped = (now() - begin) / ((double)steps * count);
    begin = now();
    for (int i = 0; i < count; i++) end(u, all[i]);
    printf("instances\t%.3f\t%.3f\n", (ns + now() - begin) / count, stepped);
    free(all);
    return 0;
}

int main(int argc, char **argv) {
    unsigned long long random = 88172645463325252ULL; /* xorshift: the same commands in every run */
    for (int i = 0; i < STEPS; i++) {
        random ^= random << 13, random ^= random >> 7, random ^= random << 17;
        commands[i] = 16.0 * ((random >> 11) * 0x1p-53 - 0.5);
    }
    Unit fmu = load(argv[1], argv[2]);
    double sum = 0.0;
    if (strcmp(argv[3], "cost") == 0) return cost(&fmu, argc, argv);
    if (argc == 5 && strcmp(argv[3], "instances") == 0) return instances(&fmu, atoi(argv[4]));
    if (argc >= 5 && strcmp(argv[3], "states") == 0) {
        void *c = start(&fmu, 0, NULL, NULL), *state = NULL;
        ok(fmu.step(c, 0.0, 0.005, 1), "fmi2DoStep");
        for (int i = atoi(argv[4]); i >= 0; i--) {
            ok(fmu.get_state(c, &state), "fmi2GetFMUstate");
            ok(fmu.set_state(c, state), "fmi2SetFMUstate");
        }
        return 0;
    }
    if (argc >= 5 && (strcmp(argv[3], "steps") == 0 || strcmp(argv[3], "effects") == 0)) {
        const int effects = argc == 8 ? 3 : 0;
        unsigned parameters[3] = {0, 0, 0};
        for (int i = 0; i < effects; i++) parameters[i] = atoi(argv[5 + i]);
        void *c = start(&fmu, effects, parameters, LIMITS);
        double out = 0.0;
        const int count = atoi(argv[4]);
        for (int i = 0; i < count; i++) {
            ok(fmu.set(c, &COMMAND, 1, &commands[i % STEPS]), "fmi2SetReal");
            ok(fmu.step(c, i * 0.005, 0.005, 1), "fmi2DoStep");
            ok(fmu.get(c, &POSITION, 1, &out), "fmi2GetReal");
        }
        return 0;
    }
    Unit peer = load(argv[3], "");
    unsigned limits[3] = {atoi(argv[4]), atoi(argv[5]), atoi(argv[6])}, delay = atoi(argv[7]);
    const double delay_value = 10.0;
    static double rounds[9][ROUNDS];
    for (int r = 0; r < ROUNDS; r++) {
        rounds[0][r] = stepping(&fmu, 0, NULL, NULL, 0.005, &sum);
        rounds[1][r] = stepping(&peer, 0, NULL, NULL, 0.005, &sum);
        rounds[2][r] = states(&fmu);
        rounds[3][r] = states(&peer);
        rounds[4][r] = lives(&fmu);
        rounds[5][r] = lives(&peer);
        rounds[6][r] = stepping(&fmu, 3, limits, LIMITS, 0.005, &sum);
        rounds[7][r] = stepping(&fmu, 1, &delay, &delay_value, 0.001, &sum);
    }
    static double alone[4][SCALING_ROUNDS];
    scaling(&fmu, alone[0], alone[2]);
    scaling(&peer, alone[1], alone[3]);
    static const double none[1] = {0.0};
    const struct {
        const char *name;
        const double *own, *other;
        int rounds, other_rounds;
    } rows[] = {
        {"step", rounds[0], rounds[1], ROUNDS, ROUNDS},
        {"state", rounds[2], rounds[3], ROUNDS, ROUNDS},
        {"life", rounds[4], rounds[5], ROUNDS, ROUNDS},
        {"effects", rounds[6], none, ROUNDS, 1},
        {"delay", rounds[7], none, ROUNDS, 1},
        {"threads", alone[0], alone[1], SCALING_ROUNDS, SCALING_ROUNDS},
        {"processes", alone[2], alone[3], SCALING_ROUNDS, SCALING_ROUNDS},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        printf("%s", rows[i].name);
        print_quartiles(rows[i].own, rows[i].rounds);
        print_quartiles(rows[i].other, rows[i].other_rounds);
        printf("\n");
    }
    return sum == sum ? 0 : 1;
}
