"""Residual and Jacobian of the three mechanisms, derived and written as C by CasADi."""

from common import read, write
from machines_casadi import MACHINES, SX, casadi, source


def generate(system):
    """The C source of one function from (q, v, a, lambda) to all outputs."""
    nq, nc = system["nq"], system["nc"]
    own = [SX.sym(name, n) for name, n in (("q", nq), ("v", nq), ("a", nq), ("l", nc))]
    r, g, mass = MACHINES[system["name"]](system["parameters"], own)
    blocks = [casadi.jacobian(r, own[0]), casadi.jacobian(r, own[1]), mass, casadi.jacobian(g, own[0])]
    outputs = [r, g]
    for block, entries in zip(blocks, system["entries"]):
        outputs += [block[i, j] for i, j in entries]
    f = casadi.Function("casadi_f", [casadi.vertcat(*own)], [casadi.vertcat(*outputs)])
    return {"source": source(f), "n_instructions": f.n_instructions()}


request = read()
write({"version": casadi.__version__, **generate(request)})
