"""Reverse mode of a large sum in CasADi."""

from common import package, read, samples, write

casadi = package("casadi")

N_SYMBOLS = 60


def large(n_terms, different):
    """The sum of `src/algebra/gradient.rs`."""
    x = casadi.SX.sym("x", N_SYMBOLS)
    xs = [x[i] for i in range(N_SYMBOLS)]
    total = 0
    for k in range(n_terms):
        layer = k // N_SYMBOLS
        product = 1
        for step in (1, 7, 11, 13):
            a, b, c, d, e = (xs[(k * step + i * i + layer) % N_SYMBOLS] for i in range(1, 6))
            weight = (20 * k + step) / 200000 if different else 2 + layer
            product = product * casadi.sin(a + weight * b * c + d + e)
        total = total + product
    return x, total


request = read()
x, total = large(request["n_terms"], request["different"])
times, gradient = samples(
    request["runs"], lambda: None, lambda _: casadi.gradient(total, x)
)
function = casadi.Function("f", [x], [total])
derivative = casadi.Function("g", [x], [gradient])
values = derivative([0.1 + 0.01 * i for i in range(N_SYMBOLS)])
write({
    "version": casadi.__version__,
    "samples": times,
    "n_function": function.n_instructions(),
    "n_gradient": derivative.n_instructions(),
    "gradient": [float(values[i]) for i in range(N_SYMBOLS)],
})
