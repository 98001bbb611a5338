"""Common notation from elsewhere, and its form here: the one table for all hints."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

CHARACTERS: dict[str, tuple[str, str, str]] = {
    # written text: its meaning, the mistake, the right form
    "^": ("**", "unknown operator '^'", "write ** for powers"),
    "×": ("*", "unknown operator '×'", "write *, or cross(a, b) for vectors"),
    "·": ("*", "unknown operator '·'", "write *, or dot(a, b) for vectors"),
    "⋅": ("*", "unknown operator '⋅'", "write *, or dot(a, b) for vectors"),
    "∙": ("*", "unknown operator '∙'", "write *, or dot(a, b) for vectors"),
    "÷": ("/", "unknown operator '÷'", "write /"),
    "∕": ("/", "'∕' is not the '/' of a keyboard", "write /"),
    "−": ("-", "'−' is not the minus sign of a keyboard", "write -"),
    "–": ("-", "'–' is not the minus sign of a keyboard", "write -"),
    "—": ("-", "'—' is not the minus sign of a keyboard", "write -"),
    "√": ("sqrt", "unknown function '√'", "write sqrt(...)"),
    "{": ("(", "'{' instead of '('", "write ("),
    "}": (")", "'}' instead of ')'", "write )"),
    "≤": ("<=", "unknown operator '≤'", "write <="),
    "≥": (">=", "unknown operator '≥'", "write >="),
    "≠": ("!=", "unknown operator '≠'", "write !="),
    ";": (",", "';' instead of ','", "write a comma; at the end of an expression, leave it out"),
}
"""Characters with only one possible meaning: they are reported, and read with this meaning."""

SUBSCRIPTS = "₀₁₂₃₄₅₆₇₈₉"


SPOKEN_POWERS = {"squared": "2", "cubed": "3"}
"""Words for powers, as in ``r squared``."""

_LATEX = (
    "expressions are not LaTeX",
    r"write theta for \theta, theta_dot for \dot{\theta}, and a/b for \frac{a}{b}",
)

STRANGERS: dict[str, tuple[str, str]] = {
    "'": ("quotation marks are not allowed", "leave them out"),
    '"': ("quotation marks are not allowed", "leave them out"),
    **dict.fromkeys("“”„‘‚«»", ("quotation marks are not allowed", "leave them out")),
    "′": ("misplaced prime", "write NAME_dot for a velocity"),
    ":": ("':' is not allowed", "write only the expression itself"),
    "!": ("unknown operator '!'", "the operators are + - * / **; in conditions, write not"),
    "|": (
        "'|' is not allowed",
        "write abs(x), or norm(a) for the length of a vector; in conditions, write or",
    ),
    "&": ("unknown operator '&'", "the operators are + - * / **; in conditions, write and"),
    "@": ("unknown operator '@'", "write dot(a, b) for a scalar product"),
    "°": ("misplaced '°'", "angles are in radians: write *pi/180"),
    "∂": ("derivatives are not allowed", "velocities are written as x_dot"),
    "∑": ("'∑' is not allowed", "write sum(m[i] for i in range(N))"),
    "∞": ("'∞' is not a finite number", "write a number"),
    "½": ("the character '½' is not allowed", "write 1/2"),
    "¼": ("the character '¼' is not allowed", "write 1/4"),
    "\\": _LATEX,
    "$": _LATEX,
    "\u0307": ("a dot above a letter does not mean a derivative", "velocities are written as x_dot"),
    "\u0308": ("dots above a letter do not mean a derivative", "velocities are written as x_dot"),
}
"""Characters without a meaning."""

PRIMES = frozenset("'′’´ʹ`\"″")
DOTS = {"\u0307": 1, "˙": 1, "\u0308": 2, "¨": 2}
"""Marks after a name for a derivative, and the order of those that are dots."""

QUOTES = frozenset("'\":\\")
"""Where these stand, the rest of a text may be anything."""

DEGREES = frozenset({"deg", "degree", "degrees", "°"})
RADIANS = frozenset({"rad", "radian", "radians"})

FUNCTIONS: dict[str, str] = {
    "ln": "log(x)", "loge": "log(x)", "log10": "log(x)/log(10)", "lg": "log(x)/log(10)",
    "log2": "log(x)/log(2)",
    "arcsin": "asin(x)", "arccos": "acos(x)", "arctan": "atan(x)", "arctan2": "atan2(y, x)",
    "arctg": "atan(x)", "tg": "tan(x)", "sh": "sinh(x)", "ch": "cosh(x)", "th": "tanh(x)",
    "arcsinh": "log(x + sqrt(x**2 + 1))", "asinh": "log(x + sqrt(x**2 + 1))",
    "arsinh": "log(x + sqrt(x**2 + 1))", "arccosh": "log(x + sqrt(x**2 - 1))",
    "acosh": "log(x + sqrt(x**2 - 1))", "arcosh": "log(x + sqrt(x**2 - 1))",
    "arctanh": "log((1 + x)/(1 - x))/2", "atanh": "log((1 + x)/(1 - x))/2",
    "artanh": "log((1 + x)/(1 - x))/2",
    "cot": "1/tan(x)", "ctg": "1/tan(x)", "cotan": "1/tan(x)", "sec": "1/cos(x)", "csc": "1/sin(x)",
    "cosec": "1/sin(x)", "coth": "1/tanh(x)", "sech": "1/cosh(x)", "csch": "1/sinh(x)",
    "pow": "x**y", "power": "x**y", "square": "x**2", "sq": "x**2", "sqr": "x**2", "cbrt": "x**(1/3)",
    "root": "sqrt(x)", "squareroot": "sqrt(x)", "hypot": "sqrt(x**2 + y**2)", "expm1": "exp(x) - 1",
    "log1p": "log(1 + x)", "sinc": "sin(x)/x", "radians": "x*pi/180", "deg2rad": "x*pi/180",
    "deg": "x*pi/180 for x degrees", "rad": "x: angles are in radians, and x*pi/180 is x degrees",
    "degrees": "x*180/pi", "rad2deg": "x*180/pi",
    "mag": "norm(a)", "magnitude": "norm(a)", "length": "norm(a)", "vec": "(x, y, z)",
    "len": "norm(a) for the length of a vector; the number of members is a number or one of the sizes",
    "vector": "(x, y, z)", "inner": "dot(a, b)", "scalar": "dot(a, b)", "dist": "norm(a - b)",
    "distance": "norm(a - b)", "mod": "x % n, which is for whole numbers",
    "fmod": "x % n, which is for whole numbers",
    "sgn": "sign(x)", "signum": "sign(x)", "fabs": "abs(x)", "absolute": "abs(x)",
    "maximum": "max(x, y)", "minimum": "min(x, y)", "fmax": "max(x, y)", "fmin": "min(x, y)",
    "heaviside": "where(x > 0, 1, 0)", "step": "where(x > 0, 1, 0)", "unitstep": "where(x > 0, 1, 0)",
    "piecewise": "where(x > 0, a, b)", "cases": "where(x > 0, a, b)", "select": "where(x > 0, a, b)",
    "if": "where(x > 0, a, b)", "ifelse": "where(x > 0, a, b)", "ite": "where(x > 0, a, b)",
    "iif": "where(x > 0, a, b)", "cond": "where(x > 0, a, b)", "relu": "max(x, 0)", "ramp": "max(x, 0)",
    "clip": "min(max(x, a), b)", "clamp": "min(max(x, a), b)",
    "rect": "where(-1/2 < x < 1/2, 1, 0)", "box": "where(-1/2 < x < 1/2, 1, 0)",
    "diff": "x_dot for the velocity of x; expressions have no other derivatives",
    "ddt": "x_dot for the velocity of x; expressions have no other derivatives",
    "derivative": "x_dot for the velocity of x; expressions have no other derivatives",
}  # fmt: skip
"""Functions that have another name here, or that can be written with others: what stands after 'write'."""

_STEPS = "write where() with a condition for each step"
_INTEGRAL = "write the integral itself, as in k*x**2/2 for that of k*x"
NOT_SUPPORTED: dict[str, str] = {
    "integrate": _INTEGRAL, "integral": _INTEGRAL, "int": _INTEGRAL,
    "floor": _STEPS, "ceil": _STEPS, "ceiling": _STEPS, "round": _STEPS, "trunc": _STEPS,
    "dirac": "write a short pulse, as in exp(-(t/eps)**2)",
    "diracdelta": "write a short pulse, as in exp(-(t/eps)**2)",
}  # fmt: skip
"""Functions that have no counterpart here, in small letters, and what to do without them."""

WHOLE_PARTS = frozenset({"int", "floor", "ceil", "ceiling", "round", "trunc"})
WHOLE_PART = "write //, as in i//2 for the whole part of i/2"
"""What to do without these where numbers are whole."""

NAMES: dict[str, str] = {
    "π": "pi", "Pi": "pi", "PI": "pi", "time": "t", "Time": "t", "τ": "2*pi, or add it to the parameters",
    **dict.fromkeys(("deg", "degree", "degrees"), "pi/180: angles are in radians"),
    **dict.fromkeys(("rad", "radian", "radians"), "1: angles are in radians"),
    "e": "exp(x) for a power of Euler's number, or add it to the parameters",
    "E": "exp(x) for a power of Euler's number, or add it to the parameters",
}  # fmt: skip
"""Names of constants: what stands after 'write'."""

SWITCHES = frozenset({"yes", "no", "on", "off", "true", "false"})
"""Words for yes and no in other files, in small letters."""

QUANTITIES: dict[str, tuple[str, str]] = {
    spelling: (output, what)
    for output, what, spellings in (
        ("T", "kinetic energy", "T K KE Ekin E_kin kinetic kinetic_energy"),
        ("U", "potential energy", "U V PE Epot E_pot potential potential_energy"),
        ("energy", "energy T + U", "E Etot E_tot energy total_energy"),
        ("h", "energy function", "h H hamiltonian Hamiltonian"),
    )
    for spelling in spellings.split()
}
"""Names of energies: the output that has the values, and what it is called."""

_PARAMETER_EXAMPLES = {
    "g": "9.81", "G": "6.674e-11", "hbar": "1.0546e-34", "k_B": "1.38e-23",
    "eps0": "8.854e-12", "mu0": "1.2566e-6",
}  # fmt: skip

_VELOCITIES = """
    {}dot {}_d {}d d{} d_{} d{}dt d{}_dt {}dt {}_dt v{} v_{} {}_v {}v vel_{} {}_vel {}vel velocity_{}
    {}_velocity {}prime {}_prime {}p {}_t D{} omega_{} w_{} speed_{} {}_speed dot_{} dot{} {}Dot {}_Dot {}_DOT
