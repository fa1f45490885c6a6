"""M, h and dV/dq of a chain of links by Lagrange's equations, unfolded, in CasADi."""

from common import package, read, samples, write

casadi = package("casadi")


def symbols(n):
    """Parameters, relative angles and their rates."""
    each = {name: [casadi.SX.sym(f"{name}{i}") for i in range(n)] for name in ("l", "a", "m", "I")}
    return each, casadi.SX.sym("g"), casadi.SX.sym("q", n), casadi.SX.sym("v", n)


def derive(state):
    """d/dt dT/dv - dT/dq + dV/dq = M a + h + dV/dq."""
    each, g, q, v = state
    kinetic, potential, angle, x, y = 0, 0, 0, 0, 0
    for i in range(q.numel()):
        l, a, m, inertia = (each[name][i] for name in ("l", "a", "m", "I"))
        angle = angle + q[i]
        cosine, sine = casadi.cos(angle), casadi.sin(angle)
        centre = casadi.vertcat(x + a * cosine, y + a * sine)
        velocity = casadi.jtimes(centre, q, v)
        rate = casadi.jtimes(angle, q, v)
        kinetic += 0.5 * m * casadi.dot(velocity, velocity) + 0.5 * inertia * rate * rate
        potential += m * g * centre[1]
        x, y = x + l * cosine, y + l * sine
    momentum = casadi.gradient(kinetic, v)
    mass_matrix = casadi.jacobian(momentum, v)
    bias = casadi.jtimes(momentum, q, v) - casadi.gradient(kinetic, q)
    return mass_matrix, bias, casadi.gradient(potential, q), state


def n_instructions(result):
    """Instructions of the derived functions together."""
    *outputs, (each, g, q, v) = result
    parameters = [p for group in each.values() for p in group]
    return casadi.Function("f", [q, v, casadi.vertcat(g, *parameters)], outputs).n_instructions()


request = read()
times, instructions = {}, {}
for size in request["sizes"]:
    times[str(size)], derived = samples(request["runs"], lambda: symbols(size), derive)
    instructions[str(size)] = n_instructions(derived)
write({"version": casadi.__version__, "samples": times, "instructions": instructions})
