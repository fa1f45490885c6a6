"""Fortran DOP853 (wrapped by SciPy before 1.17) on a compiled right-hand side.

The wrapper takes capsules of C functions and hands them to Fortran as they are: no Python runs
between the first and the last evaluation.
"""

import ctypes

import numpy
from common import package, read, write

package("scipy")
try:
    from scipy.integrate._dop import dop853
except ImportError:
    dop853 = None

capsule = ctypes.pythonapi.PyCapsule_New
capsule.restype = ctypes.py_object
capsule.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]


def function(library, name):
    """A C function as f2py takes it."""
    return capsule(ctypes.cast(getattr(library, name), ctypes.c_void_p), None, None)


def integrate(library, request, tolerance):
    """One run with rtol = atol = tolerance: end state, CPU seconds and counters."""
    y = numpy.array(request["q"] + request["v"], dtype=float)
    n = len(y)
    work, iwork = numpy.zeros(11 * n + 21), numpy.zeros(21, dtype=numpy.int32)
    iwork[0] = 1_000_000  # steps
    iwork[3] = -1  # no test for stiffness
    rhs, solout = function(library, "rhs"), function(library, "solout")
    library.reset()
    _, y, iwork, idid = dop853(
        rhs, 0.0, y, request["t_end"], [tolerance], [tolerance], solout, 0, work, iwork
    )
    return y, library.elapsed(), iwork, idid


def main():
    """All tolerances, each repeated."""
    request = read()
    library = ctypes.CDLL(request["library"])
    library.elapsed.restype = ctypes.c_double
    nq = library.n_positions()
    rows = []
    for tolerance in request["tolerances"]:
        best, spent, n_runs = float("inf"), 0.0, 0
        while n_runs < request["n_max"] and (n_runs < 3 or spent < request["enough_s"]):
            y, seconds, counters, idid = integrate(library, request, tolerance)
            best, spent, n_runs = min(best, seconds), spent + seconds, n_runs + 1
        multipliers = (ctypes.c_double * library.n_constraints())()
        library.multipliers(
            ctypes.c_double(request["t_end"]),
            y.ctypes.data_as(ctypes.c_void_p),
            multipliers,
        )
        rows.append({
            "tolerance": tolerance,
            "reached": bool(idid == 1),
            "seconds": best,
            "n_runs": n_runs,
            "q": y[:nq].tolist(),
            "v": y[nq:].tolist(),
            "lambda": list(multipliers),
            "n_step": int(counters[17]),
            "n_reject": int(counters[19]),
            "n_residual": int(counters[16]),
            "n_jacobian": 0,
            "n_factor": 0,
        })
    write(rows)


if dop853 is None:
    write({"missing": "the Fortran DOP853 of SciPy before 1.17"})
else:
    main()
