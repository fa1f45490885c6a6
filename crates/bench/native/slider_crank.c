/* Slider-crank: residual and Jacobian as an engineer writes them down.
 *
 * q = (theta1, x2, y2, theta2, x3); inputs q, v, a, lambda; outputs r, g, dr/dq, dr/dv, M, G. */
#include "turn.h"

static const double g = 9.8, l1 = 1, s1 = 0.5, m1 = 5, i1 = 1, torque = 55;
static const double s2 = 1.5, m2 = 5, i2 = 1, m3 = 20;

void evaluate(const double *restrict in, double *restrict out) {
    const double *q = in, *a = in + 10, *lambda = in + 15;
    const double angle[2] = {q[0], q[3]};
    double s[2], c[2];
    TURN(2, angle, s, c);
    const double lx = l1 * c[0], ly = l1 * s[0], rx = s2 * c[1], ry = s2 * s[1];
    const double weight = g * m1 * s1;
    const double sum_x = lambda[0] + lambda[2], sum_y = lambda[1] + lambda[3];

    /* r */
    *out++ = i1 * a[0] + weight * c[0] - torque - ly * lambda[2] + lx * lambda[3];
    *out++ = m2 * a[1] + lambda[0] - lambda[2];
    *out++ = m2 * a[2] + g * m2 + lambda[1] - lambda[3];
    *out++ = i2 * a[3] - ry * sum_x + rx * sum_y;
    *out++ = m3 * a[4] - lambda[0];
    /* g */
    *out++ = q[1] + rx - q[4];
    *out++ = q[2] + ry;
    *out++ = lx - q[1] + rx;
    *out++ = ly - q[2] + ry;
    /* dr/dq */
    *out++ = -weight * s[0] - lx * lambda[2] - ly * lambda[3];
    *out++ = -rx * sum_x - ry * sum_y;
    /* M */
    *out++ = i1;
    *out++ = m2;
    *out++ = m2;
    *out++ = i2;
    *out++ = m3;
    /* G */
    *out++ = 1;
    *out++ = -ry;
    *out++ = -1;
    *out++ = 1;
    *out++ = rx;
    *out++ = -ly;
    *out++ = -1;
    *out++ = -ry;
    *out++ = lx;
    *out++ = -1;
    *out++ = rx;
}
