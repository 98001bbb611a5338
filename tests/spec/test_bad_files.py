"""Each mistake is shown at its place, with the piece underlined and a way out."""

from __future__ import annotations

from itertools import pairwise

import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.spec.problems import MOST
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.files import PENDULUM, changed, problems, underlined

POTENTIAL = "m*g*bob.y"
EMBEDDING = "[l*sin(theta), -l*cos(theta)]"

# what to replace, by what, then (line, underlined piece, part of the message, part of the hint) each
BAD = [
    # keys
    ("potential", "potental", [(12, "potental", "unknown key 'potental'", "did you mean 'potential'?")]),
    ("name", "logo", [(1, "logo", "unknown key 'logo'", "known: name, description, parameters")]),
    ("name", "title", [(1, "title", "unknown key 'title'", "write 'name'")]),
    ("unit: m", "units: m", [(4, "units", "unknown key 'units' in parameter 'l'", "'unit'")]),
    ("initial", "start", [(7, "start", "unknown key 'start' in coordinate 'theta'", "write 'initial'")]),
    ("  g: 9.81", "  g: 9.81\n  m: 2", [(6, "m", "the key 'm' is given twice", "line 3")]),
    ("initial: 0.1", "initial = 0.1", [(7, "initial = 0.1", "unknown key", "write initial: 0.1")]),
    ("0.1", "0.1, thetadot: 1", [(7, "thetadot", "unknown key 'thetadot'", "write 'velocity'")]),
    ("embedding", "position", [(10, "position", "unknown key 'position'", "write 'positions'")]),
    # texts that YAML reads in another way
    ("name: pendulum", "description: lat: x", [(1, ":", "YAML syntax error", "': ' in quotes")]),
    (EMBEDDING, EMBEDDING[:-1], [(12, ":", "YAML syntax error", "the '[' of line 11 is still open")]),
    (EMBEDDING, "{x: l, y: 0}", [(11, "{", "must be an expression, not a mapping", "a list: [x, y, z]")]),
    ("  bob: m", "  [m]", [(9, "[", "masses must be a mapping with a name for each mass", "write 'masses:")]),
    # names
    (POTENTIAL, "m*g*y_bob", [(12, "y_bob", "unknown name 'y_bob'", "write bob.y")]),
    (POTENTIAL, "g*bobvx", [(12, "bobvx", "unknown name 'bobvx'", "write bob.vx")]),
    (POTENTIAL, "m*g*cos(\u03b8)", [(12, "\u03b8", "unknown name", "did you mean 'theta'?")]),
    (POTENTIAL, "mu*bob.y", [(12, "mu", "'mu'", "did you mean 'm'? Or add it to the parameters: 'mu: 1.0'")]),
    (POTENTIAL, "\u00bd*m", [(12, "\u00bd", "is not allowed", "write 1/2")]),
    (POTENTIAL, "g*bob", [(12, "g*bob", "expected a scalar", "'bob' is a vector: take a component")]),
    ("initial: 0.1", "initial: 1 mm", [(7, "1 mm", "number with a unit", "'unit: mm'")]),
    ("0.1", "0.1, velocity: 2 mm/s", [(7, "2 mm/s", "number with a unit", "'unit: mm'")]),
    (POTENTIAL, "m*g*cos(thta)", [(12, "thta", "unknown name 'thta' in potential", "did you mean 'theta'?")]),
    (POTENTIAL, "m*g*bod.y", [(12, "bod.y", "unknown name 'bod'", "'bob'")]),
    (POTENTIAL, "m*g*bob.z", [(12, "bob.z", "no component 'z'", "bob.x, bob.y, bob.vx, bob.vy")]),
    (POTENTIAL, "theta.x", [(12, "theta.x", "'theta' has no component", "write theta")]),
    (POTENTIAL, "bob.x.y", [(12, "bob.x.y", "has no components", "write bob.x")]),
    (POTENTIAL, "bob.v.x", [(12, "bob.v.x", "'bob.v' has no components", "write bob.vx")]),
    (POTENTIAL, "sin*2", [(12, "sin", "missing parentheses after 'sin'", "sin(...)")]),
    (POTENTIAL, "theta_ddot", [(12, "theta_ddot", "acceleration", "determine it")]),
    (POTENTIAL, "a/qq + qq\nobservables: {e: qq}", [(12, "a", "'a'", ""), (12, "qq", "'qq'", "")]),
    ("  theta: {initial: 0.1}", "", [(6, "coordinates", "has no coordinates", "write 'coordinates: {x:")]),
    ("  theta: {initial: 0.1}", "  7", [(7, "7", "must be a mapping or a list", "or a list of names")]),
    ("  m: 1\n  l: {value: 0.5, unit: m}\n  g: 9.81", "  [m, l, g]", [
        (3, "[", "must be a mapping with names", "write 'parameters: {m: 1.0}'"),
    ]),
    (POTENTIAL, "a + bb", [(12, "a", "'a'", ""), (12, "bb", "'bb'", "")]),
    ("  bob: m", "  bob: theta", [(9, "theta", "the coordinate 'theta' cannot be used", "parameters")]),
    ("initial: 0.1", "initial: t", [(7, "t", "the time 't' cannot be used in initial of", "parameters")]),
    ("  m: 1", "  m: theta", [(3, "theta", "the coordinate 'theta' cannot", "other parameters")]),
    (EMBEDDING, "[theta_dot, 1]", [(11, "theta_dot", "the velocity 'theta_dot' cannot", "r(q, t)")]),
    (EMBEDDING, "[bob.x, 1]", [(11, "bob", "position of 'bob' depends on itself: bob -> bob", "")]),
    (EMBEDDING, "[bob.vx, 1]", [(11, "bob", "position of 'bob' depends on itself", "in coordinates")]),
    ("potential:", "definitions: {w: theta_dot, w2: w**2}\npotential: w2*", []),
    (EMBEDDING, "[w2, 1]\ndefinitions: {w: theta_dot, w2: w**2}", [(11, "w2", "depends on a velocity", "")]),
    (EMBEDDING, "[h, 1]\ndefinitions: {h: bob.y}", [(12, "h", "itself: h -> bob -> h", "one of them")]),
    (EMBEDDING, "[h, 1]\ndefinitions: {h: u + 1, u: bob.vy}", [(12, "h", "h -> u -> bob -> h", "")]),
    ("name: pendulum", "definitions: {r: (bob.vx, 1), u: r.vx}", [(1, "r.vx", "'vx'", "'r' contains")]),
    ("  bob: m", "  bob: h\ndefinitions: {h: bob.y}", [(9, "h", "which depends on a particle", "")]),
    ("name: pendulum", "definitions: {h: bob.w1 + bob.z}", [
        (1, "bob.w1", "not a rigid body", ""), (1, "bob.z", "no component 'z'", "bob.vx")
    ]),
    # declarations
    ("  g:", "  t:", [(5, "t", "the name 't' is reserved", "t_"), (12, "g", "unknown name 'g'", "")]),
    ("  g:", "  in:", [(5, "in", "cannot be called 'in'", ""), (12, "g", "unknown", "")]),
    ("  m: 1", "  m: 1\n  2x: 1", [(4, "2x", "cannot be called '2x'", "begins with a letter")]),
    ("  m: 1", "  m: 1\n  a b: 1", [(4, "a b", "cannot be called 'a b'", "letters, digits")]),
    ("  m: 1", "  m: 1\n  theta: 1", [(4, "theta", "has the name of a coordinate", "line 8")]),
    ("  m: 1", "  m: 1\n  theta_dot: 1", [(4, "theta_dot", "has the name of a velocity", "line 8")]),
    ("  m: 1", "  m: 1\n  theta_ddot: 1", [(4, "theta_ddot", "name of an acceleration", "rename")]),
    ("  m: 1", "  m: 1\n  bob: 1", [(10, "bob", "the particle 'bob' has the name of a parameter", "4")]),
    ("  bob: m", "  bbo: m", [(9, "bbo", "a mass but no position", "'bob'"), (11, "bob", "no mass", "")]),
    ("masses:\n  bob: m\n", "", [(9, "bob", "a position but no mass", "masses: {bob: 1.0}")]),
    ("name: pendulum", "lagrangian: 1", [
        (1, "lagrangian", "together with 'masses' and 'embedding' and 'potential'", "leave one or the other"),
    ]),
    ("  theta: {initial: 0.1}", "  - theta\n  - theta", [(8, "theta", "is given twice", "")]),
    ("  theta: {initial: 0.1}", "  theta: 0.1", [(7, "0.1", "must be a mapping", "{initial: 0.1}")]),
    ("  theta: {initial: 0.1}", "  theta: pi/3", [(7, "pi/3", "must be a mapping", "{initial: pi/3}")]),
    ("  theta: {initial: 0.1}", "  theta: 3 deg", [(7, "3 deg", "must be a mapping", "{initial: 0.1}")]),
    ("  m: 1", "  m: l + 1", []),
    ("  m: 1", "  m: 2*z", [(3, "z", "unknown name 'z'", "known: m, l, g; or add")]),
    ("  m: 1", "  m: (1, 2)", [(3, "(1, 2)", "expected a scalar", "under 'definitions'")]),
    ("  m: 1", "  m: a\n  a: b\n  b: a", [(4, "a", "parameter 'a' depends on itself: a -> b -> a", "")]),
    ("  m: 1", "  m: m", [(3, "m", "depends on itself: m -> m", "")]),
    ("name: pendulum", "definitions: {a: b, b: a}", [(1, "a", "'a' depends on itself: a -> b", "")]),
    # shapes
    (POTENTIAL, "bob", [(12, "bob", "expected a scalar in potential", "norm()")]),
    (POTENTIAL, "2*(bob + 1).x", [(12, ".", "misplaced '.'", "bead.x")]),
    (POTENTIAL, "norm(bob + 1)", [(12, "bob + 1", "a vector and a scalar", "")]),
    (POTENTIAL, "norm(bob + (1, 2, 3))", [(12, "bob + (1, 2, 3)", "vectors of 2 and 3 components", "")]),
    (POTENTIAL, "bob*bob", [(12, "bob*bob", "two vectors cannot be multiplied", "dot(a, b)")]),
    (POTENTIAL, "bob**2", [(12, "bob**2", "a vector cannot stand in a power", "dot(a, a)")]),
    (POTENTIAL, "1/bob", [(12, "bob", "division by a vector", "norm()")]),
    (POTENTIAL, "sin(bob)", [(12, "bob", "'sin' needs a scalar", "")]),
    (POTENTIAL, "norm(theta)", [(12, "theta", "'norm' needs a vector", "(x, y, z)")]),
    (POTENTIAL, "norm(cross(bob, bob))", [(12, "cross(bob, bob)", "three components", "")]),
    (POTENTIAL, "[m, g]", [(12, "[", "potential must be a scalar, not a vector", "")]),
    (EMBEDDING, "[1, 2, 3, 4]", [(11, "[", "one to three components, not 4", "[x, y, z]")]),
    (EMBEDDING, "[]", [(11, "[", "not 0", "")]),
    (EMBEDDING, "[[1, 2], 3]", [(11, "[", "a component of position of 'bob'", "")]),
    (EMBEDDING, '["(1, 2)", 3]', [(11, "(1, 2)", "a component of a vector cannot be a vector", "")]),
    ("potential", "forces: {bob: [1]}\npotential", [(12, "1", "1 component, its position 2", "write 2 c")]),
    ("potential", "forces: {bop: [1, 2]}\npotential", [(12, "bop", "unknown particle 'bop'", "'bob'")]),
    ("potential", "forces: {theta: 1}\npotential", [(12, "theta", "unknown", "'generalized_forces'")]),
    ("potential", "generalized_forces: {bob: 1}\npotential", [(12, "bob", "unknown coordinate", "'forces'")]),
    (POTENTIAL, "bob*g*bob.y", [(12, "bob*g*bob.y", "expected a scalar", "'masses: {bob: M}'")]),
    ("potential", "generalized_forces: {x: 1}\npotential", [(12, "x", "unknown coordinate 'x'", "theta")]),
    ("potential", "observables: {theta: 1}\npotential", [(12, "theta", "name of a coordinate", "line 7")]),
    ("potential", "observables: {at: bob}\npotential", [(12, "bob", "expected a scalar", "")]),
    # expressions
    (POTENTIAL, "m*g*theta^2", [(12, "^", "'^'", "write ** for powers")]),
    (POTENTIAL, "2theta", [(12, "2theta", "missing operator", "2*theta")]),
    (POTENTIAL, "2theta + m g theta", [
        (12, "2theta", "missing operator", "2*theta"),
        (12, "m g", "missing operator", "write m*g*theta"),
    ]),
    (POTENTIAL, "sin theta", [(12, "sin theta", "missing parentheses after 'sin'", "sin(theta)")]),
    (POTENTIAL, "m*theta'", [(12, "theta'", "a prime", "theta_dot")]),
    (POTENTIAL, "sin(theta, 1)", [(12, "sin(theta, 1)", "wrong number of arguments for 'sin'", "sin(x)")]),
    (POTENTIAL, "sine(theta)", [(12, "sine", "unknown function 'sine'", "'sin'")]),
    (POTENTIAL, "where(theta == 1, 1, 2)", [(12, "theta == 1", "'theta' changes with time", "abs(x - a)")]),
    (POTENTIAL, "where(bob.x > 1 and 2 != t, 1, 2)", [(12, "2 != t", "'t' changes with time", "<=")]),
    (POTENTIAL, "where(bob > 1, 1, 2)", [(12, "bob", "vectors cannot be compared", "norm()")]),
    (POTENTIAL, "floor(theta)", [(12, "floor", "'floor' is not supported", "where()")]),
    (POTENTIAL, "theta[1]", [(12, "theta[1]", "'theta' is not a family", "write theta")]),
    (POTENTIAL, "m // 2", [(12, "m", "'m' is neither an index nor a size", "whole numbers")]),
    (POTENTIAL, "1/0", [(12, "1/0", "division by zero", "")]),
    (POTENTIAL, "sqrt(-1)", [(12, "sqrt(-1)", "sqrt(-1) is not a real number", "")]),
    (POTENTIAL, "9**9**9**9", [(12, "9**9", "the exponent 3.8742e8 is out of bounds", "")]),
    (POTENTIAL, "__import__('os').system('x')", [(12, "'", "quotation marks", "")]),
    (POTENTIAL, "(" * 4000 + ")" * 4000, [(12, "(", "nested more than 100 deep", "definitions")]),
    (POTENTIAL, "(" * 10000 + ")" * 10000, [(12, "(", "20000 characters is too long", "definitions")]),
    # numbers
    ("m: 1", "m: .nan", [(3, ".nan", "'.nan' is not a finite number", "write a number")]),
    ("m: 1", "m: -.inf", [(3, "-.inf", "not a finite number", "")]),
    ("m: 1", "m: nan", [(3, "nan", "'nan' is not a finite number", "")]),
    ("m: 1", "m: 1e999", [(3, "1e999", "too large", "")]),
    ("m: 1", "m: 1e-400", [(3, "1e-400", "too small", "4.9e-324")]),
    ("m: 1", "m:", [(3, "", "missing value in parameter 'm'", "")]),
    ("m: 1", "m: [1, 2]", [(9, "m", "missing index on", "m[i]"), (12, "m", "missing index on", "m[i]")]),
    ("m: 1", "m: {unit: kg}", [(3, "m", "parameter 'm' has no value", "value: 1.0")]),
    # solve
    ("name: pendulum", "solve: {start: 2, stop: 2}", [(1, "2", "the motion stops where it starts", "")]),
    ("name: pendulum", "solve: {samples: 0}", [(1, "0", "samples must be at least 2, not 0", "")]),
    ("name: pendulum", "solve: {samples: 2.5}", [(1, "2.5", "whole number", "")]),
    ("name: pendulum", "solve: {step: 0}", [(1, "0", "step must be greater than 0", "")]),
    ("name: pendulum", "solve: {tolerance: -1}", [(1, "-1", "tolerance must be greater than 0", "")]),
    ("name: pendulum", "solve: {stop: m*theta}", [(1, "theta", "coordinate 'theta' cannot", "times may")]),
    ("name: pendulum", "solve: {stop: 2*mm, step: t}", [
        (1, "mm", "unknown name 'mm' in stop of solve", "'m'"),
        (1, "t", "'t' cannot be used in step of solve", "times may"),
    ]),
    ("name: pendulum", "solve: {samples: m}", [(1, "m", "expected a number, found 'm'", "write a number")]),
    ("name: pendulum", "solve: {stop: bob}", [(1, "bob", "'bob' cannot be used", "times may use")]),
    ("name: pendulum", "solve: {start: inf}", [(1, "inf", "'inf' is not a finite number", "write a")]),
    ("name: pendulum", "solve: {stop: 1, samples: 3, step: 1}", [(1, "1", "cannot both", "leave one")]),
    ("name: pendulum", "solve: {stp: 1}", [(1, "stp", "unknown key 'stp' in solve", "'stop'")]),
    ("name: pendulum", "solve: {method: [a]}", [(1, "[", "method of solve must be text", "")]),
    # the unit of t
    ("name: pendulum", "time: s\nsolve: {unit: d}", [(2, "d", "'d' in solve and 's' in time", "leave one")]),
    ("name: pendulum", "time: {units: d}", [(1, "units", "unknown key 'units' in time", "'unit'")]),
    ("name: pendulum", "time: {unit: {d: 1}}", [(1, "{", "unit of time must be text", "")]),
    ("unit: m", 'unit: "\\0"', [(4, "\\", "contains the character NUL", "leave it out")]),
    ("unit: m", 'unit: "\\e[31m"', [(4, "\\e[31m", "contains the control character U+001B", "leave it out")]),
    ("unit: m", 'unit: "\\x9b"', [(4, "\\", "contains the control character U+009B", "leave it out")]),
    ("unit: m", 'unit: "\\u202E"', [(4, "\\", "contains the control character U+202E", "leave it out")]),
    ("unit: m", "unit: \u2067m", [(4, "\u2067m", "contains the control character U+2067", "leave it out")]),
    ("name: pendulum", "solv: {stop: 0}", [(1, "solv", "unknown", ""), (1, "0", "stops where", "")]),
    ("name: pendulum", "solve: {stoop: 0}", [(1, "stoop", "unknown key", ""), (1, "0", "stops", "")]),
    ("name: pendulum", "time: s\nsolve: {unti: d}", [(2, "unti", "unknown", ""), (2, "d", "'d' in", "")]),
    ("name: pendulum", "solve: {tolerence: 0}", [(1, "tolerence", "unknown", ""), (1, "0", "greater", "")]),
    ("name: pendulum", "solve: {tolerance: 0}", [(1, "0", "must be greater", "tolerance: 1e-12")]),
    # a word that is far from every key is none of them, and an abbreviation is one
    ("name", "camera", [(1, "camera", "unknown key", "under 'draw'")]),
    ("name: pendulum", "inertia: [1, 1, 1]", [(1, "inertia", "unknown key", "to a body")]),
    ("name: pendulum", "sweep: {m: 1}", [(1, "sweep", "unknown key", "'lagrange sweep FILE --over")]),
    ("name: pendulum", "units: {t: d}", [(1, "units", "unknown key", "'time: {unit: s}'")]),
    ("unit: m", "dimension: m", [(4, "dimension", "unknown key", "known: value, unit")]),
    ("unit: m", "desc: m", [(4, "desc", "unknown key", "did you mean 'description'?")]),
    ("name: pendulum", "solve: {t_span: [0, 1]}", [(1, "t_span", "unknown key", "'start: 0' and 'stop")]),
    ("name: pendulum", "draw: {radius: 2}", [(1, "radius", "unknown key", "by their masses")]),
    ("name: pendulum", "draw: {camera: {zoom: 2}}", [(1, "zoom", "unknown key", "write 'bounds:")]),
    # the missing signs of products, between all that they stand between
    (POTENTIAL, "m g bob.y", [(12, "m g", "missing operator", "write m*g*bob.y")]),
    (POTENTIAL, "m g cos(theta)", [(12, "m g", "missing operator", "write m*g*cos(theta)")]),
    (POTENTIAL, "m g theta(t)", [(12, "m g", "", "write m*g*theta"), (12, "theta(t)", "", "no '(t)'")]),
    (POTENTIAL, "bob.y g", [(12, "y g", "missing operator", "write bob.y*g")]),
    # constraints
    (POTENTIAL, "g*rod.tension\nconstraints: {rod: theta}", [
        (12, "rod.tension", "the constraint 'rod' has no component 'tension'", "write rod.multiplier"),
    ]),
    # equations
    ("name: pendulum", "constraints: {c: bob.x^2 = l^2 - l, d: 0 == theta, e: 0 = theta = l}", [
        (1, "bob.x^2 = l^2 - l", "stays 0, not an equation", "write bob.x**2 - (l**2 - l)"),
        (1, "^", "", "write **"), (1, "^", "", "write **"),
        (1, "0 == theta", "constraint 'd' is an expression that stays 0", "write theta"),
        (1, "0 = theta = l", "not an equation", "write one constraint for each"),
    ]),
    ("name: pendulum", "constraints: {c: theta < 1}", [(1, "theta < 1", "not an inequality", "a wall is")]),
    ("name: pendulum", "nonholonomic: {c: l*theta_dot = vv}", [
        (1, "l*theta_dot = vv", "not an equation", "write l*theta_dot - vv"), (1, "vv", "unknown name", ""),
    ]),
    ("name: pendulum", "sizes: {N: 1}\nconstraints: {c: 'where(N == 1, theta, 0)'}", []),
    (POTENTIAL, "g*lambda_rod\nconstraints: {rod: theta}", [(12, "lambda_rod", "", "rod.multiplier")]),
    (POTENTIAL, "gg\nconstraints: {a: l, b: t}\nnonholonomic: {c: theta}", [
        (12, "gg", "unknown name", ""),
        (13, "l", "constraint 'a' contains no coordinate", ""),
        (13, "t", "constraint 'b' contains no coordinate", ""),
        (14, "theta", "'c' contains no velocity", "'constraints'"),
    ]),
    (POTENTIAL, "g\ntorques: {bob: [0, 0, 1]}", [(13, "bob", "unknown body 'bob'", "'bob' is a particle")]),
    # bodies
    (EMBEDDING, EMBEDDING + """
bodies:
  a: {mass: m, solid: {ball: l}, position: [0, 0, 0], orientation: {angles: [theta, 0, 0], order: zzx}}
  b: {mass: m, I: [1, 1, 1], position: [0, 0, 0], quaternion: [1, 0, 0, 0]}
""", [
        (13, "ball", "unknown solid 'ball'", "write {sphere: r}"),
        (13, "angles", "unknown key 'angles' in orientation", "write 'euler'"),
        (13, "order", "unknown key 'order'", "write 'sequence'"),
        (13, "zzx", "not a sequence of axes", "zxz"),
        (14, "b", "has no orientation", ""),
        (14, "I", "unknown key 'I'", "write 'inertia'"),
        (14, "quaternion", "unknown key 'quaternion'", "write 'orientation: {quaternion:"),
    ]),
    # what people write elsewhere
    ("parameters:", "constants:", [(2, "constants", "unknown key 'constants'", "write 'parameters'")]),
    ("coordinates:", "variables:", [(6, "variables", "unknown key", "write 'coordinates'")]),
    ("masses:", "mass:", [(8, "mass", "unknown key 'mass'", "write 'masses'")]),
    ("embedding:", "positions:", []),
    ("potential:", "V:", [(12, "V", "unknown key 'V'", "write 'potential'")]),
    ("potential:", "dissipation: {bob: c}\npotential:", [
        (12, "{", "must be an expression", "bob_dot**2/2; for a particle, c*(bob.vx**2 + bob.vy**2)/2"),
    ]),
    ("potential:", "friction: 1\npotential:", [(12, "friction", "unknown key", "write 'dissipation:")]),
    ("potential:", "T: 1\npotential:", [(12, "T", "unknown key", "follows from 'masses' and 'positions'")]),
    ("potential:", "stop: 1\npotential:", [(12, "stop", "unknown key", "it belongs under 'solve'")]),
    ("{initial: 0.1}", "\ninitial: {theta: 1}", [(8, "initial", "unknown key", "to each coordinate")]),
    ("masses:", "positions: {}\nmasses:", [(11, "embedding", "two words for the same section", "leave one")]),
    ("{initial: 0.1}", "{value: 0.1}", [(7, "value", "unknown key 'value'", "write 'initial'")]),
    ("{initial: 0.1}", "{initial: 0, v0: 1}", [(7, "v0", "unknown key 'v0'", "write 'velocity'")]),
    ("{initial: 0.1}", "{initial: 0,5}", [(7, "0,5", "decimal comma", "write 0.5")]),
    ("{initial: 0.1}", "{initial: 30 deg}", [(7, "30 deg", "angle in degrees", "write 30*pi/180")]),
    ("9.81", "6.67 x 10^-11", [(5, "6.67 x 10^-11", "power of ten", "write 6.67e-11")]),
    ("9.81", "6.67×10⁻¹¹ m³/(kg s²)", [
        (5, "6.67×10⁻¹¹ m³/(kg s²)", "number with a unit", "{value: 6.67e-11, unit: m³/(kg s²)}"),
    ]),
    ("  m: 1", "  m: 1 kg", [(3, "1 kg", "number with a unit in", "write {value: 1, unit: kg}")]),
    ("9.81", "9.81 m/s^2", [(5, "9.81 m/s^2", "number with a unit", "{value: 9.81, unit: m/s^2}")]),
    ("9.81", "9,81", [(5, "9,81", "decimal comma", "write 9.81")]),
    ("name: pendulum", "solve: {stop: 1,5, step: 0,1}", [
        (1, "1,5", "decimal comma in stop of solve", "write 1.5"), (1, "0,1", "decimal comma", "write 0.1"),
    ]),
    ("name: pendulum", "observables: {e: 0,5*theta**2}", [
        (1, "0,5*theta**2", "expected a scalar", "write 0.5 for 0,5"),
    ]),
    ("name: pendulum", "observables: {}\npotential: |theta|", [
        (2, "t", "block scalar", "write abs(x) for |x|"),
    ]),
    ("  m: 1", "  m: 1\n  spring k: 1", [
        (4, "spring k", "cannot be called 'spring k'", "call it spring_k: a name"),
    ]),
    ("name: pendulum", "observables: {e: theta# it}", [(1, "#", "misplaced '#'", "a space before the #")]),
    ("name: pendulum", 'solve: {step: "(0, 1)"}', [(1, "(0, 1)", "expected a scalar", "take a component")]),
    ("name: pendulum", "solve: {tmax: 1, dt: 2}", [
        (1, "tmax", "unknown key 'tmax' in solve", "'stop'"), (1, "dt", "unknown key 'dt'", "'step'"),
    ]),
    ("name: pendulum", "solve: {precision: quad}", [(1, "precision", "unknown", "lagrange solve --help")]),
    ("name: pendulum", "solve: {stop: 5 s}", [(1, "5 s", "number with a unit", "time: s")]),
    (POTENTIAL, "m*thetadot**2", [(12, "thetadot", "unknown name", "write theta_dot for the velocity")]),
    (POTENTIAL, "m*dtheta", [(12, "dtheta", "unknown name", "write theta_dot for the velocity")]),
    (POTENTIAL, "m*dtheta/dt", [(12, "dtheta/dt", "unknown name 'dtheta'", "write theta_dot for")]),
    (POTENTIAL, "d(theta)/dt", [(12, "d(theta)/dt", "derivatives are not", "write theta_dot for")]),
    (POTENTIAL, "dot(theta)", [(12, "dot(theta)", "derivatives are not", "write theta_dot for")]),
    (POTENTIAL, "theta.diff(t)", [(12, "theta.diff", "is not a function", "write theta_dot for")]),
    (POTENTIAL, "m*costheta + sin2theta", [
        (12, "costheta", "unknown", "write cos(theta)"), (12, "sin2theta", "unknown", "write sin(2*theta)"),
    ]),
    (POTENTIAL, "m*v", [(12, "v", "unknown name 'v'", "write bob.vx, bob.vy, ... for the components")]),
    (POTENTIAL, "m*g*bob[1]", [(12, "bob[1]", "takes no index", "write bob.y")]),
    ("theta: {", "theta(t): {", [(7, "theta(t)", "cannot be called", "coordinates have no '(t)'")]),
    (POTENTIAL, "thetaddot", [(12, "thetaddot", "acceleration", "equations of motion determine it")]),
    (POTENTIAL, "theta.v", [(12, "theta.v", "has no component 'v'", "theta_dot for its velocity")]),
    (POTENTIAL, "bob.xdot", [(12, "bob.xdot", "has no component 'xdot'", "write bob.vx")]),
    (POTENTIAL, "dot(bob.v, bob)", [(12, "bob.v", "has no component 'v'", "write (bob.vx, bob.vy)")]),
    (POTENTIAL, "m*g*y", [(12, "y", "unknown name 'y'", "write bob.y for the y of bob")]),
    (POTENTIAL, "m*G", [(12, "G", "unknown name 'G'", "did you mean 'g'?")]),
    (POTENTIAL, "2*π*time", [(12, "π", "unknown name", "write pi"), (12, "time", "unknown", "write t")]),
    (POTENTIAL, "thta^2 + omg", [
        (12, "thta", "unknown name 'thta'", "'theta'"), (12, "^", "unknown operator '^'", "write **"),
        (12, "omg", "unknown name 'omg'", "add it to the parameters: 'omg: 1.0'"),
    ]),
    # YAML
    ("  m: 1", "\tm: 1", [(3, "\t", "a tab where YAML expects spaces", "replace each tab")]),
    ("9.81", "%9", [(5, "%", "syntax error: no text can begin with '%'", "put the text in quotes")]),
    ("  m: 1", "  m: 1: 2", [(3, ":", "YAML syntax error", "key: value")]),
    ("  m: 1", "  m: *x", [(3, "*", "'*x' is an unknown YAML alias", "quotes")]),
    ("  m: 1", "  m: !!float 1", [(3, "!", "tags", "leave out")]),
    ("  m: 1", "  <<: {m: 1}", [(3, "<<", "merge keys", ""), (9, "m", "", "")]),
    ("  m: 1", "  m: 'x", [(3, "'", "a quote is not closed", "add a '")]),
    ("  m: 1", "  ? [a]\n  : 1", [(3, "[", "must be a name", ""), (10, "m", "", "")]),
    ("  m: 1", "  m = 1", [(3, "m", "YAML syntax error: missing ': '", "write 'm: 1'")]),
    ("  m: 1", "  m:1", [(3, "m", "YAML syntax error: missing ': '", "write 'm: 1'")]),
    ("parameters:", " parameters:", [(2, "p", "unexpected indentation", "indent it like line 1")]),
    ("name: pendulum", "solve: {outputs: [q, v}", [(1, "}", "YAML syntax error", "write ']' before")]),
    (EMBEDDING, "- (l + 1)", [(11, "-", "YAML syntax error", "for a minus sign leave out the space")]),
    (EMBEDDING, "[dot([l, 1], [1, 1]), 0]", [(11, "[", "YAML syntax error", "quotes")]),
    ("  m: 1", "  m: 1\n---\na: b", [(4, "-", "one document", "")]),
]  # fmt: skip


