"""Residual, constraints and mass matrix of mechanisms in CasADi, and functions of CasADi as C."""

import os
import tempfile

from common import package

casadi = package("casadi")
SX, cos, sin, sqrt = casadi.SX, casadi.cos, casadi.sin, casadi.sqrt


def lagrange(kinetic, potential, force, constraints, state):
    """r and g from energies, generalised forces and constraints."""
    q, v, a, multipliers = state
    momentum = casadi.gradient(kinetic, v)
    mass = casadi.jacobian(momentum, v)
    bias = casadi.jtimes(momentum, q, v) - casadi.gradient(kinetic, q)
    g = casadi.vertcat(*constraints)
    reaction = casadi.jtimes(g, q, multipliers, True)
    return mass @ a + bias + casadi.gradient(potential, q) - force + reaction, g, mass


def slider_crank(p, state):
    q, v = state[0], state[1]
    theta1, x2, y2, theta2, x3 = (q[i] for i in range(5))
    l1, s2 = p["l1"], p["s2"]
    kinetic = 0.5 * (
        p["i1"] * v[0] ** 2 + p["m2"] * (v[1] ** 2 + v[2] ** 2) + p["i2"] * v[3] ** 2 + p["m3"] * v[4] ** 2
    )
    potential = p["g"] * (p["m1"] * p["s1"] * sin(theta1) + p["m2"] * y2)
    constraints = [
        x2 + s2 * cos(theta2) - x3,
        y2 + s2 * sin(theta2),
        l1 * cos(theta1) - (x2 - s2 * cos(theta2)),
        l1 * sin(theta1) - (y2 - s2 * sin(theta2)),
    ]
    force = casadi.vertcat(p["q1"], 0, 0, 0, 0)
    return lagrange(kinetic, potential, force, constraints, state)


def five_link(p, state):
    q, v = state[0], state[1]
    t1, x2, y2, t2, x3, x4, y4, t4, t5 = (q[i] for i in range(9))
    m, i, l1, s1, s2, s4 = (p[name] for name in ("m", "i", "l1", "s1", "s2", "s4"))
    weights = casadi.vertcat(i, m, m, i, m, m, m, i, i)
    kinetic = 0.5 * casadi.dot(weights, v * v)
    potential = p["g"] * m * (s1 * sin(t1) + y2 + y4 + p["s5"] * sin(t5))
    constraints = [
        x2 - (x4 + s4 * cos(t4)),
        y2 - (y4 + s4 * sin(t4)),
        x4 - s4 * cos(t4) - (p["h1"] + p["l5"] * cos(t5)),
        y4 - s4 * sin(t4) - (p["h2"] + p["l5"] * sin(t5)),
        x2 + s2 * cos(t2) - x3,
        y2 + s2 * sin(t2),
        l1 * cos(t1) - (x2 - s2 * cos(t2)),
        l1 * sin(t1) - (y2 - s2 * sin(t2)),
    ]
    force = casadi.vertcat(p["q1"], *[0] * 8)
    return lagrange(kinetic, potential, force, constraints, state)


