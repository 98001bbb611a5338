"""The table of scenes."""

from __future__ import annotations

from benchmarks.motions import closed_forms as closed
from benchmarks.motions.motion import shipped
from benchmarks.stress.scene import Scene, bodies, particle

NBODY = ("heyoka", "DOP853", "Radau", "IAS15")
EXPLICIT = ("heyoka", "DOP853")


POLAR = """\
parameters: {b: 1e-8}
coordinates:
  r: {initial: sqrt(1 + b**2), velocity: -1/sqrt(1 + b**2)}
  phi: {initial: 0, velocity: b/(1 + b**2)}
masses: {p: 1}
embedding: {p: [r*cos(phi), r*sin(phi)]}
potential: 0
"""
KAPITZA = """\
parameters: {g: 9.81, l: 1, a: 1e-3, w: 1e4}
coordinates:
  theta: {initial: 0.1}
masses: {bob: 1}
embedding: {bob: [l*sin(theta), a*cos(w*t) + l*cos(theta)]}
potential: g*bob.y
"""
SPRING_PENDULUM = """\
parameters: {k: 1e10, g: 9.81}
coordinates:
  x: {initial: 0.6}
  y: {initial: -0.8000001}
masses: {bob: 1}
embedding: {bob: [x, y]}
potential: g*y + k*(sqrt(x**2 + y**2) - 1)**2/2
"""
SCALES = """\
parameters: {GM: 1.32712440018e20, au: 1.495978707e11, k: 1e-6}
coordinates:
  x: {initial: au}
  y: {initial: 0, velocity: sqrt(GM/au)}
  d: {initial: 1e-6}
masses: {earth: 5.972e24, grain: 1e-15}
embedding: {earth: [x, y, 0], grain: [d, 0, 0]}
potential: -GM*5.972e24/norm(earth) + 1e-15*k*d**2/2
"""
TOP = """\
parameters: {I1: 1, I3: 0.5, mgl: 1, spin: 5}
coordinates:
  theta: {initial: 1e-3}
  phi: {initial: 0, velocity: 1}
  psi: {initial: 0, velocity: spin}
lagrangian: I1*(theta_dot**2 + phi_dot**2*sin(theta)**2)/2
  + I3*(psi_dot + phi_dot*cos(theta))**2/2 - mgl*cos(theta)
"""
L4 = """\
parameters: {mu: 0.01}
coordinates:
  x: {initial: 0.5 - mu}
  y: {initial: sqrt(3)/2}
lagrangian: (x_dot**2 + y_dot**2)/2 + x*y_dot - y*x_dot + (x**2 + y**2)/2
  + (1 - mu)/sqrt((x + mu)**2 + y**2) + mu/sqrt((x - 1 + mu)**2 + y**2)
"""
HENON_HEILES = """\
coordinates:
  x: {initial: 0}
  y: {initial: 0.1, velocity: 0.1}
  z: {initial: 0}
masses: {p: 1}
embedding: {p: [x, y, z]}
potential: (x**2 + y**2)/2 + x**2*y - y**3/3
"""
TWO_OSCILLATORS = """\
parameters: {k: 1, detuning: 1e-15}
coordinates:
  x: {initial: 1}
  y: {initial: 1}
masses: {p: 1}
embedding: {p: [x, y]}
potential: k*x**2/2 + k*(1 + detuning)*y**2/2
"""


def slider(embedding: str, potential: str, v: str) -> str:
    """A particle whose place is a function of x: the mass matrix is its slope, squared."""
    return (
        f"coordinates:\n  x: {{initial: 1, velocity: {v}}}\n"
        f"masses: {{p: 1}}\nembedding: {{p: [{embedding}]}}\npotential: {potential}\n"
    )