"""
_ACCELERATIONS = """
    {}_ddot {}ddot {}dotdot {}_dot_dot {}dd {}_dd dd{} ddot_{} d2{} d2{}dt2 d2{}_dt2 a{} a_{} {}_tt acc_{}
    {}_acc {}pp {}_dotdot {}_double_dot
"""
"""Names of velocities and accelerations elsewhere."""


def rate_of(name: str, coordinates: Iterable[str]) -> tuple[str, int]:
    """The coordinate whose time derivative ``name`` may have meant, and the derivative's order;
    an empty name where none fits."""
    bare, dots = without_dots(name)
    for one in coordinates:
        if dots and bare == one:
            return one, dots
        for order, spellings in ((1, _VELOCITIES), (2, _ACCELERATIONS)) if one in name else ():
            if any(spelling.format(one) == name for spelling in spellings.split()):
                return one, order
    return "", 0


def without_dots(name: str) -> tuple[str, int]:
    """A name without dots above its letters, and how many dots there were: ``x`` and 1 for ``ẋ``."""
    if name.isascii():
        return name, 0
    apart = unicodedata.normalize("NFD", name)
    dots = apart.count("\u0307") + 2 * apart.count("\u0308")
    return unicodedata.normalize("NFKC", apart.replace("\u0307", "").replace("\u0308", "")), dots


def romanized(name: str) -> str:
    """A name with the names of its Greek letters: ``theta_1`` for ``θ_1``."""
    return name if name.isascii() else "".join(map(_letter, name)).replace("lamda", "lambda")


def _letter(character: str) -> str:
    kind, _, letter = unicodedata.name(character, "").partition(" LETTER ")
    small, large = kind == "GREEK SMALL", kind == "GREEK CAPITAL"
    return letter.lower() if small else letter.capitalize() if large else character


def parameter_example(name: str) -> str:
    """How a parameter of that name may be declared."""
    return f"{name}: {_PARAMETER_EXAMPLES.get(name, '1.0')}"


COMPONENTS: dict[str, str] = {
    spelling.format(axis): f"v{axis}"
    for axis in "xyz"
    for spelling in ("{}dot", "{}_dot", "d{}", "v_{}", "{}d", "{}_d", "{}v", "vel_{}", "V{}")
}
"""Components of a particle's velocity."""
VELOCITIES = frozenset({"v", "V", "vel", "velocity", "speed", "dot", "rdot", "r_dot"})
"""Words for all components of a velocity."""
_SPIN = re.compile("(?:w|\u03c9|omega|\u03a9|Omega|om|ang_?vel|angular_velocity)_?([xyz123]?)")


