/* Andrews' squeezing mechanism: residual and Jacobian as an engineer writes them down.
 *
 * q = (b, Th, ga, Ph, de, Om, ep); inputs q, v, a, lambda; outputs r, g, dr/dq, dr/dv, M, G. */
#include "turn.h"

static const double m1 = .04325, m2 = .00365, m3 = .02373, m4 = .00706, m5 = .07050, m6 = .00706;
static const double m7 = .05498, xa = -.06934, ya = -.00227, xb = -0.03635, yb = .03273;
static const double xc = .014, yc = .072, c0 = 4530, i1 = 2.194e-6, i2 = 4.410e-7, i3 = 5.255e-6;
static const double i4 = 5.667e-7, i5 = 1.169e-5, i6 = 5.667e-7, i7 = 1.912e-5, d = 28e-3;
static const double da = 115e-4, e = 2e-2, ea = 1421e-5, rr = 7e-3, ra = 92e-5, l0 = 7785e-5;
static const double ss = 35e-3, sa = 1874e-5, sb = 1043e-5, sc = 18e-3, sd = 2e-2, ta = 2308e-5;
static const double tb = 916e-5, u = 4e-2, ua = 1228e-5, ub = 449e-5, zf = 2e-2, zt = 4e-2;
static const double fa = 1421e-5, mom = 33e-3;

