/* valgrind knows no membarrier(2), which an instance falls back from. In a program of one thread the barrier has nothing to do: loaded
 * ahead of the C library, this answers that it was passed, so that calls are counted as they are on Linux. */
#include <dlfcn.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/syscall.h>

long syscall(long number, ...) {
    static long (*next)(long, ...) = NULL;
    if (number == SYS_membarrier) return 0;
    if (!next) *(void **)&next = dlsym(RTLD_NEXT, "syscall");
    long more[6];
    va_list given;
    va_start(given, number);
    for (int i = 0; i < 6; i++) more[i] = va_arg(given, long);
    va_end(given);
    return next(number, more[0], more[1], more[2], more[3], more[4], more[5]);
}
