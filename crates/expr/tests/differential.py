"""Holds claims about expressions, one JSON object a line, against mpmath and SymPy.

Prints each claim that does not hold, then how many were compared; ends with 1 if one did not hold.
"""

import json
import re
import signal
import sys

import mpmath
import sympy
from mpmath import mp, mpf

mp.dps = 60
# Digits that claims agree to, after those that cancellation takes.
DIGITS = mpf(10) ** -30
# Parts beyond this are not computed with.
LARGEST = mpf(10) ** 40
# Time for one derivative by SymPy, s.
SECONDS = 2


class NoValue(Exception):
    """A part has no real finite value."""


def real(function, *arguments):
    try:
        value = function(*arguments)
    except (ValueError, ZeroDivisionError, OverflowError) as fault:
        raise NoValue from fault
    # Angles and exponents of many digits take for ever.
    if isinstance(value, mpmath.mpc) or not abs(value) < LARGEST:
        raise NoValue
    return +value


class Real:
    """A real number with the operators of expressions, and the largest part it was made of."""

    def __init__(self, value, scale=None):
        self.value = value
        self.scale = abs(value) if scale is None else max(scale, abs(value))

    def _with(self, function, *others):
        others = [o if isinstance(o, Real) else Real(mpf(o)) for o in others]
        value = real(function, self.value, *[o.value for o in others])
        return Real(value, max([self.scale] + [o.scale for o in others]))

    def __add__(self, other):
        return self._with(lambda a, b: a + b, other)

    def __sub__(self, other):
        return self._with(lambda a, b: a - b, other)

    def __mul__(self, other):
        return self._with(lambda a, b: a * b, other)

    def __truediv__(self, other):
        return self._with(lambda a, b: a / b, other)

    def __pow__(self, other):
        return self._with(lambda a, b: a**b, other)

    def __neg__(self):
        return self._with(lambda a: -a)


# Where an argument is on the edge of a domain, as in asin(x/x): no derivative is expected there.
edges = []
EDGES = {"asin": 1, "acos": 1, "sqrt": 0, "ln": 0}


def jump(function):
    return lambda a, b: a._with(lambda p, q: mpf(int(function(p, q))), b)


def watched(name):
    """A function of one argument that notes when it is on the edge of its domain."""
    function = getattr(mpmath, name)

    def snapped(x):
        if name in EDGES and abs(abs(x) - EDGES[name]) < mpf(10) ** -40:
            edges.append(name)
        result = function(x)
        # Zero, where only the digits of pi that are left out keep the value from it.
        return mpf(0) if abs(result) < mpf(10) ** -50 else result

    return snapped


FUNCTIONS = {
    name: (lambda f: lambda a: a._with(f))(watched(name))
    for name in "sin cos tan asin acos atan sinh cosh tanh exp ln sqrt sign".split()
}
FUNCTIONS |= {
    "abs": lambda a: a._with(abs),
    "atan2": lambda a, b: a._with(mpmath.atan2, b),
    "min": lambda a, b: a._with(min, b),
    "max": lambda a, b: a._with(max, b),
    "lt": jump(lambda p, q: p < q),
    "le": jump(lambda p, q: p <= q),
    "gt": jump(lambda p, q: p > q),
    "ge": jump(lambda p, q: p >= q),
    "select": lambda c, a, b: (a if c.value != 0 else b)(),
    "number": lambda text: Real(mpf(text)),
}

NUMBER = re.compile(r"(?<![A-Za-z_0-9.])(\d+\.?\d*(?:e[-+]?\d+)?)")


def branches(text):
    """Both branches of each `if` as functions, so that the other one is never computed."""
    while (start := text.find("if(")) >= 0:
        parts, depth, begin = [], 0, start + 3
        for at in range(begin, len(text)):
            if text[at] == "(":
                depth += 1
            elif text[at] == ")" and depth > 0:
                depth -= 1
            elif text[at] in ",)" and depth == 0:
                parts.append(text[begin:at])
                begin = at + 1
                if text[at] == ")":
                    break
        call = f"select({parts[0]}, lambda: {parts[1]}, lambda: {parts[2]})"
        text = text[:start] + call + text[begin:]
    return text


def compiled(text):
    source = NUMBER.sub(r"number('\1')", branches(text)).replace("^", "**")
    return compile(source, "expression", "eval")


def value(text, point):
    """The value of text at a point; `None` where a part has none."""
    names = {name: Real(mpf(x)) for name, x in zip("xyz", point)} | {"pi": Real(+mp.pi)}
    try:
        return eval(compiled(text), {**FUNCTIONS, **names})
    except NoValue:
        return None


def is_close(a, b, digits=DIGITS):
    return abs(a.value - b.value) <= digits * max(1, a.scale, b.scale)


