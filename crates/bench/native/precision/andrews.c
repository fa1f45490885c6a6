/* Andrews' squeezing mechanism (HW2 VII.7), q = (b, Th, ga, Ph, de, Om, ep). */
#define NQ 7
#define NC 6
#define CONSTANT_MASS 0
#include "mechanism.h"

static const double m1 = .04325, m2 = .00365, m3 = .02373, m4 = .00706, m5 = .07050, m6 = .00706;
static const double m7 = .05498, xa = -.06934, ya = -.00227, xb = -0.03635, yb = .03273;
static const double xc = .014, yc = .072, c0 = 4530, i1 = 2.194e-6, i2 = 4.410e-7, i3 = 5.255e-6;
static const double i4 = 5.667e-7, i5 = 1.169e-5, i6 = 5.667e-7, i7 = 1.912e-5, d = 28e-3;
static const double da = 115e-4, e = 2e-2, ea = 1421e-5, rr = 7e-3, ra = 92e-5, l0 = 7785e-5;
static const double ss = 35e-3, sa = 1874e-5, sb = 1043e-5, sc = 18e-3, sd = 2e-2, ta = 2308e-5;
static const double tb = 916e-5, u = 4e-2, ua = 1228e-5, ub = 449e-5, zf = 2e-2, zt = 4e-2;
static const double fa = 1421e-5, mom = 33e-3;
#define K2 (m2 * da * rr)
#define K4 (m4 * zt * (e - ea))
#define K6 (m6 * u * (zf - fa))

/* Vectors of the loops, sines and cosines of the relative angles, the spring. */
struct pose {
    double rx, ry, dx, dy, gx, gy, ex, ey, tx, ty, fx, fy, ux, uy;
    double sin_th, cos_th, sin_ph, cos_ph, sin_om, cos_om;
    double moment, moment_slope;
};

/* gcc turns the pairs into sincos. */
static struct pose pose(const double *q) {
    const double sb_ = sin(q[0]), cb = cos(q[0]), s1 = sin(q[0] + q[1]), c1 = cos(q[0] + q[1]);
    const double sg = sin(q[2]), cg = cos(q[2]), s3 = sin(q[3] + q[4]), c3 = cos(q[3] + q[4]);
    const double s4 = sin(q[4]), c4 = cos(q[4]), s5 = sin(q[5] + q[6]), c5 = cos(q[5] + q[6]);
    const double s6 = sin(q[6]), c6 = cos(q[6]);
    /* end of the spring, its derivative (-py, px) by ga */
    const double px = sd * cg + sc * sg, py = sd * sg - sc * cg;
    const double lx = px + xb - xc, ly = py + yb - yc, l2 = lx * lx + ly * ly, l = sqrt(l2);
    const double pull = -c0 * (l - l0) / l, arm = px * ly - py * lx;
    const double arm_slope = px * px + py * py - px * lx - py * ly;
    return (struct pose){
        .rx = rr * cb, .ry = rr * sb_, .dx = d * c1, .dy = d * s1, .gx = ss * sg, .gy = ss * cg,
        .ex = e * s3, .ey = e * c3, .tx = zt * c4, .ty = zt * s4, .fx = zf * c5, .fy = zf * s5,
        .ux = u * s6, .uy = u * c6,
        .sin_th = s1 * cb - c1 * sb_, .cos_th = c1 * cb + s1 * sb_,
        .sin_ph = s3 * c4 - c3 * s4, .cos_ph = c3 * c4 + s3 * s4,
        .sin_om = s5 * c6 - c5 * s6, .cos_om = c5 * c6 + s5 * s6,
        .moment = pull * arm,
        .moment_slope = -c0 * l0 * arm * arm / (l2 * l) + pull * arm_slope,
    };
}

