"""heyoka's Taylor integrator on the mechanisms of `native/precision`, written here a second time.

Each mechanism gives M, f, G and γ of M a = f − Gᵀλ, G a + γ = 0 by arithmetic that serves numbers and heyoka's
expressions alike: heyoka makes the series of the accelerations out of them, floats give the multipliers at the end.
"""

import math

from common import package, read, samples, write

heyoka = package("heyoka")


class Floats:
    """Functions of numbers."""

    sin, cos, sqrt = math.sin, math.cos, math.sqrt


class Expressions:
    """The same of expressions."""

    sin, cos, sqrt = heyoka.sin, heyoka.cos, heyoka.sqrt


def pendulum(_of, _t, _q, v):
    """A point mass of 1 kg on a bar of 1 m."""
    x, y = _q
    return [[[1.0]], [[1.0]]], [0.0, -9.81], [{0: x, 1: y}], [v[0] * v[0] + v[1] * v[1]]


def caraxis(of, t, q, v):
    """Two wheels on springs; the right end of the base moves."""
    mass, length, free, amplitude, omega = 10 * 0.01 * 0.01 / 2, 1.0, 0.5, 0.1, 10.0
    s, c = of.sin(omega * t), of.cos(omega * t)
    by = [amplitude * s, amplitude * omega * c, -amplitude * omega * omega * s]
    bx = of.sqrt(length * length - by[0] * by[0])
    bx = [bx, -by[0] * by[1] / bx]
    bx.append(-(by[1] * by[1] + by[0] * by[2] + bx[1] * bx[1]) / bx[0])
    lx, ly, rx, ry = q[0], q[1], q[2] - bx[0], q[3] - by[0]
    left = free / of.sqrt(lx * lx + ly * ly) - 1.0
    right = free / of.sqrt(rx * rx + ry * ry) - 1.0
    ex, ey, ux, uy = 2.0 * (q[0] - q[2]), 2.0 * (q[1] - q[3]), v[0] - v[2], v[1] - v[3]
    force = [left * lx, left * ly - mass, right * rx, right * ry - mass]
    jacobian = [{0: bx[0], 1: by[0]}, {0: ex, 1: ey, 2: -ex, 3: -ey}]
    gamma = [2.0 * (v[0] * bx[1] + v[1] * by[1]) + lx * bx[2] + ly * by[2], 2.0 * (ux * ux + uy * uy)]
    return [[[mass]]] * 4, force, jacobian, gamma


