/* Times evaluate() of another file: CPU time of one call, over and over at the points given.
 *
 * stdin:  n_inputs n_outputs n_points n_samples n_calls, then the points one after the other
 * stdout: JSON, {"outputs": all outputs at all points, "samples": seconds per call} */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

void evaluate(const double *inputs, double *outputs);

static double cpu_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int main(void) {
    int n_in, n_out, n_points, n_samples, n_calls;
    if (scanf("%d %d %d %d %d", &n_in, &n_out, &n_points, &n_samples, &n_calls) != 5) return 1;
    double *points = malloc(sizeof(double) * (size_t)n_in * (size_t)n_points);
    double *out = malloc(sizeof(double) * (size_t)n_out);
    if (points == NULL || out == NULL) return 1;
    for (int i = 0; i < n_in * n_points; i++) {
        if (scanf("%lf", &points[i]) != 1) return 1;
    }
    printf("{\"outputs\": [");
    for (int p = 0; p < n_points; p++) {
        evaluate(points + p * n_in, out);
        for (int i = 0; i < n_out; i++) printf("%s%.17g", p + i ? ", " : "", out[i]);
    }
    printf("], \"samples\": [");
    for (int sample = 0; sample < n_samples; sample++) {
        double start = cpu_time();
        int p = 0;
        for (int call = 0; call < n_calls; call++) {
            evaluate(points + p * n_in, out);
            p = p + 1 == n_points ? 0 : p + 1;
        }
        printf("%s%.6e", sample ? ", " : "", (cpu_time() - start) / n_calls);
    }
    printf("]}\n");
    free(points);
    free(out);
    return 0;
}
