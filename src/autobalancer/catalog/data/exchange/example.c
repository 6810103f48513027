/* Run the machine of this library for a while and print what it does.

   usage: example [seconds [rows]] */

#include <stdio.h>
#include <stdlib.h>

#include "autobalancer.h"

int main(int argc, char **argv) {
    double end = argc > 1 ? atof(argv[1]) : 1.0;
    size_t rows = argc > 2 ? (size_t)atol(argv[2]) : 11;
    int states = ab_count(AB_STATES), outputs = ab_count(AB_OUTPUTS);

    ab_machine *machine = ab_create();
    double *times = malloc(rows * sizeof *times), *kept = malloc(rows * states * sizeof *kept);
    double *values = malloc(outputs * sizeof *values);
    if (machine == NULL || times == NULL || kept == NULL || values == NULL) {
        fprintf(stderr, "no memory, or a processor without AVX2 and FMA\n");
        return 1;
    }
    for (size_t i = 0; i < rows; i++) times[i] = end * i / (rows - 1);

    /* the states on the way, as in a run of the package */
    int status = ab_run(machine, end, times, rows, kept);
    if (status != AB_OK) {
        fprintf(stderr, "ended with %d at %g s\n", status, ab_time(machine));
        return 1;
    }
    printf("# time");
    for (int k = 0; k < states; k++) printf(" %s", ab_list(AB_STATES)[k].name);
    printf("\n");
    for (size_t i = 0; i < rows; i++) {
        printf("%.17g", times[i]);
        for (int k = 0; k < states; k++) printf(" %.17g", kept[i * states + k]);
        printf("\n");
    }

    /* what is seen at the end */
    ab_outputs(machine, values);
    for (int k = 0; k < outputs; k++)
        printf("# %s = %.17g %s\n", ab_list(AB_OUTPUTS)[k].name, values[k], ab_list(AB_OUTPUTS)[k].unit);
    printf("# %lld steps\n", (long long)ab_steps_taken(machine));

    ab_free(machine);
    free(times), free(kept), free(values);
    return 0;
}
