"""Motions of many kinds, small and large, for the choice of a method: shipped systems and families that begin
in states drawn by a seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from benchmarks import ROOT


@dataclass(frozen=True)
class Varied:
    """A motion of ``kind``, one of a ``group``, with the sizes of its families, which is followed to ``stop``
    (0: to that of its file)."""

    group: str
    kind: str
    text: str
    stop: float
    sizes: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The kind and the sizes."""
        return " ".join([self.kind, *(f"{name}={size}" for name, size in self.sizes.items())])


BODIES = """
sizes: {{N: 10, L: {side}}}
coordinates:
  x[i in range(N)]:
    initial: {apart}*(i % L - (L - 1)/2 + sin(12.9898*i + {seed})/5)
    velocity: {speed}*sin(3.7*i + {seed})
  y[i in range(N)]:
    initial: {apart}*(i//L % L - (L - 1)/2 + sin(78.233*i + {seed})/5)
    velocity: {speed}*sin(5.3*i + {seed})
  z[i in range(N)]:
    initial: {apart}*(i//(L*L) - (L - 1)/2 + sin(37.719*i + {seed})/5)
    velocity: {speed}*cos(4.1*i + {seed})
masses: {{"body[i in range(N)]": {mass}}}
embedding: {{"body[i in range(N)]": ["x[i]", "y[i]", "z[i]"]}}
potential: sum({pair} for i in range(N) for j in range(i))
"""
R = "norm(body[i] - body[j])"
R2 = "dot(body[i] - body[j], body[i] - body[j])"
PAIRS = {
    "Newton": (f"-1/N**2/{R}", "1/N", 0.6, 0.3),
    "Plummer": (f"-1/N**2/sqrt({R2} + 0.04)", "1/N", 0.6, 0.3),
    "Yukawa": (f"exp(-{R})/{R}/N", "1", 1.0, 0.5),
    "Gaussian core": (f"exp(-{R2})", "1", 1.0, 0.5),
    "Lennard-Jones": (f"4*({R2}**-6 - {R2}**-3)", "1", 1.2, 0.3),
    "Morse": (f"(1 - exp(1 - {R}))**2/N", "1", 1.1, 0.3),
    "log": (f"log({R2})/N", "1", 1.0, 0.5),
    "power 2.5": (f"{R}**2.5/N", "1", 1.0, 0.5),
    "power 4": (f"{R2}**2/N", "1", 1.0, 0.5),
    "power -2.7": (f"{R}**-2.7/N", "1", 1.0, 0.5),
}
"""Potentials between pairs, the mass of a body, and how far apart and how fast they are."""
COUNTS = {3: (2, 20.0), 10: (3, 20.0), 30: (4, 8.0), 100: (5, 2.0), 300: (7, 0.5), 1000: (10, 0.01)}
"""The numbers of bodies, of those at a side of the cube where they begin, and when the motion ends."""
LARGE, LARGEST = 300, ("Newton", "Yukawa", "Lennard-Jones")
"""Only of these are there more bodies than that."""
RING = """
sizes: {{N: 10}}
coordinates:
  u[i in range(N)]: {{initial: {size}*sin(12.9898*i + {seed}), velocity: {size}*cos(3.7*i + {seed})}}
lagrangian: sum(u_dot[i]**2/2 - ({site}) - ({bond}) for i in range(N))
"""
STRETCH = "(u[(i + 1) % N] - u[i])"
RINGS = {
    "linear": ("0", f"{STRETCH}**2/2"),
    "FPUT alpha": ("0", f"{STRETCH}**2/2 + {STRETCH}**3/12"),
    "FPUT beta": ("0", f"{STRETCH}**2/2 + {STRETCH}**4/4"),
    "Toda": ("0", f"exp(-{STRETCH}) + {STRETCH}"),
    "phi^4": ("u[i]**4/4 - u[i]**2/2", f"{STRETCH}**2/2"),
    "sine-Gordon": ("-cos(u[i])", f"{STRETCH}**2/2"),
}
"""The potentials of sites and of bonds."""
KURAMOTO = """
sizes: {{N: 10}}
coordinates:
  u[i in range(N)]: {{initial: 3*sin(12.9898*i + {seed}), velocity: cos(3.7*i + {seed})}}
masses: {{"o[i in range(N)]": 1}}
embedding: {{"o[i in range(N)]": "u[i]"}}
potential: sum(-2/N*cos(u[i] - u[j]) for i in range(N) for j in range(i))
dissipation: sum(0.3*u_dot[i]**2/2 for i in range(N))
"""
DRAGS = """
sizes: {{N: 3}}
parameters: {{c: {c}, k: 100}}
coordinates:
  x[i in range(N)]: {{initial: i + 0.3*sin(12.9898*i + {seed})}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": "x[i]"}}
potential: sum(k*(x[i] - x[i - 1] - 1)**2/2 for i in range(1, N))
dissipation: sum(c*x_dot[i]**2/2 for i in range(N))
"""
SQUARE_DRAG = """
sizes: {{N: 3}}
coordinates:
  x[i in range(N)]: {{initial: i, velocity: 1 + 0.5*sin(3.7*i + {seed})}}
  y[i in range(N)]: {{initial: 0, velocity: 2 + 0.5*cos(3.7*i + {seed})}}
masses: {{"ball[i in range(N)]": 1 + i/N}}
embedding: {{"ball[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(9.81*(1 + i/N)*y[i] for i in range(N))
forces: {{"ball[i in range(N)]": "-0.1*norm((x_dot[i], y_dot[i]))*(x_dot[i], y_dot[i])"}}
"""
DRIVEN = {
    "Duffing, driven": """
coordinates: {x: {initial: 0.5}}
masses: {m: 1}
embedding: {m: x}
potential: x**4/4 - x**2/2 - 0.3*x*cos(1.2*t)
dissipation: 0.2*x_dot**2/2
""",
    "pendulum, shaken": """
coordinates: {a: {initial: 0.5}}
masses: {m: 1}
embedding: {m: [sin(a), 0.1*cos(30*t) - cos(a)]}
potential: 9.81*m.y
""",
    "Morse, driven": """
coordinates: {x: {initial: 0.5}}
masses: {m: 1}
embedding: {m: x}
potential: (1 - exp(-x))**2 - 0.1*x*cos(t)
""",
    "exponentials": """
coordinates: {x: {initial: 0.5}, y: {initial: 0.2, velocity: 1}}
masses: {m: 1}
embedding: {m: [x, y]}
potential: exp(x + 0.3*y) + exp(-x - y) + exp(y**2/3) + exp(x**2/4) + log(3 + x**2 + y**2)
""",
}
STIFF = {
    "van der Pol": """
coordinates: {x: {initial: 2}}
lagrangian: (x_dot**2 - x**2)/2
generalized_forces: {x: 100*(1 - x**2)*x_dot}
""",
    "springs and dampers": """
sizes: {N: 20}
coordinates: {"x[i in range(N)]": {initial: "i + sin(3*i)/10"}}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: sum((x[i] - x[i - 1] - 1)**2/2 for i in range(1, N))*1e4 + (x[0]**2)*5e3
dissipation: sum((x_dot[i] - x_dot[i - 1])**2/2 for i in range(1, N))*1e3 + x_dot[0]**2*500
""",
    "pendulum on a stiff rod": """
coordinates: {r: {initial: 1}, a: {initial: 1}}
masses: {bob: 1}
embedding: {bob: [r*sin(a), -r*cos(a)]}
potential: 9.81*bob.y + 1e6*(r - 1)**2/2
dissipation: 2e4*r_dot**2/2
""",
    "magnetic brake": """
coordinates: {a: {initial: 0.3}, b: {initial: 1, velocity: 2}}
masses: {rim: 1, bob: 1}
embedding: {rim: [sin(a), -cos(a)], bob: [2*sin(b), -2*cos(b)]}
potential: 9.81*(rim.y + bob.y) + cos(a - b)
dissipation: 5e3*(2 + sin(a))*a_dot**2/2
""",
}


