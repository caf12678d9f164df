/* SPDX-License-Identifier: MIT-0
 *
 * y = t. At the moment that the environment variable CRASH names ("DoStep segmentation"), it does what no FMU may do to
 * its importer. In a step that is the one which passes t = 0.05 s.
 */
#define AT(moment) crash_at(moment)
static void crash_at(const char *moment);
#include "shell.h"

#include <signal.h>
#ifdef _WIN32
#include <windows.h>
#include <io.h>
#define pause() Sleep(INFINITE)
#define fork() 1
#define SIGSTOP SIGABRT
#else
#include <unistd.h>
#endif

enum { Y = 1 };

static volatile int zero;

static int nest(int depth) {
    volatile char room[4096];
    room[0] = (char)depth;
    return depth + nest(depth + 1) + room[0];
}

static void hog(void) {
    const size_t size = 1u << 24;
    for (volatile char *block; (block = malloc(size));) {
        for (size_t i = 0; i < size; i += 4096) block[i] = 1;
    }
    abort();
}

static void do_it(const char *what) {
    if (strcmp(what, "segmentation") == 0) *(volatile int *)(size_t)zero = 1;
    if (strcmp(what, "abort") == 0) abort();
    if (strcmp(what, "exit") == 0) exit(7);
    if (strcmp(what, "success") == 0) exit(0);
    if (strcmp(what, "division") == 0) zero = 100 / zero;
    if (strcmp(what, "instruction") == 0) raise(SIGILL);
    if (strcmp(what, "recursion") == 0) zero = nest(0);
    if (strcmp(what, "memory") == 0) hog();
    if (strcmp(what, "hang") == 0) for (;;) pause();
    if (strcmp(what, "spin") == 0) for (;;) zero = 0;
    if (strcmp(what, "channels") == 0) {
        for (int channel = 3; channel < 64; channel++) {
            if (write(channel, "nonsense nonsense", 17) < 0 || close(channel)) continue;
        }
        abort();
    }
    if (strcmp(what, "orphan") == 0) {
        const int child = fork();
        if (child == 0) for (;;) pause();
        printf("%d\n", child);
        fflush(stdout);
        abort();
    }
    if (strcmp(what, "touch") == 0) {
        fclose(fopen(getenv("CRASH_FILE"), "w"));
        for (;;) pause();
    }
    if (strcmp(what, "stop") == 0) raise(SIGSTOP);
    if (strcmp(what, "print") == 0) printf("printed by an FMU\n");
}

static void crash_at(const char *moment) {
    const char *wanted = getenv("CRASH");
    const size_t length = strlen(moment);
    if (wanted && strncmp(wanted, moment, length) == 0 && wanted[length] == ' ') do_it(wanted + length + 1);
}

__attribute__((constructor)) static void loaded(void) { crash_at("loading"); }
__attribute__((destructor)) static void unloaded(void) { crash_at("unloading"); }

static void start(Model *m) {}
static int event(Model *m) { return OK; }
static void outputs(Model *m) {}

static int step(Model *m, double h) {
    m->v[Y] = m->time + h;
    if (m->v[Y] < 0.05 - 1e-9) return OK;
    if (getenv("CRASH_SAYS")) say(m, "this will not end well");
    crash_at("DoStep");
    return OK;
}