static void terms(double t, const double *q, const double *v, struct terms *out) {
    (void)t;
    const struct pose p = pose(q);
    const double m44 = m4 * (e - ea) * (e - ea) + i4, m66 = m6 * (zf - fa) * (zf - fa) + i6;
    const double m22 = m2 * da * da + i2;
    const double m11 = m1 * ra * ra + m2 * rr * rr + i1 + m22 - 2 * K2 * p.cos_th;
    const double m55 = m4 * zt * zt + m5 * (ta * ta + tb * tb) + i5 + m44 + 2 * K4 * p.sin_ph;
    const double m77 = m6 * u * u + m7 * (ua * ua + ub * ub) + i7 + m66 - 2 * K6 * p.sin_om;
    memset(out, 0, sizeof *out);
    out->mass[0][0] = m11;
    out->mass[1][0] = out->mass[0][1] = m22 - K2 * p.cos_th;
    out->mass[1][1] = m22;
    out->mass[2][2] = m3 * (sa * sa + sb * sb) + i3;
    out->mass[3][3] = m44;
    out->mass[4][3] = out->mass[3][4] = m44 + K4 * p.sin_ph;
    out->mass[4][4] = m55;
    out->mass[5][5] = m66;
    out->mass[6][5] = out->mass[5][6] = m66 - K6 * p.sin_om;
    out->mass[6][6] = m77;

    out->force[0] = mom - K2 * v[1] * (v[1] + 2 * v[0]) * p.sin_th;
    out->force[1] = K2 * v[0] * v[0] * p.sin_th;
    out->force[2] = p.moment;
    out->force[3] = K4 * v[4] * v[4] * p.cos_ph;
    out->force[4] = -K4 * v[3] * (v[3] + 2 * v[4]) * p.cos_ph;
    out->force[5] = -K6 * v[6] * v[6] * p.cos_om;
    out->force[6] = K6 * v[5] * (v[5] + 2 * v[6]) * p.cos_om;

    const double bx = p.rx - p.dx, by = p.ry - p.dy;
    const double constraint[NC] = {bx - p.gx - xb, by + p.gy - yb, bx - p.ex - p.tx - xa,
                                   by + p.ey - p.ty - ya, bx - p.fx - p.ux - xa,
                                   by - p.fy + p.uy - ya};
    memcpy(out->constraint, constraint, sizeof constraint);
    for (int k = 0; k < NC; k++) {
        out->jacobian[k][0] = k % 2 ? bx : -by;
        out->jacobian[k][1] = k % 2 ? -p.dx : p.dy;
    }
    out->jacobian[0][2] = -p.gy;
    out->jacobian[1][2] = -p.gx;
    out->jacobian[2][3] = -p.ey;
    out->jacobian[2][4] = p.ty - p.ey;
    out->jacobian[3][3] = -p.ex;
    out->jacobian[3][4] = -p.ex - p.tx;
    out->jacobian[4][5] = p.fy;
    out->jacobian[4][6] = p.fy - p.uy;
    out->jacobian[5][5] = -p.fx;
    out->jacobian[5][6] = -p.fx - p.ux;

    const double b2 = v[0] * v[0], t2 = (v[0] + v[1]) * (v[0] + v[1]), g2 = v[2] * v[2];
    const double e2 = (v[3] + v[4]) * (v[3] + v[4]), z2 = v[4] * v[4];
    const double f2 = (v[5] + v[6]) * (v[5] + v[6]), u2 = v[6] * v[6];
    const double cx = -p.rx * b2 + p.dx * t2, cy = -p.ry * b2 + p.dy * t2;
    const double gamma[NC] = {cx + p.gx * g2, cy - p.gy * g2, cx + p.ex * e2 + p.tx * z2,
                              cy - p.ey * e2 + p.ty * z2, cx + p.fx * f2 + p.ux * u2,
                              cy + p.fy * f2 - p.uy * u2};
    memcpy(out->gamma, gamma, sizeof gamma);
}