def andrews(of, _t, q, v):
    """Andrews' squeezer, HW2 §VII.7: q = (β, Θ, γ, Φ, δ, Ω, ε)."""
    m1, m2, m3, m4, m5, m6, m7 = 0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498
    i1, i2, i3, i4 = 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7
    i5, i6, i7 = 1.169e-5, 5.667e-7, 1.912e-5
    d, da, e, ea, rr, ra, ss, sa, sb = 28e-3, 115e-4, 2e-2, 1421e-5, 7e-3, 92e-5, 35e-3, 1874e-5, 1043e-5
    sc, sd, ta, tb, u, ua, ub, zf, zt, fa = 18e-3, 2e-2, 2308e-5, 916e-5, 4e-2, 1228e-5, 449e-5, 2e-2, 4e-2, 1421e-5
    xb, yb, xc, yc, stiffness, free, moment = -0.03635, 0.03273, 0.014, 0.072, 4530.0, 7785e-5, 33e-3
    k2, k4, k6 = m2 * da * rr, m4 * zt * (e - ea), m6 * u * (zf - fa)

    # Inertia, and the moments of the relative speeds.
    sin_th, cos_th = of.sin(q[1]), of.cos(q[1])
    sin_ph, cos_ph = of.sin(q[3]), of.cos(q[3])
    sin_om, cos_om = of.sin(q[5]), of.cos(q[5])
    m22, m44, m66 = m2 * da * da + i2, m4 * (e - ea) ** 2 + i4, m6 * (zf - fa) ** 2 + i6
    m11 = m1 * ra * ra + m2 * rr * rr + i1 + m22 - 2.0 * k2 * cos_th
    m55 = m4 * zt * zt + m5 * (ta * ta + tb * tb) + i5 + m44 + 2.0 * k4 * sin_ph
    m77 = m6 * u * u + m7 * (ua * ua + ub * ub) + i7 + m66 - 2.0 * k6 * sin_om
    m12, m45, m67 = m22 - k2 * cos_th, m44 + k4 * sin_ph, m66 - k6 * sin_om
    blocks = [[[m11, m12], [m12, m22]], [[m3 * (sa * sa + sb * sb) + i3]], [[m44, m45], [m45, m55]],
              [[m66, m67], [m67, m77]]]
    sg, cg = of.sin(q[2]), of.cos(q[2])
    px, py = sd * cg + sc * sg, sd * sg - sc * cg
    lx, ly = px + xb - xc, py + yb - yc
    spring = of.sqrt(lx * lx + ly * ly)
    force = [
        moment - k2 * v[1] * (v[1] + 2.0 * v[0]) * sin_th,
        k2 * v[0] * v[0] * sin_th,
        -stiffness * (spring - free) / spring * (px * ly - py * lx),
        k4 * v[4] * v[4] * cos_ph,
        -k4 * v[3] * (v[3] + 2.0 * v[4]) * cos_ph,
        -k6 * v[6] * v[6] * cos_om,
        k6 * v[5] * (v[5] + 2.0 * v[6]) * cos_om,
    ]

    # Three loops, two rows each.
    rx, ry = rr * of.cos(q[0]), rr * of.sin(q[0])
    dx, dy = d * of.cos(q[0] + q[1]), d * of.sin(q[0] + q[1])
    gx, gy = ss * sg, ss * cg
    ex, ey = e * of.sin(q[3] + q[4]), e * of.cos(q[3] + q[4])
    tx, ty = zt * of.cos(q[4]), zt * of.sin(q[4])
    fx, fy = zf * of.cos(q[5] + q[6]), zf * of.sin(q[5] + q[6])
    ux, uy = u * of.sin(q[6]), u * of.cos(q[6])
    first = [{0: dy - ry, 1: dy}, {0: rx - dx, 1: -dx}]
    others = [{2: -gy}, {2: -gx}, {3: -ey, 4: ty - ey}, {3: -ex, 4: -ex - tx}, {5: fy, 6: fy - uy},
              {5: -fx, 6: -fx - ux}]
    jacobian = [{**first[k % 2], **row} for k, row in enumerate(others)]
    b2, t2, g2, z2, u2 = v[0] * v[0], (v[0] + v[1]) ** 2, v[2] * v[2], v[4] * v[4], v[6] * v[6]
    e2, f2 = (v[3] + v[4]) ** 2, (v[5] + v[6]) ** 2
    cx, cy = dx * t2 - rx * b2, dy * t2 - ry * b2
    gamma = [cx + gx * g2, cy - gy * g2, cx + ex * e2 + tx * z2, cy - ey * e2 + ty * z2,
             cx + fx * f2 + ux * u2, cy + fy * f2 - uy * u2]
    return blocks, force, jacobian, gamma


def slidercrank(of, _t, q, v):
    """A slider-crank in absolute coordinates: q = (x1, y1, φ1, x2, y2, φ2, x3)."""
    m1, m2, m3, l1, l2, gravity = 0.36, 0.151104, 0.075552, 0.15, 0.3, 9.81
    c1, s1 = l1 / 2 * of.cos(q[2]), l1 / 2 * of.sin(q[2])
    c2, s2 = l2 / 2 * of.cos(q[5]), l2 / 2 * of.sin(q[5])
    w1, w2 = v[2] * v[2], v[5] * v[5]
    masses = [m1, m1, m1 * l1 * l1 / 12, m2, m2, m2 * l2 * l2 / 12, m3]
    force = [0.0, -m1 * gravity, 0.0, 0.0, -m2 * gravity, 0.0, 0.0]
    jacobian = [{0: 1.0, 2: s1}, {1: 1.0, 2: -c1}, {0: -1.0, 2: s1, 3: 1.0, 5: s2}, {1: -1.0, 2: -c1, 4: 1.0, 5: -c2},
                {3: -1.0, 5: s2, 6: 1.0}, {4: 1.0, 5: c2}]
    gamma = [c1 * w1, s1 * w1, c1 * w1 + c2 * w2, s1 * w1 + s2 * w2, c2 * w2, -s2 * w2]
    return [[[mass]] for mass in masses], force, jacobian, gamma


