"""The functions of `bksim code --part dynamics`, derived and written as C by CasADi.

M a + G' l = f, G a = -gamma: `terms` are M, f, G and gamma, `accelerations` are a, then l. CasADi has two ways to solve
symbolically: QR of the whole system, and L D L' of M and of G M^-1 G'.
"""

from common import read, write
from machines_casadi import MACHINES, SX, casadi, source


def terms(system, q, v, p):
    """M, f, G and gamma; `order` has the place of each coordinate of the machine among ours."""
    order, nc = system["order"], system["nc"]
    zeros = [SX.zeros(len(order)), SX.zeros(nc)]
    named = [casadi.vertcat(*[x[k] for k in order]) for x in (q, v)]
    # Derivatives are by symbols.
    state = [SX.sym(name, len(order)) for name in ("q", "v")]
    r, g, mass = MACHINES[system["name"]](p, [*state, *zeros])
    jacobian = casadi.jacobian(g, state[0])
    gamma = casadi.jtimes(casadi.jtimes(g, state[0], state[1]), state[0], state[1]) if nc else SX.zeros(0)
    r, jacobian, gamma, mass = casadi.substitute([r, jacobian, gamma, mass], state, named)
    place = [order.index(k) for k in range(len(order))]
    columns = jacobian[:, place] if nc else SX.zeros(0, len(order))
    return mass[place, place], -r[place], columns, gamma


def by_qr(mass, f, jacobian, gamma):
    """The whole system at once."""
    nc = jacobian.shape[0]
    matrix = casadi.blockcat([[mass, jacobian.T], [jacobian, SX(nc, nc)]]) if nc else mass
    return casadi.solve(matrix, casadi.vertcat(f, -gamma))


def by_ldl(mass, f, jacobian, gamma):
    """M first, then the multipliers."""
    free = solve_ldl(mass, f)
    if not jacobian.shape[0]:
        return free
    columns = casadi.horzcat(*[solve_ldl(mass, jacobian[k, :].T) for k in range(jacobian.shape[0])])
    multipliers = solve_ldl(jacobian @ columns, jacobian @ free + gamma)
    return casadi.vertcat(free - columns @ multipliers, multipliers)


def solve_ldl(matrix, b):
    d, lt, permutation = casadi.ldl(matrix)
    return casadi.ldl_solve(b, d, lt, permutation)


def rows(matrix):
    """A matrix row by row, with its zeros."""
    return casadi.vec(casadi.densify(matrix).T)


request = read()
nq = len(request["order"])
q, v = SX.sym("q", nq), SX.sym("v", nq)
names = request["parameters"]
p = SX.sym("p", len(names))
mass, f, jacobian, gamma = terms(request, q, v, {name: p[k] for k, name in enumerate(names)})
time = SX.sym("t")
state = casadi.vertcat(time, q, v)
functions = {
    "terms": casadi.vertcat(rows(mass), f, rows(jacobian), gamma),
    "accelerations, QR": by_qr(mass, f, jacobian, gamma),
    "accelerations, LDL": by_ldl(mass, f, jacobian, gamma),
}
found = {}
for name, output in functions.items():
    function = casadi.Function("casadi_f", [state, p], [casadi.densify(output)])
    found[name] = {"source": source(function), "n_instructions": function.n_instructions()}
write({"version": casadi.__version__, "functions": found})
