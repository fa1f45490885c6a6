/* Planar slider-crank in absolute coordinates, q = (x1, y1, p1, x2, y2, p2, x3). */
#define NQ 7
#define NC 6
#define CONSTANT_MASS 1
#include "mechanism.h"

static const double m1 = 0.36, m2 = 0.151104, m3 = 0.075552, l1 = 0.15, l2 = 0.3, gravity = 9.81;
#define I1 (m1 * l1 * l1 / 12)
#define I2 (m2 * l2 * l2 / 12)

static void terms(double t, const double *q, const double *v, struct terms *out) {
    (void)t;
    const double c1 = l1 / 2 * cos(q[2]), s1 = l1 / 2 * sin(q[2]);
    const double c2 = l2 / 2 * cos(q[5]), s2 = l2 / 2 * sin(q[5]);
    const double w1 = v[2] * v[2], w2 = v[5] * v[5];
    *out = (struct terms){
        .mass = {{m1}, {0, m1}, {0, 0, I1}, {0, 0, 0, m2}, {0, 0, 0, 0, m2},
                 {0, 0, 0, 0, 0, I2}, {0, 0, 0, 0, 0, 0, m3}},
        .force = {0, -m1 * gravity, 0, 0, -m2 * gravity, 0, 0},
        .constraint = {q[0] - c1, q[1] - s1, q[3] - c2 - q[0] - c1, q[4] - s2 - q[1] - s1,
                       q[6] - q[3] - c2, q[4] + s2},
        .jacobian = {{1, 0, s1, 0, 0, 0, 0}, {0, 1, -c1, 0, 0, 0, 0}, {-1, 0, s1, 1, 0, s2, 0},
                     {0, -1, -c1, 0, 1, -c2, 0}, {0, 0, 0, -1, 0, s2, 1}, {0, 0, 0, 0, 1, c2, 0}},
        .gamma = {c1 * w1, s1 * w1, c1 * w1 + c2 * w2, s1 * w1 + s2 * w2, c2 * w2, -s2 * w2},
    };
}

static void slopes(double t, const double *q, const double *v, const double *a,
                   const double *lambda, struct slopes *out) {
    (void)t, (void)a;
    const double c1 = l1 / 2 * cos(q[2]), s1 = l1 / 2 * sin(q[2]);
    const double c2 = l2 / 2 * cos(q[5]), s2 = l2 / 2 * sin(q[5]);
    memset(out, 0, sizeof *out);
    out->force_q[2][2] = c1 * (lambda[0] + lambda[2]) + s1 * (lambda[1] + lambda[3]);
    out->force_q[5][5] = c2 * (lambda[2] + lambda[4]) + s2 * (lambda[3] - lambda[5]);
    out->rate_q[0][2] = out->rate_q[2][2] = c1 * v[2];
    out->rate_q[1][2] = out->rate_q[3][2] = s1 * v[2];
    out->rate_q[2][5] = out->rate_q[4][5] = c2 * v[5];
    out->rate_q[3][5] = s2 * v[5];
    out->rate_q[5][5] = -s2 * v[5];
}

static void divide_by_mass(const struct terms *at, double *x) {
    (void)at;
    const double inverse[NQ] = {1 / m1, 1 / m1, 1 / I1, 1 / m2, 1 / m2, 1 / I2, 1 / m3};
    for (int i = 0; i < NQ; i++) x[i] *= inverse[i];
}