@pytest.mark.exhaustive(keep=51)
@pytest.mark.parametrize(("old", "new", "expected"), BAD, ids=[f"{new[:40]}" for _, new, _ in BAD])
def test_mistake_is_shown_at_its_place(old: str, new: str, expected: list[tuple[int, str, str, str]]) -> None:
    found = problems(PENDULUM.replace(old, new, 1))
    assert old in PENDULUM
    assert [problem.line for problem in found] == [line for line, _, _, _ in expected]
    for problem, (_, piece, message, hint) in zip(found, expected, strict=True):
        assert underlined(problem) == piece
        assert message in problem.message
        assert hint in problem.hint
        assert problem.hint


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "the file is empty"),
        (b"  \n# nothing\n", "the file is empty"),
        (b"\xff\xfe\x00\x01", "not text in UTF-8"),
        (b"name: \x00", "binary"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "binary"),
        ("name: ä".encode("utf-16"), "not text in UTF-8"),
        (b"name: a\n" * 130_000, "larger than 1000000 bytes"),
        ("name: \ud800", "not text in UTF-8"),
        (b"parameters: {a: 1}", "no masses and no Lagrangian"),
        (b"lagrangian: 0", "the system has no coordinates"),
    ],
)
def test_mistake_of_the_whole_file(data: bytes | str, message: str) -> None:
    found = [problem for problem in problems(data) if problem.line == 0]
    assert any(message in problem.message for problem in found)


