"""Equations of motion of @NAME@ for CasADi.

    q' = v
    M(q) a + G(t, q)^T lambda = f(t, q, v, u, l)
    G a = -gamma(t, q, v),  g(t, q) = 0

    import @MODULE@ as model
    M, f, G, gamma, g, g_t = model.terms(t, q, v, u, p)         # ..., p, l) where PRESSING is not empty
    a, multipliers = model.accelerations(t, q, v, u, p)
    x_rate = model.ode(t, x, u, p)        # x = (q, v)
    casadi.integrator("motion", "idas", model.dae, t0, times)

u are the values of INPUTS, p those of PARAMETERS: model.U and model.P; l are the multipliers that f depends on, whose
places are PRESSING: `accelerations` finds them by Newton's method, and gives nan where it does not settle. All numbers are in SI units and radians.
`python @FILE@` compares all of this with numbers that bksim computed.
@NOTES@"""

from math import inf, isnan, nan

import casadi as ca
from casadi import acos, asin, atan, atan2, cos, cosh, exp, floor, log, sign, sin, sinh, sqrt, tan, tanh
from casadi import fabs as absolute, fmax as larger, fmin as smaller

#: How fast what integration leaves of g goes back to zero, 1/s.
STABILISATION = 10.0

# Names and units; parameters and inputs with their values. MASS and JACOBIAN: row and column of the entries of the lower
# triangle of M, and of G. START, and MOTION that bksim computed: t, q, v. POINTS: arguments and values of `entries`.
@TABLES@

def select(condition, yes, no):
    return ca.if_else(condition, yes, no)


def lt(a, b):
    return ca.if_else(a < b, 1.0, 0.0)


def le(a, b):
    return ca.if_else(a <= b, 1.0, 0.0)


def gt(a, b):
    return lt(b, a)


def ge(a, b):
    return le(b, a)


def entries(inputs, parameters):
    """Numbers of M (lower triangle), f, G, gamma, g and its rate by time that are not always zero."""
@BODY@


N, R, L = len(COORDINATES), len(MULTIPLIERS), len(PRESSING)
#: Steps of Newton's method to multipliers that f depends on.
ROUNDS = 12
P = [value for _, _, value in PARAMETERS]
U = [value for _, _, value in INPUTS]


def _elements(vector):
    return [vector[i] for i in range(vector.numel())]


def _of(symbol):
    sizes = [("t", 1), ("q", N), ("v", N), ("u", len(U)), ("p", len(P))]
    return [symbol(name, n) for name, n in sizes]


def _function(name, arguments, results, names):
    inputs = ["t", "q", "v", "u", "p", "l"][: len(arguments)]
    return ca.Function(name, arguments, results, inputs, names)


def _terms():
    t, q, v, u, p = arguments = _of(ca.SX.sym)
    l = ca.SX.sym("l", L)
    arguments += [l] * (L > 0)
    values = iter(entries(_elements(ca.vertcat(t, q, v, u, l)), _elements(p)))
    M, f, G = ca.SX(N, N), ca.SX(N, 1), ca.SX(R, N)
    for i, j in MASS:
        M[i, j] = M[j, i] = next(values)
    for i in range(N):
        f[i] = next(values)
    for i, j in JACOBIAN:
        G[i, j] = next(values)
    gamma, g, g_t = (ca.vertcat(*[next(values) for _ in range(R)]) if R else ca.SX(0, 1) for _ in range(3))
    slopes = ca.SX(N, R)
    for i in range(N):
        for k in PRESSING:
            slopes[i, k] = next(values)
    results, names = [M, f, G, gamma, g, g_t], ["M", "f", "G", "gamma", "g", "g_t"]
    return _function("terms", arguments, results, names), _function("slopes", arguments, [slopes], ["slopes"])


#: `slopes` are those of f by the multipliers.
terms, slopes = _terms()


def _aim(v, G, gamma, g, g_t):
    """Right side of G a = ..., which draws g back to zero."""
    return -gamma - 2 * STABILISATION * (G @ v + g_t) - STABILISATION**2 * g


