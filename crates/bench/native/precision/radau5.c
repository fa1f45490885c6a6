/* RADAU5 of E. Hairer and G. Wanner in its index-2 form (constraints on velocities), with the exact
 * Jacobian and the rows of q' = v eliminated by the code itself (its options M1, M2).
 *
 *   constant mass: y = (q, v, lambda),    q' = v, M v' = f - G^T lambda, 0 = G v + dg/dt
 *   otherwise:     y = (q, v, a, lambda), q' = v, v' = a, 0 = f - M a - G^T lambda, 0 = G v + dg/dt
 *
 * The Fortran code is that in R's package deSolve, called directly: link with its deSolve.so. */
#include "driver.h"

#define M2 NQ
#if CONSTANT_MASS
#define M1 NQ
#else
#define M1 (2 * NQ)
#endif
#define N (M1 + NQ + NC)
#define ROWS (N - M1)

typedef void function(const int *n, const double *t, const double *y, double *out, double *, int *);
/* deSolve puts the bandwidths before the matrix. */
typedef void jacobian(const int *n, const double *t, const double *y, const int *lower,
                      const int *upper, double *out, const int *rows, double *, int *);
typedef void masses(const int *n, double *out, const int *rows, double *, int *);
extern void radau5_(const int *n, function *, double *t, double *y, const double *t_end, double *h,
                    const double *rtol, const double *atol, const int *itol, jacobian *,
                    const int *ijac, const int *mljac, const int *mujac, masses *, const int *imas,
                    const int *mlmas, const int *mumas, void (*solout)(void), const int *iout,
                    double *work, const int *lwork, int *iwork, const int *liwork, double *rpar,
                    int *ipar, int *idid);

static void right_side(const int *n, const double *t, const double *y, double *out, double *rpar,
                       int *ipar) {
    (void)n, (void)rpar, (void)ipar;
    struct terms at;
    const double *q = y, *v = y + NQ, *a = y + 2 * NQ, *lambda = y + N - NC;
    terms(*t, q, v, &at);
    memcpy(out, y + M2, sizeof(double) * M1);
    double *force = out + M1, *rate = force + NQ;
    for (int i = 0; i < NQ; i++) {
        force[i] = at.force[i];
        for (int k = 0; k < NC; k++) force[i] -= at.jacobian[k][i] * lambda[k];
        if (!CONSTANT_MASS) {
            for (int j = 0; j < NQ; j++) force[i] -= at.mass[i][j] * a[j];
        }
    }
    for (int k = 0; k < NC; k++) {
        rate[k] = at.rate[k];
        for (int i = 0; i < NQ; i++) rate[k] += at.jacobian[k][i] * v[i];
    }
}

/* Rows of the forces and constraints, by columns. */
static void derivatives(const int *n, const double *t, const double *y, const int *lower,
                        const int *upper, double *out, const int *rows, double *rpar, int *ipar) {
    (void)n, (void)lower, (void)upper, (void)rpar, (void)ipar;
    struct terms at;
    struct slopes by;
    const double *q = y, *v = y + NQ, *lambda = y + N - NC;
    /* with a constant mass the slopes do not depend on a */
    const double *a = CONSTANT_MASS ? v : y + 2 * NQ;
    terms(*t, q, v, &at);
    slopes(*t, q, v, a, lambda, &by);
    memset(out, 0, sizeof(double) * (size_t)(*rows) * N);
#define AT(row, col) out[(col) * *rows + (row)]
    for (int i = 0; i < NQ; i++) {
        for (int j = 0; j < NQ; j++) {
            AT(i, j) = -by.force_q[i][j];
            AT(i, NQ + j) = -by.force_v[i][j];
            if (!CONSTANT_MASS) AT(i, 2 * NQ + j) = -at.mass[i][j];
        }
        for (int k = 0; k < NC; k++) {
            AT(i, N - NC + k) = -at.jacobian[k][i];
            AT(NQ + k, i) = by.rate_q[k][i];
            AT(NQ + k, NQ + i) = at.jacobian[k][i];
        }
    }
}

static void mass_diagonal(const int *n, double *out, const int *rows, double *rpar, int *ipar) {
    (void)n, (void)rpar, (void)ipar;
    struct terms at;
    const double origin[NQ] = {0};
    memset(out, 0, sizeof(double) * ROWS * (size_t)*rows);
    if (CONSTANT_MASS) {
        terms(0, origin, origin, &at);
        for (int i = 0; i < NQ; i++) out[i * *rows] = at.mass[i][i];
    }
}

static void no_output(void) {}

/* Messages of the library go nowhere: there is no R to print them. */
void Rprintf(const char *format, ...) { (void)format; }

static struct end integrate(const struct start *start, double tolerance) {
    double y[N], work[20 + N * 12 + ROWS * (4 * ROWS + 3 * N)] = {0};
    int iwork[20 + 3 * N] = {0}, idid = 0;
    const int n = N, zero = 0, one = 1, full = ROWS, lwork = sizeof work / sizeof *work;
    const int liwork = sizeof iwork / sizeof *iwork;
    double t = 0, h = 1e-3 * start->t_end;
    memcpy(y, start->q, sizeof start->q);
    memcpy(y + NQ, start->v, sizeof start->v);
    if (!CONSTANT_MASS) memcpy(y + 2 * NQ, start->a, sizeof start->a);
    memcpy(y + N - NC, start->lambda, sizeof start->lambda);
    iwork[1] = 1000000;        /* steps */
    iwork[4] = 2 * NQ;         /* unknowns of index 1 */
    iwork[5] = N - 2 * NQ;     /* unknowns of index 2 */
    iwork[8] = M1;
    iwork[9] = M2;
    radau5_(&n, right_side, &t, y, &start->t_end, &h, &tolerance, &tolerance, &zero, derivatives,
            &one, &full, &full, mass_diagonal, &one, &zero, &zero, no_output, &zero, work, &lwork,
            iwork, &liwork, NULL, NULL, &idid);
    struct end end = {
        .is_reached = idid == 1,
        .n_residual = iwork[13],
        .n_jacobian = iwork[14],
        .n_step = iwork[16],
        .n_reject = iwork[17],
        .n_factor = iwork[18],
    };
    memcpy(end.q, y, sizeof end.q);
    memcpy(end.v, y + NQ, sizeof end.v);
    memcpy(end.lambda, y + N - NC, sizeof end.lambda);
    return end;
}

int main(void) { return measure(); }