# What has no derivative of its own, or another one at a jump.
SYMPY = {
    "abs": sympy.Abs, "ln": sympy.log, "min": sympy.Min, "max": sympy.Max, "sign": sympy.sign,
}
SYMBOLS = {name: sympy.Symbol(name, real=True) for name in "xyz"} | {"pi": sympy.pi}


def late(*_):
    raise TimeoutError


def sympy_slope(text, point):
    """∂/∂x by SymPy; `None` where it gives no number in time."""
    if "if(" in text or "sign" in text:
        return None
    source = re.sub(r"(\d+\.\d*)", r"Rational('\1')", text).replace("^", "**")
    source = re.sub(r"(?<![\w.'])(\d+)(?![\w.'])", r"Integer(\1)", source)
    names = {"Rational": sympy.Rational, "Integer": sympy.Integer} | SYMPY | SYMBOLS
    for name in "sin cos tan asin acos atan sinh cosh tanh exp sqrt atan2".split():
        names[name] = getattr(sympy, name)
    signal.alarm(SECONDS)
    try:
        slope = sympy.diff(eval(source, names), SYMBOLS["x"])
        at = {SYMBOLS[n]: sympy.Rational(x) for n, x in zip("xyz", point)}
        number = slope.subs(at).evalf(50)
        return Real(mpf(str(number))) if number.is_Float or number.is_Integer else None
    except (TypeError, ValueError, AttributeError, TimeoutError, ZeroDivisionError, RecursionError):
        return None
    finally:
        signal.alarm(0)


def numeric(text, point, order):
    """Derivatives by x up to an order, from values at near points; `None` without them."""
    step = mpf(10) ** -12
    values = []
    for k in range(-3, 4):
        moved = value(text, [mpf(point[0]) + k * step, *point[1:]])
        if moved is None or moved.scale > 1e8:
            return None
        values.append(moved.value)
    a, b, c, d, e, f, g = values
    # Both sides must agree, or there is a kink between.
    first = (-a + 9 * b - 45 * c + 45 * e - 9 * f + g) / (60 * step)
    second = (2 * a - 27 * b + 270 * c - 490 * d + 270 * e - 27 * f + 2 * g) / (180 * step**2)
    one_left, one_right = (d - c) / step, (e - d) / step
    if abs(one_left - one_right) > mpf(10) ** -4 * max(1, abs(first)):
        return None
    return [d, first, second / 2][: order + 1]


def check(claim, report, counts):
    point, text = claim["point"], claim["text"]
    edges.clear()
    exact = value(text, point)
    is_on_edge = bool(edges)

    def compare(kind, found, expected, digits=DIGITS):
        counts[kind] = counts.get(kind, 0) + 1
        if found is None or not is_close(found, expected, digits):
            what = "no value" if found is None else mp.nstr(found.value, 20)
            wanted = mp.nstr(expected.value, 20)
            report(f"{kind}: {what}, expected {wanted}\n  {json.dumps(claim)}")

    if exact is None or exact.scale > 1e12:
        return
    if claim["value"] is not None:
        compare("value", Real(mpf(claim["value"])), exact, mpf(10) ** -10)
    for kind in ("built", "simplified", "expanded"):
        compare(kind, value(claim[kind], point), exact)
    conditions = [value(c, point) for c in claim["nonzero"]]
    signs = [value(c, point) for c in claim["not_negative"]]
    if all(c is not None and c.value != 0 for c in conditions) and all(
        c is not None and c.value >= 0 for c in signs
    ):
        compare("cancelled", value(claim["cancelled"], point), exact)
    derivatives = numeric(text, point, claim["order"])
    if derivatives is None or is_on_edge:
        return
    slope = Real(derivatives[1], max(exact.scale, abs(derivatives[1])))
    for kind in ("slope", "backward"):
        compare(kind, value(claim[kind], point), slope, mpf(10) ** -14)
    by_sympy = sympy_slope(text, point)
    if by_sympy is not None:
        compare("sympy", value(claim["slope"], point), by_sympy, mpf(10) ** -25)
    if claim["series"] is not None:
        # The polynomial away from its point, against the derivatives there.
        offset = mpf(1) / 128
        expected = sum(c * offset**k for k, c in enumerate(derivatives))
        scale = max(exact.scale, *[abs(c) for c in derivatives])
        moved = [mpf(point[0]) + offset, *point[1:]]
        compare("series", value(claim["series"], moved), Real(expected, scale), mpf(10) ** -12)


def main():
    signal.signal(signal.SIGALRM, late)
    faults, counts = [], {}

    def report(fault):
        faults.append(fault)
        print(fault)

    for line in sys.stdin:
        check(json.loads(line), report, counts)
    counts = {kind: counts[kind] for kind in sorted(counts)}
    print(json.dumps(counts | {"faults": len(faults)}))
    sys.exit(1 if faults else 0)


main()