MECHANISMS = {"pendulum": pendulum, "caraxis": caraxis, "andrews": andrews, "slidercrank": slidercrank}


def divided(blocks, x):
    """M⁻¹x of a sparse vector, M by its blocks of one or two rows."""
    result, first = {}, 0
    for block in blocks:
        rows = [i for i in range(first, first + len(block)) if i in x]
        if rows and len(block) == 1:
            result[first] = x[first] / block[0][0]
        elif rows:
            (a, b), (_, c) = block
            scale, (y, z) = 1.0 / (a * c - b * b), [x.get(first + i, 0.0) for i in (0, 1)]
            result[first], result[first + 1] = scale * (c * y - b * z), scale * (a * z - b * y)
        first += len(block)
    return result


def product(row, x):
    """Of two sparse vectors."""
    terms = [g * x[i] for i, g in row.items() if i in x]
    return sum(terms[1:], terms[0]) if terms else 0.0


def accelerations(of, mechanism, t, q, v):
    """a and λ from G M⁻¹Gᵀ λ = G M⁻¹f + γ, by Cholesky's factorisation without roots."""
    blocks, force, jacobian, gamma = mechanism(of, t, q, v)
    free = divided(blocks, dict(enumerate(force)))
    columns = [divided(blocks, row) for row in jacobian]
    n = len(jacobian)
    s = [[product(jacobian[l], columns[k]) for l in range(k + 1)] for k in range(n)]
    right = [product(row, free) + more for row, more in zip(jacobian, gamma)]
    lower = [[0.0] * n for _ in range(n)]
    diagonal = []
    for k in range(n):
        for l in range(k):
            known = [lower[k][j] * lower[l][j] * diagonal[j] for j in range(l)]
            lower[k][l] = (s[k][l] - sum(known)) / diagonal[l]
        diagonal.append(s[k][k] - sum(lower[k][j] * lower[k][j] * diagonal[j] for j in range(k)))
    for k in range(n):
        right[k] = right[k] - sum(lower[k][l] * right[l] for l in range(k))
    multipliers = [x / d for x, d in zip(right, diagonal)]
    for k in reversed(range(n)):
        multipliers[k] = multipliers[k] - sum(lower[l][k] * multipliers[l] for l in range(k + 1, n))
    nq = len(force)
    pulls = [[column[i] * x for column, x in zip(columns, multipliers) if i in column] for i in range(nq)]
    return [free.get(i, 0.0) - sum(pull) for i, pull in enumerate(pulls)], multipliers


def integrator(mechanism, request, tolerance):
    """Made once for a tolerance, which decides the order of the series; no run is charged for it. The default is
    straight-line code: slower to make than `compact_mode`, and three to five times as fast."""
    nq = len(request["q"])
    symbols = heyoka.make_vars(*[f"y{i}" for i in range(2 * nq)])
    q, v = symbols[:nq], symbols[nq:]
    a, _ = accelerations(Expressions, mechanism, heyoka.time, q, v)
    system = list(zip(q, v)) + list(zip(v, a))
    return heyoka.taylor_adaptive(system, request["q"] + request["v"], tol=tolerance)


def main():
    """All tolerances, each repeated."""
    request = read()
    mechanism = MECHANISMS[request["problem"]]
    nq, t_end = len(request["q"]), request["t_end"]
    rows = []
    for tolerance in request["tolerances"]:
        solver = integrator(mechanism, request, tolerance)

        def begin(solver=solver):
            solver.time = 0.0
            solver.state[:] = request["q"] + request["v"]

        def run(_, solver=solver):
            return solver.propagate_until(t_end)

        best, spent, n_runs = float("inf"), 0.0, 0
        while n_runs < request["n_max"] and (n_runs < 3 or spent < request["enough_s"]):
            (seconds,), outcome = samples(1, begin, run)
            best, spent, n_runs = min(best, seconds), spent + seconds, n_runs + 1
        y = solver.state.tolist()
        _, multipliers = accelerations(Floats, mechanism, t_end, y[:nq], y[nq:])
        rows.append({
            "tolerance": tolerance,
            "reached": outcome[0] == heyoka.taylor_outcome.time_limit,
            "seconds": best,
            "n_runs": n_runs,
            "q": y[:nq],
            "v": y[nq:],
            "lambda": multipliers,
            "n_step": int(outcome[3]),
        })
    write(rows)


main()
