/* SPDX-License-Identifier: Apache-2.0
 *
 * The floor of a co-simulation: the doSteps of two FMUs and nothing else.
 */
#include <stdbool.h>

typedef int (*DoStep2)(void *, double, double, int);
typedef int (*DoStep3)(void *, double, double, bool, bool *, bool *, bool *, double *);

int floor2(void *const *instances, DoStep2 const *steps, long n, double h) {
    for (long k = 0; k < n; k++) {
        const double t = (double)k * h;
        for (int i = 0; i < 2; i++) {
            if (steps[i](instances[i], t, h, 1)) return 1;
        }
    }
    return 0;
}

int floor3(void *const *instances, DoStep3 const *steps, long n, double h) {
    for (long k = 0; k < n; k++) {
        const double t = (double)k * h;
        for (int i = 0; i < 2; i++) {
            bool event, terminate, early;
            double reached;
            if (steps[i](instances[i], t, h, true, &event, &terminate, &early, &reached)) return 1;
        }
    }
    return 0;
}