GROUPS = ("systems", "bodies", "rings", "pendulums", "oscillators", "drag", "driven", "stiff")


def varied(seed: int) -> Iterator[Varied]:
    """All of them; small changes of initial values are drawn by the seed."""
    for path in sorted((ROOT / "systems").glob("*.yaml")):
        yield Varied("systems", path.stem, path.read_text(encoding="utf-8"), 0.0)
    for kind, (pair, mass, apart, speed) in PAIRS.items():
        for count, (side, stop) in COUNTS.items():
            if count > LARGE and kind not in LARGEST:
                continue
            text = BODIES.format(pair=pair, mass=mass, apart=apart, speed=speed, seed=seed, side=side)
            yield Varied("bodies", kind, text, stop, {"N": str(count)})
    for kind, (site, bond) in RINGS.items():
        for count, stop in ((3, 200.0), (10, 200.0), (100, 50.0), (1000, 10.0)):
            text = RING.format(site=site, bond=bond, size=1.0, seed=seed)
            yield Varied("rings", kind, text, stop, {"N": str(count)})
    chain = (ROOT / "systems" / "n_pendulum.yaml").read_text(encoding="utf-8")
    for count, stop in ((2, 8.0), (10, 2.0), (20, 1.5), (50, 1.0), (200, 0.5), (1000, 0.2)):
        yield Varied("pendulums", "pendulums", chain, stop, {"N": str(count)})
    for count, stop in ((3, 20.0), (10, 20.0), (30, 10.0), (100, 10.0), (300, 5.0)):
        yield Varied("oscillators", "Kuramoto", KURAMOTO.format(seed=seed), stop, {"N": str(count)})
    for c in (1, 100, 1e4):
        for count, stop in ((2, 20.0), (20, 20.0), (200, 5.0)):
            yield Varied("drag", f"drag {c:g}", DRAGS.format(seed=seed, c=c), stop, {"N": str(count)})
    for count in (2, 10, 100):
        yield Varied("drag", "quadratic drag", SQUARE_DRAG.format(seed=seed), 2.0, {"N": str(count)})
    for kind, text in DRIVEN.items():
        yield Varied("driven", kind, text, 50.0)
    for kind, text in STIFF.items():
        yield Varied("stiff", kind, text, 50.0)
