"""Equations of motion of @NAME@ for JAX.

    q' = v
    M(q) a + G(t, q)^T lambda = f(t, q, v, u, l)
    G a = -gamma(t, q, v),  g(t, q) = 0

    import @MODULE@ as model
    M, f, G, gamma, g, g_t = model.terms(t, q, v, u, p)
    a, multipliers = model.accelerations(t, q, v, u, p)
    x_rate = model.ode(t, x, u, p)        # x = (q, v)
    jax.grad, jax.jit, jax.vmap of all of them

u are the values of INPUTS, p those of PARAMETERS: model.U and model.P unless given. All numbers are in SI units and
radians, in double precision. `python @FILE@` compares all of this with numbers that bksim computed.
@NOTES@"""

from math import inf, isnan, nan

import jax
import jax.numpy as jnp
from jax.experimental.ode import odeint
from jax.numpy import abs as absolute, arccos as acos, arcsin as asin, arctan as atan, arctan2 as atan2
from jax.numpy import cos, cosh, exp, floor, log, maximum as larger, minimum as smaller, sign, sin, sinh, sqrt, tan, tanh

jax.config.update("jax_enable_x64", True)

#: How fast what integration leaves of g goes back to zero, 1/s.
STABILISATION = 10.0

# Names and units; parameters and inputs with their values. MASS and JACOBIAN: row and column of the entries of the lower
# triangle of M, and of G. START, and MOTION that bksim computed: t, q, v. POINTS: arguments and values of `entries`.
@TABLES@

def select(condition, yes, no):
    return jnp.where(condition != 0, yes, no)


def lt(a, b):
    return jnp.where(a < b, 1.0, 0.0)


def le(a, b):
    return jnp.where(a <= b, 1.0, 0.0)


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
P = jnp.array([value for _, _, value in PARAMETERS], dtype=float)
U = jnp.array([value for _, _, value in INPUTS], dtype=float)


def _matrix(places, values, shape):
    matrix = jnp.zeros(shape)
    if places:
        rows, columns = zip(*places)
        matrix = matrix.at[jnp.array(rows), jnp.array(columns)].set(values)
    return matrix


def _parts(t, q, v, u, p, l):
    """Entries of M, f, G, gamma, g, its rate by time, and of the slopes of f by `l`."""
    state = [jnp.reshape(jnp.asarray(t, dtype=float), 1), q, v, jnp.asarray(u, dtype=float), l]
    values = jnp.stack([jnp.asarray(value, dtype=float) for value in entries(jnp.concatenate(state), jnp.asarray(p, dtype=float))])
    parts, at = [], 0
    for n in (len(MASS), N, len(JACOBIAN), R, R, R, N * L):
        parts.append(values[at : at + n])
        at += n
    return parts


def terms(t, q, v, u=U, p=P, l=jnp.zeros(L)):
    """M, f, G, gamma, g and its rate by time; `l` are the multipliers that f depends on, with the places PRESSING."""
    parts = _parts(t, q, v, u, p, l)
    lower = _matrix(MASS, parts[0], (N, N))
    M = lower + lower.T - jnp.diag(jnp.diag(lower))
    return M, parts[1], _matrix(JACOBIAN, parts[2], (R, N)), *parts[3:6]


def accelerations(t, q, v, u=U, p=P):
    """Accelerations a and multipliers; nan where those that f depends on do not settle."""
    M, f, G, gamma, g, g_t = terms(t, q, v, u, p)
    aim = -gamma - 2 * STABILISATION * (G @ v + g_t) - STABILISATION**2 * g

    def solved(f, S):
        K = jnp.block([[M, G.T - S], [G, jnp.zeros((R, R))]])
        return jnp.linalg.solve(K, jnp.concatenate([f, aim]))

    found = solved(f, jnp.zeros((N, R)))
    for _ in range(ROUNDS * (L > 0)):
        before = found[N:]
        l = before[jnp.array(PRESSING)]
        parts = _parts(t, q, v, u, p, l)
        slopes = jnp.reshape(parts[6], (N, L))
        S = jnp.zeros((N, R)).at[:, jnp.array(PRESSING)].set(slopes)
        found = solved(parts[1] - slopes @ l, S)
        moved = jnp.max(jnp.abs(found[N:] - before))
    if L > 0:
        found = jnp.where(moved <= 1e-12 * jnp.max(jnp.abs(found[N:])), found, nan)
    return found[:N], found[N:]


def ode(t, x, u=U, p=P):
    """Rate of x = (q, v)."""
    a, _ = accelerations(t, x[:N], x[N:], u, p)
    return jnp.concatenate([x[N:], a])


def check():
    """Compares values and motion with those that bksim computed; the largest differences, relative to one and the value."""
    worst = [0.0, 0.0]
    for point, of_parameters, expected in POINTS:
        size = max((abs(x) for x in expected if not isnan(x)), default=1.0)
        for found, x in zip(entries(jnp.array(point), jnp.array(of_parameters)), expected):
            worst[0] = max(worst[0], 0.0 if isnan(x) else abs(float(found) - x) / (1e-3 * size + abs(x)))
    assert worst[0] < 1e-9, f"values differ by {worst[0]}"
    if MOTION:
        t0, q0, v0 = START
        times = jnp.array([t0] + [t for t, _, _ in MOTION])
        motion = odeint(lambda x, t: ode(t, x), jnp.array(q0 + v0), times, rtol=1e-12, atol=1e-12, mxstep=1000000)
        for found, (_, q, v) in zip(motion[1:], MOTION):
            expected = jnp.array(q + v)
            worst[1] = max(worst[1], float(jnp.max(jnp.abs(found - expected) / (1 + jnp.abs(expected)))))
        assert worst[1] < 1e-8, f"motion differs by {worst[1]}"
    return worst


if __name__ == "__main__":
    values, motion = check()
    of_motion = f"motion by {motion:.1e}" if MOTION else "no motion is compared"
    print(f"values differ by {values:.1e}, {of_motion}")
