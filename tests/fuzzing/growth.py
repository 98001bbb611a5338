"""Small system files that ask for a lot of work: nests, definitions that double, products, large families.

Every choice is made by the ``random.Random`` that is handed over. The files are right, or nearly so: what is
large is what becomes of them.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random

FUNCTIONS = ("sin", "cos", "tanh", "exp", "sqrt", "atan", "cosh", "log")
STOP = "solve: {stop: 0.001, samples: 2}\n"


def system(source: Random) -> tuple[str, str]:
    """The kind of a system file, and its text."""
    kind = source.choice(list(KINDS))
    return kind, KINDS[kind](source)


def particle(source: Random, potential: str, definitions: str = "", x: str = "x", **more: str) -> str:
    """One or two coordinates, a particle at ``(x, y)`` and a potential."""
    given = "".join(f"{key}: {value}\n" for key, value in more.items())
    head = f"definitions:\n{definitions}" if definitions else ""
    return (
        "parameters: {k: 1.3}\ncoordinates:\n  x: {initial: 0.4, velocity: 0.1}\n  y: {initial: 0.2}\n"
        f"{head}masses: {{b: k}}\nembedding:\n  b: ['{x}', 'y']\npotential: '{potential}'\n{given}{STOP}"
    )


def nest(source: Random) -> str:
    """Functions of functions, with sums, products or roots between."""
    function, depth = source.choice(FUNCTIONS), source.choice((5, 12, 25, 40, 60))
    inside = source.choice(("x + ", "x*y + ", "1 + x**2 + ", "t*x + ", "x/(2 + y) + "))
    text = f"{function}({inside}" * depth + "x" + ")" * depth
    return particle(source, "x**2", x=text) if source.random() < 0.5 else particle(source, text)


def doubling(source: Random) -> str:
    """Definitions each of which uses the one before it more than once."""
    step = source.choice(
        (
            "(1 + {0})*(2 + {0})", "{0} + {0}*sin({0})", "{0}*{0}", "({0} + y)/(3 + {0}**2)",
            "sqrt(1 + {0}**2)",
            "{0}**2 + x*{0}", "exp(-{0})*{0}", "cos({0} - y)*{0}", "({0} + t)**3",
        )
    )  # fmt: skip
    depth = source.choice((3, 6, 9, 12, 16, 30))
    lines = ["  a0: x\n", *(f"  a{i + 1}: '{step.format(f'a{i}')}'\n" for i in range(depth))]
    last, body = f"a{depth}", "".join(lines)
    return particle(source, "x**2", body, x=last) if source.random() < 0.4 else particle(source, last, body)


def product(source: Random) -> str:
    """Many factors, of numbers, quotients, powers or functions."""
    factor = source.choice(
        (
            "(x + {0})", "(x + {0})/(y - {0}.5)", "(x + {0}*y)**2", "sin({0}*x + y)", "(x + {0}*t)",
            "(x**2 + {0}*y + 1)**-1", "sqrt(x**2 + {0} + 1)",
        )
    )  # fmt: skip
    count = source.choice((5, 20, 60, 150, 240))
    text = "*".join(factor.format(i) for i in range(count))
    while len(text) > 9000:
        text = text[: text.rindex("*(") if "*(" in text else 9000]
    return particle(source, text)


def power(source: Random) -> str:
    """Powers of sums, and powers of these."""
    text = source.choice(("(1 + x + y)", "(x - k*y + t)", "(sin(x) + cos(y))", "(1 + x**2)"))
    for _ in range(source.choice((1, 2, 3))):
        exponent = source.choice((2, 3, 5, 12, 63, -1, -3, 0.5, "x", "(1/3)"))
        text = f"({text}**{exponent} + {source.choice('xy')})"
    return particle(source, text, x=source.choice(("x", "x*cos(y)")))


def family(source: Random) -> str:
    """Chains, fields and bodies of many coordinates, coupled by neighbours, by all, or in the masses."""
    size = source.choice((3, 10, 30, 100, 400, 3000, 45_000))
    coupling = source.choice(
        (
            "sum((x[i] - x[(i + 1) % N])**4 for i in range(N))", "sum(x[i]**2 for i in range(N))",
            "sum(1/sqrt((x[i] - x[j])**2 + 1) for i in range(N) for j in range(i))",
            "sum(x[i] for i in range(N))**8", "cos(sum(i*x[i] for i in range(N)))",
        )
    )  # fmt: skip
    kinetic = source.choice(
        (
            "sum(x_dot[i]**2/2 for i in range(N))", "sum((1 + x[i]**2)*x_dot[i]**2 for i in range(N))",
            "sum(x_dot[i]**2 for i in range(N)) + sum(x_dot[i]*x[i] for i in range(N))**2",
            "sum(x_dot[i]*x_dot[j]*cos(x[i] - x[j]) for i in range(N) for j in range(N))/4"
            " + sum(x_dot[i]**2 for i in range(N))",
        )
    )  # fmt: skip
    head = f"sizes: {{N: {size}}}\ncoordinates:\n  x[i in range(N)]: {{initial: 0.1*i}}\n"
    return f"{head}lagrangian: '{kinetic} - ({coupling})'\n{STOP}"


def arm(source: Random) -> str:
    """A chain whose positions are sums over all joints before."""
    size = source.choice((2, 4, 8, 20, 60))
    angle = source.choice(("q[j]", "sum(q[m] for m in range(j + 1))", "q[j] + t", "q[j]*q[0]"))
    return (
        f"sizes: {{N: {size}}}\ncoordinates:\n  q[i in range(N)]: {{initial: 0.1 + 0.2*i}}\n"
        "masses:\n  b[i in range(N)]: 1\nembedding:\n  b[i in range(N)]:\n"
        f"    - sum(sin({angle}) for j in range(i + 1))\n    - sum(cos({angle}) for j in range(i + 1))\n"
        f"potential: sum(b[i].y for i in range(N))\n{STOP}"
    )


def forces(source: Random) -> str:
    """Forces, friction, observables and time in everything."""
    text = source.choice(("sin(x*y + t)", "(x + y*t)**6", "exp(-(x - y)**2)", "1/(1 + x**2*y**2)"))
    rate = source.choice(("(x_dot + y_dot*x)**4", "x_dot**2*exp(x_dot*y)", "(x_dot**2 + y_dot**2)**1.5"))
    more = {"generalized_forces": f"{{x: '-x_dot*{text}'}}", "observables": f"{{o: '({text})**5*x_dot'}}"}
    return particle(source, text, x="x*cos(t)", dissipation=f"'{rate}'", **more)


def switching(source: Random) -> str:
    """Sums and products of many functions with kinks, different ones or one many times over."""
    one = source.choice(
        (
            "abs(x - {0})", "abs(x*y - {0}/7)", "max(x, y - {0}, {0}*x*y)", "min(0, x**2 - {0})**2",
            "abs(x + {0}*y)**1.5", "max(0, sin({0}*x + y), cos(x))", "where(x > {0}, (x - {0})**2, 0)",
            "x*sign(x - {0})*(x - {0})", "abs(abs(x) - {0})", "sqrt((x - {0})**2*y**4)",
        )
    )  # fmt: skip
    if source.random() < 0.2:
        one = one.format(1)
    count = source.choice((3, 20, 60, 150, 400))
    while count * len(one.format(count)) > 9000:
        count -= 1
    text = source.choice("+++*").join(one.format(i) for i in range(count))
    return particle(source, text, x=source.choice(("x", "x", "x + abs(y)*y")))


def branches(source: Random) -> str:
    """Cases within cases, conditions of many parts, and functions with kinks of each other."""
    depth = source.choice((3, 10, 30, 90))
    kind = source.randrange(5)
    if kind == 0:  # as many pieces
        text = "".join(f"where(x < {i}, (x - {i})**2*y, " for i in range(depth)) + "x" + ")" * depth
    elif kind == 1:
        word = source.choice((" and ", " or ", " and not ", " or not "))
        condition = word.join(f"(x > {i} - y)" for i in range(depth))
        text = f"where({condition}, x**2, y**2)"
    elif kind == 2:
        text = "not (" * depth + "x > 0 or y > x" + ")" * depth
        text = f"where({text}, x, 2*x)"
    elif kind == 3:
        call = source.choice(("abs({1} + {0}", "max({1}*x, {0}", "min({1}, y - {0}", "abs({1}*y - {0}*t"))
        text = "".join(call.split("{0}")[0].format("", i) for i in range(depth)) + "x"
        text += (call.split("{0}")[1] + ")") * depth
    else:
        text = "x > y"
        for i in range(min(depth, 7)):
            text = f"({text}) {source.choice(('and', 'or'))} (not ({text}) or y > {i})"
        text = f"where({text}, x, 2*x)"
    if source.random() < 0.3:
        return particle(source, "x**2", generalized_forces=f"{{x: '{text}'}}")
    return particle(source, text)


def walls(source: Random) -> str:
    """Families whose members meet all others, or that rub, with kinks."""
    size = source.choice((3, 10, 20, 40, 100))
    one = source.choice(
        (
            "sum(max(0, 1 - abs(x[i] - x[j]))**2 for i in range(N) for j in range(i))",
            "sum(abs(x[i] - i) for i in range(N))", "sum(abs(x[i] - x[(i + 1) % N])**3 for i in range(N))",
            "max(x[0]**2, sum(abs(x[i]) for i in range(N)))", "abs(sum(abs(x[i]) for i in range(N)) - 1)",
            "sum(exp(-(x[i] - x[j])**2/0.01) for i in range(N) for j in range(i))",
        )
    )  # fmt: skip
    rubbing = source.choice(("", "dissipation: 'sum(abs(x_dot[i]) for i in range(N))'\n"))
    head = f"sizes: {{N: {size}}}\ncoordinates:\n  x[i in range(N)]: {{initial: 0.1*i + 0.01}}\n"
    return f"{head}lagrangian: 'sum(x_dot[i]**2/2 for i in range(N)) - ({one})'\n{rubbing}{STOP}"


KINDS: dict[str, Callable[[Random], str]] = {
    "nest": nest, "doubling": doubling, "product": product, "power": power, "family": family, "arm": arm,
    "forces": forces, "switching": switching, "branches": branches, "walls": walls,
}  # fmt: skip