def spin_component(word: str) -> str | None:
    """``wx`` for ``omega_x``, and ``w3`` for ``omega3``: a component of an angular velocity, as it may be
    written elsewhere. Empty for all of them together; None for other words."""
    found = _SPIN.fullmatch(word)
    return None if found is None else found[1] and f"w{found[1]}"


MULTIPLIERS = frozenset({"lambda", "lam", "multiplier", "multipliers"})
FORCES = MULTIPLIERS | {"mu", "tension", "reaction", "force", "F", "N", "T"}
"""Names of a multiplier elsewhere, alone and with the name of its constraint: ``lambda_rod``."""


STATE = "it belongs to each coordinate: 'theta: {initial: 0.1, velocity: 0}' under 'coordinates'"
KINETIC = "T follows from 'masses' and 'positions'; or write 'lagrangian: T - U' instead of both"
_HINTS = {
    "state": STATE,
    "friction": "write 'dissipation: c*theta_dot**2/2', or a force under 'generalized_forces' or 'forces'",
    "kinetic": KINETIC,
    "particles": "write 'masses: {bob: m}' and 'positions: {bob: [x, y]}'",
    "interaction": "write it as an energy under 'potential'",
    "stop": "write 'solve: {stop: 10}'",
    "step": "write 'solve: {step: 0.01}'",
    "solve": "it belongs under 'solve', as in 'solve: {stop: 10, step: 0.01}'",
    "outputs": "what is written is listed under 'solve', as in 'solve: {outputs: [q, v]}'",
    "draw": "it belongs under 'draw'",
    "body": "it belongs to a body: 'top: {mass: m, inertia: [I1, I2, I3], ...}' under 'bodies'",
    "event": "it belongs to an event: 'floor: {when: y, direction: falling}' under 'events'",
    "unit": "write 'time: {unit: s}' for the unit of t; others belong to parameters and coordinates",
    "sweep": "a sweep is a command: 'lagrange sweep FILE --over NAME=START:STOP:COUNT'",
}
_ELSEWHERE = """
    state: initial initials initial_conditions initial_condition initial_state initial_values init ics ic
    state: start velocity velocities speed q0 v0 x0 y0 state
    friction: friction damping drag viscosity resistance losses
    kinetic: T K kinetic kinetic_energy Ekin E_kin energy energies
    particles: particles particle point objects point_masses
    interaction: springs spring gravity interactions field
    stop: t_end tmax t_max tstop duration t time_span tspan t_span end
    step: dt timestep time_step
    solve: stop step samples method tolerance
    outputs: outputs output plot write multipliers reactions momenta
    draw: rods trails hide curves colours colors camera sliders colour color
    body: inertia orientation solid moments_of_inertia quaternion euler
    event: when action direction terminal
    unit: unit units time_unit
    sweep: sweep sweeps over ensemble scan
"""
"""Sections of other programs that do not exist here, after the hint that applies to them."""


def elsewhere(section: str) -> str:
    """The hint for a section that other programs have; nothing for any other word."""
    for line in _ELSEWHERE.splitlines():
        hint, _, words = line.strip().partition(":")
        if section in words.split():
            return _HINTS[hint]
    return ""
