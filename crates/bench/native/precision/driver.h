/* What the drivers share: the start and the tolerances in, the end values and CPU times out.
 *
 * stdin:  t_end, q, v, a, lambda, then n_max enough_s (runs of one tolerance: at most n_max, no
 *         further one after enough_s seconds), then a tolerance per line until the end
 * stdout: JSON, one object per tolerance */
#ifndef DRIVER_H
#define DRIVER_H
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include PROBLEM

struct start {
    double t_end, q[NQ], v[NQ], a[NQ], lambda[NC];
};

struct end {
    double q[NQ], v[NQ], lambda[NC];
    int is_reached;
    long n_step, n_reject, n_residual, n_jacobian, n_factor;
};

/* One run with rtol = atol = tolerance. */
static struct end integrate(const struct start *start, double tolerance);

static double cpu_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void print(const char *name, const double *x, int n) {
    printf(", \"%s\": [", name);
    for (int i = 0; i < n; i++) printf(isfinite(x[i]) ? "%s%.17g" : "%snull", i ? ", " : "", x[i]);
    printf("]");
}

static int measure(void) {
    struct start start;
    int n_max;
    double enough, tolerance;
    double *all = (double *)&start;
    for (size_t i = 0; i < sizeof start / sizeof(double); i++) {
        if (scanf("%lf", &all[i]) != 1) return 1;
    }
    if (scanf("%d %lf", &n_max, &enough) != 2) return 1;
    printf("[");
    for (int row = 0; scanf("%lf", &tolerance) == 1; row++) {
        struct end end;
        double best = INFINITY, spent = 0;
        int n = 0;
        while (n < n_max && (n < 3 || spent < enough)) {
            const double before = cpu_time();
            end = integrate(&start, tolerance);
            const double took = cpu_time() - before;
            best = took < best ? took : best;
            spent += took;
            n++;
        }
        printf("%s{\"tolerance\": %.3e, \"reached\": %s, \"seconds\": %.6e, \"n_runs\": %d",
               row ? ",\n " : "", tolerance, end.is_reached ? "true" : "false", best, n);
        print("q", end.q, NQ);
        print("v", end.v, NQ);
        print("lambda", end.lambda, NC);
        printf(", \"n_step\": %ld, \"n_reject\": %ld, \"n_residual\": %ld, \"n_jacobian\": %ld, "
               "\"n_factor\": %ld}",
               end.n_step, end.n_reject, end.n_residual, end.n_jacobian, end.n_factor);
    }
    printf("]\n");
    return 0;
}
#endif