void evaluate(const double *restrict in, double *restrict out) {
    const double *q = in, *v = in + 7, *a = in + 14, *lambda = in + 21;
    /* seven angles; those of Th, Ph and Om by the addition theorem */
    const double angle[7] = {q[0], q[0] + q[1], q[2], q[3] + q[4], q[4], q[5] + q[6], q[6]};
    double s[7], c[7];
    TURN(7, angle, s, c);
    const double sin_th = s[1] * c[0] - c[1] * s[0], cos_th = c[1] * c[0] + s[1] * s[0];
    const double sin_ph = s[3] * c[4] - c[3] * s[4], cos_ph = c[3] * c[4] + s[3] * s[4];
    const double sin_om = s[5] * c[6] - c[5] * s[6], cos_om = c[5] * c[6] + s[5] * s[6];
    /* vectors of the loops */
    const double rx = rr * c[0], ry = rr * s[0], dx = d * c[1], dy = d * s[1];
    const double gx = ss * s[2], gy = ss * c[2];
    const double ex = e * s[3], ey = e * c[3], tx = zt * c[4], ty = zt * s[4];
    const double fx = zf * c[5], fy = zf * s[5], ux = u * s[6], uy = u * c[6];
    const double bx = rx - dx, by = ry - dy;

    /* mass matrix */
    const double k2 = m2 * da * rr, k4 = m4 * zt * (e - ea), k6 = m6 * u * (zf - fa);
    const double kc = k2 * cos_th, ks = k2 * sin_th;
    const double pc = k4 * cos_ph, ps = k4 * sin_ph;
    const double oc = k6 * cos_om, os = k6 * sin_om;
    const double m11 = m1 * ra * ra + m2 * (rr * rr + da * da) + i1 + i2 - 2 * kc;
    const double m21 = m2 * da * da + i2 - kc, m22 = m2 * da * da + i2;
    const double m33 = m3 * (sa * sa + sb * sb) + i3, m44 = m4 * (e - ea) * (e - ea) + i4;
    const double m54 = m44 + ps;
    const double m55 = m4 * (zt * zt + (e - ea) * (e - ea)) + m5 * (ta * ta + tb * tb) + i4 + i5 + 2 * ps;
    const double m66 = m6 * (zf - fa) * (zf - fa) + i6, m76 = m66 - os;
    const double m77 = m6 * ((zf - fa) * (zf - fa) + u * u) + m7 * (ua * ua + ub * ub) + i6 + i7 - 2 * os;

    /* spring: end p, its derivative (-py', px') by ga, moment f3 and its derivative */
    const double px = sd * c[2] + sc * s[2], py = sd * s[2] - sc * c[2];
    const double lx = px + xb - xc, ly = py + yb - yc;
    const double length2 = lx * lx + ly * ly, length = sqrt(length2);
    const double stretch = -c0 * (length - l0) / length;
    const double arm = px * ly - py * lx;
    const double f3 = stretch * arm;
    const double stretch_slope = -c0 * l0 * arm / (length2 * length);
    const double arm_slope = px * px + py * py - px * lx - py * ly;

    /* sums of multipliers along the crank */
    const double sx = lambda[0] + lambda[2] + lambda[4], sy = lambda[1] + lambda[3] + lambda[5];
    const double along = dx * sx + dy * sy;
    const double turn = dy * sx - dx * sy;
    const double v_th = v[1] + 2 * v[0], v_ph = v[3] + 2 * v[4], v_om = v[5] + 2 * v[6];
    const double w_th = v[1] * v_th, w_ph = v[3] * v_ph, w_om = v[5] * v_om;
    const double e_turn = ex * lambda[3] + ey * lambda[2], e_along = ex * lambda[2] - ey * lambda[3];
    const double f_turn = fy * lambda[4] - fx * lambda[5], f_along = fx * lambda[4] + fy * lambda[5];

    /* r */
    *out++ = m11 * a[0] + m21 * a[1] - mom + ks * w_th + turn - ry * sx + rx * sy;
    *out++ = m21 * a[0] + m22 * a[1] - ks * v[0] * v[0] + turn;
    *out++ = m33 * a[2] - f3 - gy * lambda[0] - gx * lambda[1];
    *out++ = m44 * a[3] + m54 * a[4] - pc * v[4] * v[4] - e_turn;
    *out++ = m54 * a[3] + m55 * a[4] + pc * w_ph - e_turn + ty * lambda[2] - tx * lambda[3];
    *out++ = m66 * a[5] + m76 * a[6] + oc * v[6] * v[6] + f_turn;
    *out++ = m76 * a[5] + m77 * a[6] - oc * w_om + f_turn - uy * lambda[4] - ux * lambda[5];
    /* g */
    *out++ = bx - gx - xb;
    *out++ = by + gy - yb;
    *out++ = bx - ex - tx - xa;
    *out++ = by + ey - ty - ya;
    *out++ = bx - fx - ux - xa;
    *out++ = by - fy + uy - ya;
    /* dr/dq */
    *out++ = along - rx * sx - ry * sy;
    *out++ = ks * (2 * a[0] + a[1]) + kc * w_th + along;
    *out++ = along;
    *out++ = ks * a[0] - kc * v[0] * v[0] + along;
    *out++ = -stretch_slope * arm - stretch * arm_slope + gx * lambda[0] - gy * lambda[1];
    *out++ = pc * a[4] + ps * v[4] * v[4] + e_along;
    *out++ = e_along;
    *out++ = pc * (a[3] + 2 * a[4]) - ps * w_ph + e_along;
    *out++ = e_along + tx * lambda[2] + ty * lambda[3];
    *out++ = -oc * a[6] - os * v[6] * v[6] + f_along;
    *out++ = f_along;
    *out++ = -oc * (a[5] + 2 * a[6]) + os * w_om + f_along;
    *out++ = f_along + ux * lambda[4] - uy * lambda[5];
    /* dr/dv */
    *out++ = 2 * ks * v[1];
    *out++ = 2 * ks * (v[0] + v[1]);
    *out++ = -2 * ks * v[0];
    *out++ = -2 * pc * v[4];
    *out++ = 2 * pc * (v[3] + v[4]);
    *out++ = 2 * pc * v[3];
    *out++ = 2 * oc * v[6];
    *out++ = -2 * oc * (v[5] + v[6]);
    *out++ = -2 * oc * v[5];
    /* M */
    *out++ = m11;
    *out++ = m21;
    *out++ = m22;
    *out++ = m33;
    *out++ = m44;
    *out++ = m54;
    *out++ = m55;
    *out++ = m66;
    *out++ = m76;
    *out++ = m77;
    /* G */
    *out++ = -by;
    *out++ = dy;
    *out++ = -gy;
    *out++ = bx;
    *out++ = -dx;
    *out++ = -gx;
    *out++ = -by;
    *out++ = dy;
    *out++ = -ey;
    *out++ = ty - ey;
    *out++ = bx;
    *out++ = -dx;
    *out++ = -ex;
    *out++ = -ex - tx;
    *out++ = -by;
    *out++ = dy;
    *out++ = fy;
    *out++ = fy - uy;
    *out++ = bx;
    *out++ = -dx;
    *out++ = -fx;
    *out++ = -fx - ux;
}
