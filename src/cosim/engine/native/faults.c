/* SPDX-License-Identifier: Apache-2.0
 *
 * What memory an FMU has used wrongly when it takes its process down; the signal alone does not tell.
 */
#ifdef _WIN32
EXPORT void cosim_note_faults(Fault *fault) { (void)fault; }
#else
#include <signal.h>
#include <sys/resource.h>

#define FAR_BEYOND 0x100000 /* an overflow is met up to so many bytes beyond the end of the stack, or before it */
#define ROOM 0x10000        /* for the handler, which cannot run on a stack that has no room */

static Fault *noted;
static uintptr_t stack_end; /* about; 0: unknown */

static void note(int number, siginfo_t *info, void *context) {
    (void)context;
    const uintptr_t address = (uintptr_t)info->si_addr;
    noted->address = address;
    noted->kind = stack_end && address - (stack_end - FAR_BEYOND) < 2 * FAR_BEYOND ? STACK_OVERFLOW : WRONG_ADDRESS;
    raise(number); /* again, and without this handler, as soon as it has returned */
}

/* From now on the fault that ends this process is noted there, if it happens in this thread. */
EXPORT void cosim_note_faults(Fault *fault) {
    static char room[ROOM];
    const stack_t stack = {.ss_sp = room, .ss_size = sizeof room};
    struct sigaction action = {.sa_sigaction = note, .sa_flags = (int)(SA_SIGINFO | SA_ONSTACK | SA_RESETHAND)};
    struct rlimit limit;
    noted = fault;
    if (getrlimit(RLIMIT_STACK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
        stack_end = (uintptr_t)&limit - (uintptr_t)limit.rlim_cur;
    }
    sigemptyset(&action.sa_mask);
    if (sigaltstack(&stack, NULL) == 0) {
        sigaction(SIGSEGV, &action, NULL);
        sigaction(SIGBUS, &action, NULL);
    }
}
#endif
