/* A mechanism as an engineer writes it down, one file each, included by the driver of a solver:
 *
 *   M(q) a = f(t, q, v) - G(t, q)^T lambda,   g(t, q) = 0,   G = dg/dq
 *
 * A file defines NQ, NC and CONSTANT_MASS (M is diagonal and constant) and the three functions. */
#ifndef MECHANISM_H
#define MECHANISM_H
#include <math.h>
#include <string.h>

struct terms {
    double mass[NQ][NQ], force[NQ];
    double constraint[NC], jacobian[NC][NQ];
    double rate[NC];  /* dg/dt at fixed q */
    double gamma[NC]; /* d/dt (G v + dg/dt) = G a + gamma */
};

struct slopes {
    double force_q[NQ][NQ]; /* d(M a - f + G^T lambda)/dq */
    double force_v[NQ][NQ]; /* -df/dv */
    double rate_q[NC][NQ];  /* d(G v + dg/dt)/dq */
};

static void terms(double t, const double *q, const double *v, struct terms *out);
/* no solver needs all of these */
__attribute__((unused)) static void slopes(double t, const double *q, const double *v,
                                           const double *a, const double *lambda, struct slopes *out);
/* x = M^-1 x */
__attribute__((unused)) static void divide_by_mass(const struct terms *at, double *x);

/* Accelerations and multipliers: (G M^-1 G^T) lambda = G M^-1 f + gamma, a = M^-1 (f - G^T lambda),
 * by Cholesky's factorisation. */
static inline void accelerations(const struct terms *at, double *a, double *lambda) {
    double x[NC][NQ], s[NC][NC];
    memcpy(a, at->force, sizeof(double) * NQ);
    divide_by_mass(at, a);
    for (int k = 0; k < NC; k++) {
        memcpy(x[k], at->jacobian[k], sizeof x[k]);
        divide_by_mass(at, x[k]);
        lambda[k] = at->gamma[k];
        for (int i = 0; i < NQ; i++) lambda[k] += at->jacobian[k][i] * a[i];
        for (int l = 0; l <= k; l++) {
            s[k][l] = 0;
            for (int i = 0; i < NQ; i++) s[k][l] += at->jacobian[l][i] * x[k][i];
        }
    }
    for (int k = 0; k < NC; k++) {
        for (int l = 0; l <= k; l++) {
            for (int j = 0; j < l; j++) s[k][l] -= s[k][j] * s[l][j];
            s[k][l] = l < k ? s[k][l] * s[l][l] : 1 / sqrt(s[k][k]);
        }
        for (int l = 0; l < k; l++) lambda[k] -= s[k][l] * lambda[l];
        lambda[k] *= s[k][k];
    }
    for (int k = NC - 1; k >= 0; k--) {
        for (int l = k + 1; l < NC; l++) lambda[k] -= s[l][k] * lambda[l];
        lambda[k] *= s[k][k];
    }
    for (int k = 0; k < NC; k++) {
        for (int i = 0; i < NQ; i++) a[i] -= x[k][i] * lambda[k];
    }
}
#endif
