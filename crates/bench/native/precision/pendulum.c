/* Point mass on a rigid massless bar: (x^2 + y^2 - L^2)/2 = 0. */
#define NQ 2
#define NC 1
#define CONSTANT_MASS 1
#include "mechanism.h"

static const double m = 1, length = 1, gravity = 9.81;

static void terms(double t, const double *q, const double *v, struct terms *out) {
    (void)t;
    *out = (struct terms){
        .mass = {{m, 0}, {0, m}},
        .force = {0, -m * gravity},
        .constraint = {(q[0] * q[0] + q[1] * q[1] - length * length) / 2},
        .jacobian = {{q[0], q[1]}},
        .gamma = {v[0] * v[0] + v[1] * v[1]},
    };
}

static void slopes(double t, const double *q, const double *v, const double *a,
                   const double *lambda, struct slopes *out) {
    (void)t, (void)q, (void)a;
    *out = (struct slopes){
        .force_q = {{lambda[0], 0}, {0, lambda[0]}},
        .rate_q = {{v[0], v[1]}},
    };
}

static void divide_by_mass(const struct terms *at, double *x) {
    (void)at;
    x[0] /= m;
    x[1] /= m;
}