static void slopes(double t, const double *q, const double *v, const double *a,
                   const double *lambda, struct slopes *out) {
    (void)t;
    const struct pose p = pose(q);
    const double kc = K2 * p.cos_th, ks = K2 * p.sin_th, pc = K4 * p.cos_ph, ps = K4 * p.sin_ph;
    const double oc = K6 * p.cos_om, os = K6 * p.sin_om;
    const double w_th = v[1] * (v[1] + 2 * v[0]), w_ph = v[3] * (v[3] + 2 * v[4]);
    const double w_om = v[5] * (v[5] + 2 * v[6]);
    const double sx = lambda[0] + lambda[2] + lambda[4], sy = lambda[1] + lambda[3] + lambda[5];
    const double along = p.dx * sx + p.dy * sy;
    const double e_along = p.ex * lambda[2] - p.ey * lambda[3];
    const double f_along = p.fx * lambda[4] + p.fy * lambda[5];
    memset(out, 0, sizeof *out);
    double(*dq)[NQ] = out->force_q;
    dq[0][0] = along - p.rx * sx - p.ry * sy;
    dq[0][1] = ks * (2 * a[0] + a[1]) + kc * w_th + along;
    dq[1][0] = along;
    dq[1][1] = ks * a[0] - kc * v[0] * v[0] + along;
    dq[2][2] = -p.moment_slope + p.gx * lambda[0] - p.gy * lambda[1];
    dq[3][3] = pc * a[4] + ps * v[4] * v[4] + e_along;
    dq[3][4] = e_along;
    dq[4][3] = pc * (a[3] + 2 * a[4]) - ps * w_ph + e_along;
    dq[4][4] = e_along + p.tx * lambda[2] + p.ty * lambda[3];
    dq[5][5] = -oc * a[6] - os * v[6] * v[6] + f_along;
    dq[5][6] = f_along;
    dq[6][5] = -oc * (a[5] + 2 * a[6]) + os * w_om + f_along;
    dq[6][6] = f_along + p.ux * lambda[4] - p.uy * lambda[5];

    double(*dv)[NQ] = out->force_v;
    dv[0][0] = 2 * ks * v[1];
    dv[0][1] = 2 * ks * (v[0] + v[1]);
    dv[1][0] = -2 * ks * v[0];
    dv[3][4] = -2 * pc * v[4];
    dv[4][3] = 2 * pc * (v[3] + v[4]);
    dv[4][4] = 2 * pc * v[3];
    dv[5][6] = 2 * oc * v[6];
    dv[6][5] = -2 * oc * (v[5] + v[6]);
    dv[6][6] = -2 * oc * v[5];

    const double th = v[0] + v[1], ph = v[3] + v[4], om = v[5] + v[6];
    for (int k = 0; k < NC; k++) {
        out->rate_q[k][1] = th * (k % 2 ? p.dy : p.dx);
        out->rate_q[k][0] = out->rate_q[k][1] - v[0] * (k % 2 ? p.ry : p.rx);
    }
    out->rate_q[0][2] = p.gx * v[2];
    out->rate_q[1][2] = -p.gy * v[2];
    out->rate_q[2][3] = p.ex * ph;
    out->rate_q[2][4] = p.ex * ph + p.tx * v[4];
    out->rate_q[3][3] = -p.ey * ph;
    out->rate_q[3][4] = -p.ey * ph + p.ty * v[4];
    out->rate_q[4][5] = p.fx * om;
    out->rate_q[4][6] = p.fx * om + p.ux * v[6];
    out->rate_q[5][5] = p.fy * om;
    out->rate_q[5][6] = p.fy * om - p.uy * v[6];
}

/* M has blocks (b, Th), (ga), (Ph, de), (Om, ep). */
static void divide_by_mass(const struct terms *at, double *x) {
    static const int first[3] = {0, 3, 5};
    for (int block = 0; block < 3; block++) {
        const int i = first[block], j = i + 1;
        const double aa = at->mass[i][i], ab = at->mass[i][j], bb = at->mass[j][j];
        const double scale = 1 / (aa * bb - ab * ab), xi = x[i];
        x[i] = scale * (bb * xi - ab * x[j]);
        x[j] = scale * (aa * x[j] - ab * xi);
    }
    x[2] /= at->mass[2][2];
}
