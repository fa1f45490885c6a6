/* Car axis: two wheels on springs, q = (xl, yl, xr, yr); the right end of the base moves. */
#define NQ 4
#define NC 2
#define CONSTANT_MASS 1
#include "mechanism.h"

static const double mass = 10 * 0.01 * 0.01 / 2, length = 1, free_length = 0.5;
static const double amplitude = 0.1, omega = 10, gravity = 1;

/* The moving end of the base with its first and second derivatives. */
struct base {
    double x[3], y[3];
};

static struct base base(double t) {
    const double s = sin(omega * t), c = cos(omega * t);
    struct base b = {.y = {amplitude * s, amplitude * omega * c, -amplitude * omega * omega * s}};
    b.x[0] = sqrt(length * length - b.y[0] * b.y[0]);
    b.x[1] = -b.y[0] * b.y[1] / b.x[0];
    b.x[2] = -(b.y[1] * b.y[1] + b.y[0] * b.y[2] + b.x[1] * b.x[1]) / b.x[0];
    return b;
}

static void terms(double t, const double *q, const double *v, struct terms *out) {
    const struct base b = base(t);
    const double lx = q[0], ly = q[1], rx = q[2] - b.x[0], ry = q[3] - b.y[0];
    const double left = free_length / sqrt(lx * lx + ly * ly) - 1;
    const double right = free_length / sqrt(rx * rx + ry * ry) - 1;
    const double ex = q[0] - q[2], ey = q[1] - q[3], ux = v[0] - v[2], uy = v[1] - v[3];
    *out = (struct terms){
        .mass = {{mass}, {0, mass}, {0, 0, mass}, {0, 0, 0, mass}},
        .force = {left * lx, left * ly - mass * gravity, right * rx, right * ry - mass * gravity},
        .constraint = {lx * b.x[0] + ly * b.y[0], ex * ex + ey * ey - length * length},
        .jacobian = {{b.x[0], b.y[0], 0, 0}, {2 * ex, 2 * ey, -2 * ex, -2 * ey}},
        .rate = {lx * b.x[1] + ly * b.y[1], 0},
        .gamma = {2 * (v[0] * b.x[1] + v[1] * b.y[1]) + lx * b.x[2] + ly * b.y[2],
                  2 * (ux * ux + uy * uy)},
    };
}

/* Derivatives of the force of a spring to the point (x, y). */
static void spring(double x, double y, double *xx, double *xy, double *yy) {
    const double r2 = x * x + y * y, r = sqrt(r2), s = free_length / r - 1;
    const double k = free_length / (r * r2);
    *xx = k * x * x - s;
    *xy = k * x * y;
    *yy = k * y * y - s;
}

static void slopes(double t, const double *q, const double *v, const double *a,
                   const double *lambda, struct slopes *out) {
    (void)a;
    const struct base b = base(t);
    const double two = 2 * lambda[1], ux = 2 * (v[0] - v[2]), uy = 2 * (v[1] - v[3]);
    double lxx, lxy, lyy, rxx, rxy, ryy;
    spring(q[0], q[1], &lxx, &lxy, &lyy);
    spring(q[2] - b.x[0], q[3] - b.y[0], &rxx, &rxy, &ryy);
    *out = (struct slopes){
        .force_q = {{lxx + two, lxy, -two, 0},
                    {lxy, lyy + two, 0, -two},
                    {-two, 0, rxx + two, rxy},
                    {0, -two, rxy, ryy + two}},
        .rate_q = {{b.x[1], b.y[1], 0, 0}, {ux, uy, -ux, -uy}},
    };
}

static void divide_by_mass(const struct terms *at, double *x) {
    (void)at;
    for (int i = 0; i < NQ; i++) x[i] /= mass;
}
