/* Five links: residual and Jacobian as an engineer writes them down.
 *
 * q = (ti1, x2, y2, ti2, x3, x4, y4, ti4, ti5); inputs q, v, a, lambda; outputs r, g, dr/dq,
 * dr/dv, M, G. */
#include "turn.h"

static const double g = 9.8, m = 1, inertia = 1, h1 = 103, h2 = -99, l1 = 25, s1 = 12.5;
static const double s2 = 50, s4 = 12.5, l5 = 100, s5 = 50, torque = 500;

void evaluate(const double *restrict in, double *restrict out) {
    const double *q = in, *a = in + 18, *lambda = in + 27;
    const double angle[4] = {q[0], q[3], q[7], q[8]};
    double s[4], c[4];
    TURN(4, angle, s, c);
    const double x1 = l1 * c[0], y1 = l1 * s[0], x2 = s2 * c[1], y2 = s2 * s[1];
    const double x4 = s4 * c[2], y4 = s4 * s[2], x5 = l5 * c[3], y5 = l5 * s[3];
    const double weight1 = g * m * s1, weight5 = g * m * s5, weight = g * m;
    const double x57 = lambda[4] + lambda[6], y68 = lambda[5] + lambda[7];
    const double x13 = lambda[0] + lambda[2], y24 = lambda[1] + lambda[3];

    /* r */
    *out++ = inertia * a[0] + weight1 * c[0] - torque - y1 * lambda[6] + x1 * lambda[7];
    *out++ = m * a[1] + lambda[0] + lambda[4] - lambda[6];
    *out++ = m * a[2] + weight + lambda[1] + lambda[5] - lambda[7];
    *out++ = inertia * a[3] - y2 * x57 + x2 * y68;
    *out++ = m * a[4] - lambda[4];
    *out++ = m * a[5] - lambda[0] + lambda[2];
    *out++ = m * a[6] + weight - lambda[1] + lambda[3];
    *out++ = inertia * a[7] + y4 * x13 - x4 * y24;
    *out++ = inertia * a[8] + weight5 * c[3] + y5 * lambda[2] - x5 * lambda[3];
    /* g */
    *out++ = q[1] - q[5] - x4;
    *out++ = q[2] - q[6] - y4;
    *out++ = q[5] - x4 - h1 - x5;
    *out++ = q[6] - y4 - h2 - y5;
    *out++ = q[1] + x2 - q[4];
    *out++ = q[2] + y2;
    *out++ = x1 - q[1] + x2;
    *out++ = y1 - q[2] + y2;
    /* dr/dq */
    *out++ = -weight1 * s[0] - x1 * lambda[6] - y1 * lambda[7];
    *out++ = -x2 * x57 - y2 * y68;
    *out++ = x4 * x13 + y4 * y24;
    *out++ = -weight5 * s[3] + x5 * lambda[2] + y5 * lambda[3];
    /* M */
    *out++ = inertia;
    *out++ = m;
    *out++ = m;
    *out++ = inertia;
    *out++ = m;
    *out++ = m;
    *out++ = m;
    *out++ = inertia;
    *out++ = inertia;
    /* G */
    *out++ = 1;
    *out++ = -1;
    *out++ = y4;
    *out++ = 1;
    *out++ = -1;
    *out++ = -x4;
    *out++ = 1;
    *out++ = y4;
    *out++ = y5;
    *out++ = 1;
    *out++ = -x4;
    *out++ = -x5;
    *out++ = 1;
    *out++ = -y2;
    *out++ = -1;
    *out++ = 1;
    *out++ = x2;
    *out++ = -y1;
    *out++ = -1;
    *out++ = -y2;
    *out++ = x1;
    *out++ = -1;
    *out++ = x2;
}
