"""Solves of the Python package: CPU seconds of each run, with the motion between samples and without."""

import common

bksim = common.package("bksim")
wanted = common.read()
model = bksim.load(wanted["model"])
found = {}
for dense in (True, False):

    def solve(_, dense=dense):
        return model.solve(t_end=wanted["t_end"], rtol=wanted["rtol"], dense=dense, progress=False)

    solve(None)
    times, solution = common.samples(wanted["runs"], lambda: None, solve)
    found["dense" if dense else "samples"] = times
    found["last"] = [float(q) for q in solution.q[:, -1]]
common.write(found)