def test_contract_example_is_met_to_the_letter() -> None:
    text = changed("potential: m*g*bob.y", "potential: m*g*l*cos(thta)").replace(
        "name: pendulum\nparam", "param"
    )
    text = text.replace("masses:\n  bob: m\n", "masses: {bob: m}\n").replace(
        "embedding:\n  b", "embedding: {b"
    )
    with pytest.raises(SpecError) as caught:
        read_spec(text.replace(")]", ")]}"), "pendulum.yaml")
    assert str(caught.value).splitlines() == [
        "pendulum.yaml:9:22: unknown name 'thta' in potential",
        "   9 | potential: m*g*l*cos(thta)",
        "     |                      ^^^^ did you mean 'theta'?",
    ]


def test_all_mistakes_are_shown_at_once_and_in_order() -> None:
    text = changed("  m: 1", "  m: 2x").replace("bob.y", "bob.q").replace("initial", "initail")
    assert [(p.line, underlined(p)) for p in problems(text)] == [
        (3, "2x"), (3, "x"), (7, "initail"), (12, "bob.q"),
    ]  # fmt: skip


def test_a_position_that_is_wrong_hides_no_wrong_component() -> None:
    text = changed("-l*cos(theta)]", "-l*cos(teta)]").replace("bob.y", "bob.h")
    assert [underlined(problem) for problem in problems(text)] == ["teta", "bob.h"]


