// A host in C++ whose logger throws. The exception must reach the host's own handler, and the instance must be usable after it.
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <stdexcept>

struct Callbacks {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
};

static void throwing(void *, const char *, int, const char *, const char *message, ...) { throw std::runtime_error(message); }

template <typename Function> Function symbol(void *library, const char *name) {
    return reinterpret_cast<Function>(dlsym(library, name));
}

int main(int, char **arguments) {
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return std::puts(dlerror()), 1;
    auto instantiate =
        symbol<void *(*)(const char *, int, const char *, const char *, const Callbacks *, int, int)>(library, "fmi2Instantiate");
    auto enter = symbol<int (*)(void *)>(library, "fmi2EnterInitializationMode");
    auto exit_mode = symbol<int (*)(void *)>(library, "fmi2ExitInitializationMode");
    auto step = symbol<int (*)(void *, double, double, int)>(library, "fmi2DoStep");
    auto release = symbol<void (*)(void *)>(library, "fmi2FreeInstance");
    const Callbacks callbacks = {throwing, std::calloc, std::free, nullptr, nullptr};
    int caught = 0;
    try {
        instantiate("wrong", 1, "another GUID", nullptr, &callbacks, 0, 0);
    } catch (const std::runtime_error &) {
        caught++;
    }
    void *instance = instantiate("right", 1, arguments[2], nullptr, &callbacks, 0, 0);
    if (!instance || enter(instance) || exit_mode(instance)) return std::puts("not initialized"), 1;
    for (int round = 0; round < 3; round++) {
        try {
            step(instance, 0.0, -1.0, 1);
        } catch (const std::runtime_error &) {
            caught++;
        }
    }
    const int status = step(instance, 0.0, 0.005, 1);
    release(instance);
    std::printf("caught %d, then status %d\n", caught, status);
    return 0;
}
