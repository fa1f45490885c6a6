/* Right-hand side for DOP853, y = (q, v): q' = v, v' from the multiplier system, as Fortran calls
 * it. A shared library; peers/dop853.py hands its functions to the solver. */
#include <time.h>
#include PROBLEM

static double started;
static long n_calls;

static double cpu_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void rhs(const int *n, const double *t, const double *y, double *out, double *rpar, int *ipar) {
    (void)n, (void)rpar, (void)ipar;
    /* The clock starts with the first call: what Python does before it does not count. */
    if (n_calls++ == 0) started = cpu_time();
    struct terms at;
    double lambda[NC];
    terms(*t, y, y + NQ, &at);
    memcpy(out, y + NQ, sizeof(double) * NQ);
    accelerations(&at, out + NQ, lambda);
}

void solout(void) {}

/* To be called right before a run. */
void reset(void) { n_calls = 0; }

/* CPU seconds since the first call of the right-hand side. */
double elapsed(void) { return cpu_time() - started; }

int n_positions(void) { return NQ; }
int n_constraints(void) { return NC; }

void multipliers(double t, const double *y, double *lambda) {
    struct terms at;
    double a[NQ];
    terms(t, y, y + NQ, &at);
    accelerations(&at, a, lambda);
}
