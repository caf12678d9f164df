/* SPDX-License-Identifier: MIT-0
 *
 * The least that a fixed-step Jacobi loop of two FMI 2.0 FMUs in a ring can do: exchange one number each way, step both.
 */
#include <stddef.h>

typedef int (*DoStep)(void *, double, double, int);
typedef int (*Access)(void *, const unsigned *, size_t, double *);

int ring(void *const *instances, DoStep const *steps, Access const *gets, Access const *sets, const unsigned *outputs,
         const unsigned *inputs, long n, double h) {
    for (long k = 0; k < n; k++) {
        double value[2];
        for (int i = 0; i < 2; i++) {
            if (gets[i](instances[i], outputs + i, 1, value + i)) return 1;
        }
        for (int i = 0; i < 2; i++) {
            if (sets[i](instances[i], inputs + i, 1, value + 1 - i)) return 1;
        }
        for (int i = 0; i < 2; i++) {
            if (steps[i](instances[i], (double)k * h, h, 1)) return 1;
        }
    }
    return 0;
}