def _accelerations():
    arguments = t, q, v, u, p = _of(ca.MX.sym)

    def solved(f, S):
        K = ca.vertcat(ca.horzcat(M, G.T - S), ca.horzcat(G, ca.MX(R, R)))
        return ca.solve(K, ca.vertcat(f, _aim(v, G, gamma, g, g_t)), "qr")

    M, f, G, gamma, g, g_t = terms(*arguments, *[ca.MX(L, 1)] * (L > 0))
    found = solved(f, ca.MX(N, R))
    for _ in range(ROUNDS * (L > 0)):
        multipliers = found[N:]
        at = *arguments, multipliers[PRESSING]
        S = slopes(*at)
        found = solved(terms(*at)[1] - S @ multipliers, S)
        moved = ca.norm_inf(found[N:] - multipliers)
    if L > 0:
        found = ca.if_else(moved <= 1e-12 * ca.norm_inf(found[N:]), found, ca.MX.nan(N + R, 1))
    return _function("accelerations", arguments, [found[:N], found[N:]], ["a", "lambda"])


accelerations = _accelerations()


def _ode():
    t, u, p, x = ca.MX.sym("t"), ca.MX.sym("u", len(U)), ca.MX.sym("p", len(P)), ca.MX.sym("x", 2 * N)
    a, _ = accelerations(t, x[:N], x[N:], u, p)
    return ca.Function("ode", [t, x, u, p], [ca.vertcat(x[N:], a)], ["t", "x", "u", "p"], ["x_rate"])


ode = _ode()


def _dae():
    t, q, v, u, p = _of(ca.SX.sym)
    a, multipliers = ca.SX.sym("a", N), ca.SX.sym("lambda", R)
    M, f, G, gamma, g, g_t = terms(t, q, v, u, p, *[multipliers[PRESSING]] * (L > 0))
    rest = ca.vertcat(M @ a + G.T @ multipliers - f, G @ a - _aim(v, G, gamma, g, g_t))
    return {
        "t": t,
        "x": ca.vertcat(q, v),
        "z": ca.vertcat(a, multipliers),
        "u": u,
        "p": p,
        "ode": ca.vertcat(v, a),
        "alg": rest,
    }


#: Index 1: x = (q, v), z = (a, lambda).
dae = _dae()


def check():
    """Compares values and motion with those that bksim computed; the largest differences, relative to one and the value."""
    inputs, parameters = ca.SX.sym("inputs", 1 + 2 * N + len(U) + L), ca.SX.sym("parameters", len(P))
    values = ca.vertcat(*entries(_elements(inputs), _elements(parameters)))
    function = ca.Function("entries", [inputs, parameters], [values])
    worst = [0.0, 0.0]
    for point, of_parameters, expected in POINTS:
        size = max((abs(x) for x in expected if not isnan(x)), default=1.0)
        for found, x in zip(_elements(function(point, of_parameters)), expected):
            worst[0] = max(worst[0], 0.0 if isnan(x) else abs(float(found) - x) / (1e-3 * size + abs(x)))
    assert worst[0] < 1e-9, f"values differ by {worst[0]}"
    if MOTION:
        t0, q0, v0 = START
        x, u, p = ca.MX.sym("x", 2 * N), ca.MX.sym("u", len(U)), ca.MX.sym("p", len(P))
        t = ca.MX.sym("t")
        problem = {"t": t, "x": x, "u": u, "p": p, "ode": ode(t, x, u, p)}
        options = {"abstol": 1e-13, "reltol": 1e-13, "max_num_steps": 1000000}
        motion = ca.integrator("motion", "cvodes", problem, t0, [t for t, _, _ in MOTION], options)
        found = motion(x0=q0 + v0, u=U, p=P)["xf"]
        for k, (_, q, v) in enumerate(MOTION):
            for i, x in enumerate(q + v):
                worst[1] = max(worst[1], abs(float(found[i, k]) - x) / (1 + abs(x)))
        assert worst[1] < 1e-8, f"motion differs by {worst[1]}"
    return worst


if __name__ == "__main__":
    values, motion = check()
    of_motion = f"motion by {motion:.1e}" if MOTION else "no motion is compared"
    print(f"values differ by {values:.1e}, {of_motion}")
