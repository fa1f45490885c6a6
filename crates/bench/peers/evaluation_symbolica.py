"""Residual and Jacobian of a mechanism in Symbolica: the formulas are given, its JIT evaluates."""

import os
import sys
import time

from common import package, read, samples, write

request = read()
# The package greets on standard output, which belongs to the result.
stdout = os.dup(1)
os.dup2(2, 1)
numpy = package("numpy")
symbolica = package("symbolica")

expressions = [symbolica.E(text) for text in request["texts"]]
inputs = [symbolica.S(name) for name in request["inputs"]]
start = time.process_time()
evaluator = symbolica.Expression.evaluator_multiple(expressions, inputs, jit_compile=True)
points = numpy.array(request["points"]).reshape(-1, len(inputs))
outputs = evaluator.evaluate(points)
compile_s = time.process_time() - start

# Points one after the other in one call: the way into Python takes longer than an evaluation.
many = numpy.tile(points, (request["n_calls"] // len(points) + 1, 1))
times, _ = samples(request["n_samples"], lambda: None, lambda _: evaluator.evaluate(many))
os.dup2(stdout, 1)
write({
    "version": getattr(symbolica, "__version__", "?"),
    "compile_s": compile_s,
    "outputs": [float(value) for value in numpy.asarray(outputs).ravel()],
    "samples": [seconds / len(many) for seconds in times],
})
sys.stdout.flush()