SCENES = (
    # -- gravity ------------------------------------------------------------------------------------
    Scene(
        "near_collision", "Kepler's ellipse, e = 0.999999, 10 periods", shipped("central_force_cartesian"),
        62.8, settings=("e=0.999999",), peers=EXPLICIT,
    ),
    Scene(
        "near_collision_polar", "the same in polar coordinates", shipped("central_force"), 62.8,
        settings=("e=0.999999",), peers=EXPLICIT,
    ),
    Scene(
        "pythagorean", "Burrau's three bodies of masses 3, 4, 5, from rest",
        bodies("3, 4, 5", "1, -2, 1", "3, -1, -1", "0, 0, 0", "0, 0, 0"), 70.0, peers=NBODY,
        error=0.1,  # close encounters make much of each step's rounding of places of size 1
    ),
    Scene(
        "mass_ratio", "a star and planets of 1e-6 and 1e-12 of its mass",
        bodies("1, 1e-6, 1e-12", "0, 1, 2", "0, 0, 0", "0, 0, 0", "0, 1, 0.7"), 200.0, peers=NBODY,
    ),
    Scene(
        "head_on", "a head-on collision of two bodies",
        bodies("1, 1", "-0.5, 0.5", "0, 0", "0, 0", "0, 0"), 2.0,
        reference=None, peers=NBODY, quick=True,
    ),
    Scene(
        "fall_to_centre", "a fall into the centre of a potential -1/x", particle("-1/x", x="1"), 2.0,
        reference=None, quick=True,
    ),
    Scene("scales", "the Earth in SI units and a grain oscillating by a micrometre", SCALES, 3.2e7),
    Scene("lagrange_point", "at rest at L4, mass ratio 0.01", L4, 200.0, quick=True),
    Scene(
        "figure_eight", "the figure eight, 50 periods", shipped("figure_eight"), 316.3, peers=NBODY,
    ),
    # -- pendulums and tops -------------------------------------------------------------------------
    Scene(
        "double_pendulum", "a chaotic double pendulum, 1e6 s", shipped("double_pendulum"), 1e6,
        reference=None, samples=2001, peers=("heyoka",),
    ),
    Scene(
        "chaos", "the same, 30 s: longer than rounding errors allow to predict",
        shipped("double_pendulum"), 30.0,
    ),
    Scene(
        "upside_down", "a pendulum released at theta = pi, rounded to a double", shipped("pendulum"), 30.0,
        settings=("theta=pi", "theta_dot=0"), quick=True,
    ),
    Scene(
        "balanced", "a pendulum exactly upside down",
        "coordinates:\n  a: {initial: 0}\nmasses: {p: 1}\nembedding: {p: [sin(a), cos(a)]}\n"
        "potential: 9.81*p.y\n",
        1000.0, reference=closed.constant, quick=True,
    ),
    Scene(
        "pole", "a spherical pendulum that passes its pole at 1e-8", shipped("spherical_pendulum"), 20.0,
        settings=("theta=1", "theta_dot=0", "phi_dot=3e-8"),
    ),
    Scene(
        "through_pole", "a spherical pendulum through its pole, p = 0", shipped("spherical_pendulum"), 20.0,
        settings=("theta=1", "theta_dot=0", "phi_dot=0"), peers=EXPLICIT,
    ),
    Scene(
        "bifurcation", "a bead on a hoop that rotates at the critical rate", shipped("rotating_hoop"), 200.0,
        settings=("omega=sqrt(g/a)", "theta=0.1"), size=1.0,  # of the forces that cancel
        quick=True,
    ),
    Scene("kapitza", "Kapitza's pendulum, driven at 1e4 rad/s", KAPITZA, 1.0, peers=EXPLICIT, size=1e3,
          error=1e-9),  # the pivot is accelerated by 1e5, and w*t known to 1e-12
    Scene(
        "sleeping_top", "a fast top, 1e-3 from the vertical", TOP, 50.0, quick=True,
    ),
    Scene(
        "chain", "a chain of fifty pendulums", shipped("n_pendulum"), 10.0, reference=None,
        peers=(),
    ),
    # -- stiff, steep, kinked -----------------------------------------------------------------------
    Scene("stiff_spring", "a pendulum on a spring of stiffness 1e10", SPRING_PENDULUM, 0.1, peers=EXPLICIT),
    Scene(
        "strong_damping", "an overdamped oscillator, damping 1e6",
        particle("x**2/2", more="dissipation: 1e6*x_dot**2/2\n"), 10.0, reference=closed.overdamped,
        error=1e-10,
    ),
    Scene("steep_wall", "between walls x**42", particle("x**42/42", x="0.5", v="1"), 100.0, quick=True),
    Scene(
        "exponential_wall", "between walls exp(+-100 x)",
        particle("exp(100*(x - 1)) + exp(-100*(x + 1))", x="0", v="1"), 50.0, quick=True,
    ),
    Scene(
        "kink", "abs(x) written as sqrt(x**2)", particle("sqrt(x**2)"), 20.0, reference=closed.kink,
        quick=True,
    ),
    Scene(
        "rounded_kink", "sqrt(x**2 + 1e-16): a kink 1e-8 wide", particle("sqrt(x**2 + 1e-16)"), 20.0,
        peers=EXPLICIT,
    ),
    Scene(
        "step", "crossing a potential step tanh(1e6 x)/4",
        particle("tanh(1e6*x)/4", x="-1", v="2"), 2.0, reference=closed.potential_step,
        peers=EXPLICIT, quick=True,
    ),
    Scene(
        "bump", "crossing a potential exp(-(1e6 x)**2)/4",
        particle("exp(-(1e6*x)**2)/4", x="-1", v="2"), 2.0, reference=closed.narrow_bump,
        peers=EXPLICIT, quick=True,
    ),
    Scene(
        "narrow_well", "crossing a potential -1/(1 + (1e6 x)**4)/4",
        particle("-1/(1 + (1e6*x)**4)/4", x="-1", v="2"), 2.0, reference=closed.narrow_well,
        peers=EXPLICIT, quick=True,
    ),
    Scene(
        "pulse", "a free particle hit by a pulse exp(-(t - 50)**2/w**2), w = 1e-3",
        particle("-x*exp(-((t - 50)/w)**2)/(w*sqrt(pi))", w="1e-3", x="0"), 100.0,
        reference=closed.pulse, quick=True,
    ),
    # -- ranges of numbers --------------------------------------------------------------------------
    Scene(
        "rod", "a bead on a rotating rod, to x = exp(700)", particle("-x**2/2"), 700.0, reference=closed.rod,
        error=1e-10, quick=True,
    ),
    Scene(
        "overflow", "the same to exp(720), beyond the range of doubles", particle("-x**2/2"), 720.0,
        reference=closed.rod, error=1e-10, quick=True,
    ),
    Scene(
        "denormal", "an oscillator of amplitude 1e-310", particle("x**2/2", x="1e-310"), 100.0,
        reference=closed.oscillator, error=1e-10, quick=True,
    ),
    Scene(
        "huge", "an oscillator of amplitude 1e150", particle("x**2/2", x="1e150"), 100.0,
        reference=closed.oscillator, quick=True,
    ),
    Scene(
        "tiny_times", "an oscillator of 1e30 rad/s", particle("w**2*x**2/2", w="1e30"), 1e-28,
        reference=closed.oscillator, quick=True,
    ),
    Scene(
        "huge_times", "an oscillator of 1e-30 rad/s", particle("w**2*x**2/2", w="1e-30"), 1e32,
        reference=closed.oscillator, known="High coefficients of the series underflow, so that the steps "
        "become far too short: measure time in a larger unit.",
    ),
    Scene(
        "late", "free fall, t from 1e9", particle("9.81*x", x="0", v="50"), 1e9 + 10, start=1e9,
        reference=closed.fall, quick=True,
    ),
    Scene(
        "far_away", "an oscillator about x = 1e12", particle("(x - 1e12)**2/2", x="1e12 + 1"), 100.0,
        reference=closed.far_oscillator, size=1e12, quick=True,
    ),
    Scene(
        "detuning", "two oscillators detuned by 1e-15, 1e4 periods", TWO_OSCILLATORS, 62832.0,
        reference=closed.detuned, peers=EXPLICIT, error=1e-9,
    ),
    Scene(
        "million_periods", "1e6 sampled periods of an oscillator", particle("x**2/2"), 6283185.307179586,
        reference=closed.oscillator, samples=1_000_001, peers=("heyoka",), error=1e-8,
    ),
    Scene(
        "cancellation", "at rest, under the force exp(t)*exp(-t) - 1 = 0",
        particle("-x*(exp(t)*exp(-t) - 1)", x="1"), 30.0, reference=closed.constant, size=1.0, quick=True,
    ),
    Scene("unstable", "negative stiffness, starting at 1e-300", particle("-x**2/2", x="1e-300"), 600.0,
          reference=closed.rod, error=1e-10),
    # -- sampling -----------------------------------------------------------------------------------
    Scene(
        "two_samples", "1e4 periods between two samples", particle("x**2/2"), 62831.853, samples=2,
        reference=closed.oscillator, peers=EXPLICIT, error=1e-9,
    ),
    Scene(
        "dense_samples", "samples 1e-12 apart", particle("x**2/2"), 1e-7, samples=100_001,
        reference=closed.oscillator, quick=True,
    ),
    # -- singular -----------------------------------------------------------------------------------
    Scene("mass_approached", "a mass matrix that becomes nearly singular",
          slider("x**2/2", "1e-8/x", "-1"), 2.0, peers=EXPLICIT),
    Scene("mass_crossed", "a mass matrix x**4 that becomes singular",
          slider("x**3/3", "0", "-1"), 2.0, reference=closed.cubic, quick=True),
    Scene("polar_near", "a free particle in polar coordinates, passing the origin at 1e-8", POLAR, 2.0,
          reference=closed.polar, peers=EXPLICIT, error=1e-7),
    Scene("polar_through", "the same through the origin", POLAR, 2.0, settings=("b=0",),
          reference=closed.polar, quick=True),
    Scene("blow_up", "x'' = 6 x**2, which reaches infinity at t = 1",
          particle("-2*x**3", x="1", v="2"), 2.0, reference=closed.blow_up, quick=True),
    Scene("edge_of_domain", "a force with sqrt(x), followed beyond x = 0",
          particle("x**1.5", x="1", v="-2"), 3.0, reference=None, quick=True),
    Scene("dissociation", "a Morse bond that barely breaks",
          particle("(1 - exp(-x))**2", x="0", v="sqrt(2)*(1 + 1e-12)"), 1000.0),
    Scene("escape", "the Hénon-Heiles potential near the escape energy", HENON_HEILES, 200.0,
          settings=("x_dot=0.55",)),
)  # fmt: skip