def andrews(p, state):
    """M and f as printed in HW2 §VII.7."""
    q, v, a, multipliers = state
    b, th, ga, ph, de, om, ep = (q[i] for i in range(7))
    b_v, th_v, _, ph_v, de_v, om_v, ep_v = (v[i] for i in range(7))
    d, da, e, ea, rr, u, zf, zt, fa = (p[n] for n in ("d", "da", "e", "ea", "rr", "u", "zf", "zt", "fa"))
    m2, m4, m6, sc, sd, ss = (p[n] for n in ("m2", "m4", "m6", "sc", "sd", "ss"))
    dx = sd * cos(ga) + sc * sin(ga) + p["xb"] - p["xc"]
    dy = sd * sin(ga) - sc * cos(ga) + p["yb"] - p["yc"]
    length = sqrt(dx**2 + dy**2)
    spring = -p["c0"] * (length - p["l0"]) / length
    mass = SX(7, 7)
    mass[0, 0] = p["m1"] * p["ra"] ** 2 + m2 * (rr**2 - 2 * da * rr * cos(th) + da**2) + p["i1"] + p["i2"]
    mass[1, 0] = m2 * (da**2 - da * rr * cos(th)) + p["i2"]
    mass[1, 1] = m2 * da**2 + p["i2"]
    mass[2, 2] = p["m3"] * (p["sa"] ** 2 + p["sb"] ** 2) + p["i3"]
    mass[3, 3] = m4 * (e - ea) ** 2 + p["i4"]
    mass[4, 3] = m4 * ((e - ea) ** 2 + zt * (e - ea) * sin(ph)) + p["i4"]
    mass[4, 4] = (
        m4 * (zt**2 + 2 * zt * (e - ea) * sin(ph) + (e - ea) ** 2)
        + p["m5"] * (p["ta"] ** 2 + p["tb"] ** 2) + p["i4"] + p["i5"]
    )
    mass[5, 5] = m6 * (zf - fa) ** 2 + p["i6"]
    mass[6, 5] = m6 * ((zf - fa) ** 2 - u * (zf - fa) * sin(om)) + p["i6"]
    mass[6, 6] = (
        m6 * ((zf - fa) ** 2 - 2 * u * (zf - fa) * sin(om) + u**2)
        + p["m7"] * (p["ua"] ** 2 + p["ub"] ** 2) + p["i6"] + p["i7"]
    )
    mass = casadi.tril2symm(casadi.tril(mass))
    force = casadi.vertcat(
        p["mom"] - m2 * da * rr * th_v * (th_v + 2 * b_v) * sin(th),
        m2 * da * rr * b_v**2 * sin(th),
        spring * (dx * (sc * cos(ga) - sd * sin(ga)) + dy * (sd * cos(ga) + sc * sin(ga))),
        m4 * zt * (e - ea) * de_v**2 * cos(ph),
        -m4 * zt * (e - ea) * ph_v * (ph_v + 2 * de_v) * cos(ph),
        -m6 * u * (zf - fa) * ep_v**2 * cos(om),
        m6 * u * (zf - fa) * om_v * (om_v + 2 * ep_v) * cos(om),
    )
    x, y = rr * cos(b) - d * cos(b + th), rr * sin(b) - d * sin(b + th)
    g = casadi.vertcat(
        x - ss * sin(ga) - p["xb"],
        y + ss * cos(ga) - p["yb"],
        x - e * sin(ph + de) - zt * cos(de) - p["xa"],
        y + e * cos(ph + de) - zt * sin(de) - p["ya"],
        x - zf * cos(om + ep) - u * sin(ep) - p["xa"],
        y - zf * sin(om + ep) + u * cos(ep) - p["ya"],
    )
    return mass @ a - force + casadi.jtimes(g, q, multipliers, True), g, mass


def chain(p, state):
    """Links by relative angles."""
    q, v = state[0], state[1]
    kinetic, potential, angle, x, y = 0, 0, 0, 0, 0
    for i in range(q.numel()):
        l, a, m, inertia = (p[f"{name}{i + 1}"] for name in ("l", "a", "m", "I"))
        angle = angle + q[i]
        centre = casadi.vertcat(x + a * cos(angle), y + a * sin(angle))
        velocity = casadi.jtimes(centre, q, v)
        rate = casadi.jtimes(angle, q, v)
        kinetic += 0.5 * m * casadi.dot(velocity, velocity) + 0.5 * inertia * rate * rate
        potential += m * p["g"] * centre[1]
        x, y = x + l * cos(angle), y + l * sin(angle)
    return lagrange(kinetic, potential, 0, [], state)


MACHINES = {"slider_crank": slider_crank, "five_link": five_link, "andrews": andrews, "chain": chain}


def source(f):
    """The C source of a function."""
    with tempfile.TemporaryDirectory() as folder:
        before = os.getcwd()
        os.chdir(folder)
        try:
            f.generate("casadi_f.c")
            with open("casadi_f.c", encoding="utf-8") as text:
                return text.read()
        finally:
            os.chdir(before)
