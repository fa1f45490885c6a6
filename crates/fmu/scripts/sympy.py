"""Equations of motion of @NAME@ for SymPy.

    q' = v
    M(q) a + G(t, q)^T lambda = f(t, q, v, u, lambda)
    G a = -gamma(t, q, v),  g(t, q) = 0

    import @MODULE@ as model
    model.M, model.f, model.G, model.gamma, model.g, model.g_t     # matrices
    model.t, model.q, model.v, model.a, model.multipliers, model.u, model.p      # their symbols
    model.dynamics, model.conditions                # M a + G^T lambda - f, G a + gamma
    model.f.subs(model.VALUES)                      # with the values of the model

All numbers are in SI units and radians. `python @FILE@` compares all of this with numbers that bksim computed.
@NOTES@"""

from math import inf, isnan, nan

import sympy as sp
from sympy import Abs as absolute, Max as larger, Min as smaller
from sympy import acos, asin, atan, atan2, cos, cosh, exp, floor, log, sign, sin, sinh, sqrt, tan, tanh

# Names and units; parameters and inputs with their values. MASS and JACOBIAN: row and column of the entries of the lower
# triangle of M, and of G. START, and MOTION that bksim computed: t, q, v. POINTS: arguments and values of `entries`.
@TABLES@

def select(condition, yes, no):
    return sp.Piecewise((no, sp.Eq(condition, 0)), (yes, True))


def lt(a, b):
    return sp.Piecewise((1, sp.Lt(a, b)), (0, True))


def le(a, b):
    return sp.Piecewise((1, sp.Le(a, b)), (0, True))


def gt(a, b):
    return lt(b, a)


def ge(a, b):
    return le(b, a)


def entries(inputs, parameters):
    """Numbers of M (lower triangle), f, G, gamma, g and its rate by time that are not always zero."""
@BODY@


N, R, L = len(COORDINATES), len(MULTIPLIERS), len(PRESSING)


def _symbols(table):
    return [sp.Symbol(row[0], real=True) for row in table]


t = sp.Symbol("t", real=True)
q, v, u, p = (_symbols(table) for table in (COORDINATES, RATES, INPUTS, PARAMETERS))
a = [sp.Symbol(f"a[{i}]", real=True) for i in range(N)]
multipliers = _symbols(MULTIPLIERS)
#: Values of parameters and inputs by symbol.
VALUES = dict(zip(p + u, [row[2] for row in PARAMETERS + INPUTS]))

#: The multipliers that f depends on.
pressing = [multipliers[_k] for _k in PRESSING]
_all = [sp.sympify(value) for value in entries([t] + q + v + u + pressing, p)]
_values = iter(_all)
M, f, G = sp.zeros(N, N), sp.zeros(N, 1), sp.zeros(R, N)
for _i, _j in MASS:
    M[_i, _j] = M[_j, _i] = next(_values)
for _i in range(N):
    f[_i] = next(_values)
for _i, _j in JACOBIAN:
    G[_i, _j] = next(_values)
gamma, g, g_t = (sp.Matrix(R, 1, [next(_values) for _ in range(R)]) for _ in range(3))

#: Both are zero along a motion.
dynamics = M * sp.Matrix(N, 1, a) + G.T * sp.Matrix(R, 1, multipliers) - f
conditions = G * sp.Matrix(N, 1, a) + gamma


def check():
    """Compares values with those that bksim computed, and G, gamma with the derivatives of g; the largest relative
    differences."""
    arguments = [t] + q + v + u + pressing
    function = sp.lambdify([arguments, p], _all, modules="math", cse=True)
    # g' = G v + g_t and g'' = G a + gamma: derivatives along a motion, where conditions are on positions.
    rate = g.jacobian(q) * sp.Matrix(N, 1, v) + g.diff(t) if R else g
    rates = sp.lambdify([arguments, p], list(rate) + list(G * sp.Matrix(N, 1, v) + g_t), modules="math", cse=True)
    worst = [0.0, 0.0]
    for point, of_parameters, expected in POINTS:
        size = max((abs(x) for x in expected if not isnan(x)), default=1.0)
        if any(isnan(x) for x in expected):
            continue
        for found, x in zip(function(point, of_parameters), expected):
            worst[0] = max(worst[0], abs(found - x) / (1e-3 * size + abs(x)))
        both = rates(point, of_parameters)
        for i in range(R):
            if g[i] != 0:
                worst[1] = max(worst[1], abs(both[i] - both[R + i]) / (1 + abs(both[R + i])))
    assert worst[0] < 1e-9, f"values differ by {worst[0]}"
    assert worst[1] < 1e-9, f"derivatives differ by {worst[1]}"
    for at, of_q, of_v in [START] + MOTION:
        of_inputs = [row[2] for row in INPUTS] + [1.0] * L
        values = function([at] + of_q + of_v + of_inputs, [row[2] for row in PARAMETERS])
        end = len(values) - N * L - R
        open_by = max((abs(x) for x in values[end - R : end]), default=0.0)
        assert open_by < 1e-8, f"the motion leaves the conditions by {open_by} at {at}"
    return worst


if __name__ == "__main__":
    values, derivatives = check()
    print(f"values differ by {values:.1e}, derivatives by {derivatives:.1e}")