def test_a_mistake_in_a_definition_is_said_once() -> None:
    text = changed("potential:", "definitions: {a: 2theta, b: a + 1, c: b.x}\npotential: a + b + c +")
    assert [underlined(problem) for problem in problems(text)] == ["2theta"]


@pytest.mark.exhaustive(keep=0.7)
def test_hopeless_files_are_given_up() -> None:
    text = PENDULUM + "".join(f"key{n}: 1\n" for n in range(1000))
    assert len(problems(text)) == MOST


@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_deep_nesting_is_refused(opening: str) -> None:
    (problem,) = problems(opening * 10_000)
    assert "nested more than 20 deep" in problem.message


def test_billion_laughs_are_refused() -> None:
    letters = "abcdefghijklmnop"
    lines = ["a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"{y}: &{y} [{', '.join([f'*{x}'] * 10)}]" for x, y in pairwise(letters)]
    (problem,) = problems("\n".join(lines))
    assert "more than 50000 values with its aliases expanded" in problem.message


def test_multiplying_definitions_are_refused() -> None:
    doubling = "".join(f"  d{n + 1}: d{n}*d{n}\n" for n in range(60))
    found = problems(PENDULUM + "definitions:\n  d0: theta\n" + doubling)
    assert [problem.message for problem in found] == [
        "the expression has more than 1000000 terms with its definitions expanded (limit 'size') "
        "in definition 'd19'"
    ]


def test_exponents_are_bounded_through_definitions() -> None:
    (problem,) = problems(PENDULUM + "definitions: {n: 9*9, power: theta**n}\n")
    assert (
        problem.message
        == "the exponent 81 is out of bounds (-64 to 64; limit 'exponent') in definition 'power'"
    )
    assert underlined(problem) == "theta**n"


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(("step", "last"), [("sin(d{})", 101), ("d{}*theta + 1", 51), ("1/(1 + d{})", 51)])
def test_definitions_nested_too_deep_are_refused(step: str, last: int) -> None:
    nested = "".join(f"  d{n + 1}: {step.format(n)}\n" for n in range(3000))
    found = problems(PENDULUM + "definitions:\n  d0: theta\n" + nested)
    message = "the expression is nested more than 100 deep with its definitions expanded"
    assert [problem.message for problem in found] == [f"{message} in definition 'd{last}'"]


def test_long_sums_of_definitions_are_not_deep() -> None:
    sums = "".join(f"  d{n + 1}: d{n} + m*sin({n}*theta)\n" for n in range(200))
    assert not problems(PENDULUM + "definitions:\n  d0: 0\n" + sums)


@pytest.mark.parametrize(
    ("scalar", "line", "column", "length"),
    [
        ("m*thta", 1, 14, 4),
        ("'m*thta'", 1, 15, 4),
        ('"m*thta"', 1, 15, 4),
        ('"m*\\x74hta"', 1, 15, 7),
        ('"m*\\\n   th\\\n  ta"', 2, 4, 2),
        ('"\\tm*\\ thta"', 1, 19, 4),
        ("&anchor 'm*thta'", 1, 23, 4),
        ("&anchor m*thta", 1, 22, 4),
        ("m\n  *thta", 2, 4, 4),
        ('"m\n\n  *thta"', 3, 4, 4),
        (">\n  m +\n\n  g*thta", 4, 5, 4),
        ("|-  # thta\n   m*thta", 2, 6, 4),
        ("m * (g\n   - thta)  # thta", 2, 6, 4),
    ],
)  # fmt: skip
def test_caret_finds_the_piece_in_any_kind_of_scalar(
    scalar: str, line: int, column: int, length: int
) -> None:
    text = PENDULUM[: PENDULUM.index("potential")].replace("name: pendulum\n", f"potential: {scalar}\n")
    (problem,) = problems(text)
    assert (problem.line, problem.column, problem.length) == (line, column, length)


def test_columns_count_characters_not_bytes() -> None:
    text = PENDULUM.replace("theta", "θ").replace("m*g*bob.y", "'ü' ")
    text = text.replace("'ü' ", "sin(θ)*m + θθ  # ä")
    (problem,) = problems(text)
    assert underlined(problem) == "θθ"


def test_a_list_of_numbers_is_no_vector() -> None:
    text = PENDULUM.replace("  m: 1", "  m: 1\n  B: [0, 1]").replace(POTENTIAL, "dot(B, bob)")
    (problem,) = problems(text)
    assert underlined(problem) == "B"
    assert problem.hint == "write B[i] for one member, or (B[0], B[1]) for a vector"


def test_energies_of_a_lagrangian_are_definitions() -> None:
    """They are not the energies of particles, and their names are not reported again where they are used."""
    text = "coordinates: {x: {initial: 1}}\nlagrangian: T - V\nT: x_dot**2/2\nV: x**2/2\n"
    found = problems(text)
    assert [problem.message for problem in found] == ["unknown key 'T'", "unknown key 'V'"]
    assert [problem.hint for problem in found] == [
        f"write it under 'definitions', as in 'definitions: {{{name}: ...}}'" for name in "TV"
    ]


def test_members_of_a_list_are_shown_for_a_name_with_a_number() -> None:
    (found,) = problems(
        PENDULUM.replace("  m: 1", "  m: [1, 2]").replace("bob: m", "bob: m1").replace("m*g", "g")
    )
    assert (found.message, found.hint) == (
        "unknown name 'm1' in mass of 'bob'",
        "the members are m[0] to m[1]",
    )


BODY = """\
coordinates: {w: {initial: 1}, x: {initial: 0}, y: {initial: 0}, z: {initial: 0}}
masses: {bob: 1}
positions: {bob: [x, 0, 0]}
bodies:
  top: {mass: 1, position: [0, 0, 0], inertia: [1, 2, 2.5], orientation: {quaternion: [w, x, y, z]}}
potential: x
"""


@pytest.mark.parametrize(
    ("given", "instead", "message"),
    [
        ("[1, 2, 2.5]", "[1, 2, 3.5]", "the value 3.5 exceeds 1 + 2 in inertia of body 'top'"),
        ("[1, 2, 2.5]", "[1, 1, 2.0000001]", "the value 2.0000001 exceeds 1 + 1 in inertia of body 'top'"),
        ("[1, 2, 2.5]", "[1, -2, 2]", "the value -2 is not positive in inertia"),
        ("[1, 2, 2.5]", "[[1, 0.1, 0], [0.2, 1, 0], [0, 0, 1]]", "not symmetric: I12 = 0.1, but I21 = 0.2"),
        ("[1, 2, 2.5]", "[[1, 0, 0], [0, 1, 2], [0, 2, 1]]", "not positive definite"),
        ("[1, 2, 2.5]", "[[1, 0.1, 0], [0.1, 1, 0], [0, 0, 3]]", "the principal moments 0.9, 1.1, 3 in"),
        ("[1, 2, 2.5]", "[1, 2]", "must be a list of 3 components, not 2"),
        ("[1, 2, 2.5]", "[1, 2, x]", "the coordinate 'x' cannot be used in inertia"),
        ("inertia: [1, 2, 2.5]", "solid: {ball: 2}", "unknown solid 'ball'"),
        ("inertia: [1, 2, 2.5]", "solid: {box: 2}", "the box of body 'top' must be a list of 3"),
        ("inertia: [1, 2, 2.5]", "solid: {sphere: -2}", "the value -2 is not positive in sphere"),
        (", orientation: {quaternion: [w, x, y, z]}", "", "body 'top' has no orientation"),
        ("[w, x, y, z]", "[w, x, y]", "must be a list of 4 components, not 3"),
        ("quaternion: [w, x, y, z]", "euler: [x, y, z], sequence: zzx", "'zzx' is not a sequence of axes"),
        ("quaternion: [w, x, y, z]", "matrix: [[1, 2, 3], [1, 2, 3]]", "must have 3 rows, not 2"),
        ("[1, 2, 2.5]", "[[1, 0], [0, 1]]", "inertia of body 'top' must have 3 rows, not 2"),
        ("potential: x", "potential: bob.at(1, 0, 0).x", "the particle 'bob' is not a rigid body"),
        ("potential: x", "potential: top.at(1, 0).x", "arguments for 'top.at': 2 instead of 3"),
        ("potential: x", "potential: top.at(1, 0, 0).w", "a point of a body has no component 'w'"),
        ("potential: x", "potential: bob.w1", "the particle 'bob' is not a rigid body"),
        ("positions: {bob", "positions: {top: [x, 0, 0], bob", "the body 'top' has the name of a particle"),
        ("potential: x", "torques: {bob: [0, 0, 1]}", "unknown body 'bob' in torques"),
        ("position: [0, 0, 0]", "position: [0, 0]", "the position of body 'top' has 2 components, not 3"),
    ],
)
def test_a_wrong_body(given, instead, message):
    assert given in BODY
    with pytest.raises(SpecError) as caught:
        resolve_values(read_spec(BODY.replace(given, instead), "body.yaml"))
    found = [one.message for one in caught.value.problems]
    assert sum(message in one for one in found) == 1, found
    assert all(one.line for one in caught.value.problems)


def test_a_list_in_quotes_is_no_list():
    with pytest.raises(SpecError) as caught:
        read_spec(BODY.replace("[w, x, y, z]", "'[w, x, y, z]'"), "body.yaml")
    (found,) = caught.value.problems
    assert found.hint == "leave out the quotes around the list"


@pytest.mark.parametrize(
    ("inertia", "hint"),
    [
        ("[3, 3, 0]", "with the moments J, J, 0 is 'solid: {rod: l}' with l = sqrt(12*J/m)"),
        ("[3, 0, 3]", "sqrt(12*J/m); it lies along the third axis, so turn the orientation"),
        ("[[3, 0, 0], [0, 3, 0], [0, 0, 0]]", "'solid: {rod: l}' with l = sqrt(12*J/m)"),
        ("[0, 0, 3]", "write [J, J, J]"),
        ("[1, 2, 0]", "only a thin rod has none about one axis"),
        ("[0, 0, 0]", "is a particle"),
        ("[1, -2, 2]", "moments of inertia are greater than 0"),
    ],
)
def test_what_has_no_moment_about_an_axis_is_told_what_it_may_be(inertia, hint):
    with pytest.raises(SpecError) as caught:
        resolve_values(read_spec(BODY.replace("[1, 2, 2.5]", inertia), "body.yaml"))
    assert hint in caught.value.problems[0].hint
