"""Kills runs at random moments and resumes them: ``python -m tests.fuzzing.soak [--kills 500] [--seed 1]``.

System, outputs, samples, method, precision, checkpoints, direction and the rest are drawn at random: motions,
also with constraints, bodies and events, sweeps, and sections of one motion or of many. Each run is ended a
few times, and continued until it has come to its end. After every kill, under the output's name stands a
whole output or none; the last one must have the same bytes as that of an undisturbed run.
"""

from __future__ import annotations

import argparse
import json
import random
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py

from lagrange_cli.outputs.catalog import PARTICLE_OUTPUTS
from tests.support.command import PATIENCE, SYSTEMS, environment, lagrange_process

KILLS = (signal.SIGKILL,) * 9 + (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""The most are such that the process is never asked."""
OFTEN = ("--checkpoint", "0.03")
MOST = 8
"""So often a run is ended before it is left in peace."""

SECOND = {
    "central_force": 100_000, "central_force_cartesian": 80_000, "charged_particle": 400_000,
    "double_pendulum": 12_000, "driven_damped_pendulum": 100_000, "figure_eight": 20_000, "fpu_chain": 40_000,
    "free_particles": 30_000, "gauge_oscillator": 500_000, "harmonic_oscillator": 500_000,
    "henon_heiles": 200_000, "lattice": 10_000, "n_pendulum": 1_200, "parabola_bead": 40_000,
    "pendulum": 120_000, "rotating_hoop": 40_000, "solar_system": 40_000, "spherical_pendulum": 25_000,
}  # fmt: skip
"""What is followed, and for how long: about a second of work."""
GUIDED = {
    "andrews_squeezer": 3, "bicycle": 20, "car_axis": 80, "chain": 400, "chaplygin_sleigh": 3000,
    "coin": 2000, "four_bar": 10_000, "free_top": 3000, "gyroscope": 1500, "lagrange_top": 1500,
    "physical_pendulum": 3000, "rattleback": 3, "rolling_disc": 1500, "turntable_ball": 6000,
}  # fmt: skip
"""With constraints, also nonholonomic ones, and rigid bodies."""
DRIVEN = {"car_axis"}
"""Constraints that contain t, and are not satisfied by the initial values at other times."""
HAPPENING = {"bouncing_ball": 6, "kicked_rotor": 400, "incline": 5}
"""With events that change the motion, impacts that accumulate, and friction."""
DAMPED = "driven_damped_pendulum"
"""Drawn more often: it is chaotic, and has steps that are hard to predict."""
SWEPT = {
    "double_pendulum": ("theta1=0.1:2:{}", "theta2"), "driven_damped_pendulum": ("A=0.5:1.5:{}", "theta"),
    "pendulum": ("l=0.5:2:{}", "theta"), "spherical_pendulum": ("theta=0.3:1.2:{}", "phi"),
    "parabola_bead": ("x=0.1:1:{}", "x"),
}  # fmt: skip
"""What is swept, over a grid and at random."""
CROSSED = {
    "henon_heiles": (("--where", "x"), "y0=-0.2:0.4:{}", 50_000),
    "driven_damped_pendulum": (("--every", "2*pi/Omega"), "A=1:1.5:{}", 200_000),
    "pendulum": (("--where", "theta", "--direction", "either"), "theta=0.1:2:{}", 60_000),
    "spherical_pendulum": (("--where", "theta_dot"), "theta=0.3:1.2:{}", 20_000),
}  # fmt: skip
"""Sections: the surface, what is swept, and the crossings that take about a second."""
OUTPUTS = ("q", "v", "p", "h", "T", "U", "energy", "positions", "ledger", "action")
WITHOUT_PARTICLES = {"gauge_oscillator", "lattice"}


@dataclass(frozen=True)
class Scene:
    """A command, the name of what it writes, the modes that it is counted under, and options of a shorter
    run that is there already."""

    arguments: tuple[str, ...]
    output: str
    modes: tuple[str, ...] = ()
    shorter: tuple[str, ...] = ()


def random_scene(chance: random.Random) -> Scene:
    """Any of them."""
    draw = chance.choices((random_motion, random_sweep, random_section), (6, 2, 2))[0]
    return draw(chance)


def random_motion(chance: random.Random) -> Scene:
    """A motion that takes about a second."""
    mode, known = chance.choices(
        (("motion", SECOND), ("constraints", GUIDED), ("events", HAPPENING)), (3, 2, 1)
    )[0]
    name, modes = chance.choice([*known, DAMPED] if mode == "motion" else [*known]), [mode]
    stop = known[name] * chance.uniform(0.2, 1.0)
    chosen, free = ["solve", str(SYSTEMS / f"{name}.yaml")], mode == "motion"
    if free and chance.random() < 0.12:
        chosen += ["--method", chance.choice(("DOP853", "LSODA", "Radau", "BDF"))]
        stop, modes = stop / 1000, [*modes, "scipy"]
    elif free and chance.random() < 0.2:
        chosen += ["--method", "ias15"]
        stop, modes = stop / 8, [*modes, "ias15"]
    else:
        if chance.random() < 0.2:
            chosen += ["--precision", "double-double"]
            stop, modes = stop / 80, [*modes, "double-double"]
        if chance.random() < 0.2:
            chosen.append("--portable")
            modes.append("portable")
        if chance.random() < 0.2:
            chosen += ["--tolerance", chance.choice(("1e-8", "1e-12", "1e-16"))]
    start = 0.0
    if chance.random() < 0.2 and name not in DRIVEN:
        start = round(chance.uniform(-5, 5), 3)
        modes.append("start")
    if chance.random() < 0.2 and free and name != DAMPED:  # which backward grows without bound
        stop, modes = -stop, [*modes, "backward"]
    chosen += ["--start", repr(start), f"--stop={start + stop!r}"]
    shorter: tuple[str, ...] = ()
    if chance.random() < 0.6:
        chosen += ["--samples", str(int(10 ** chance.uniform(0.5, 5.6)))]
    else:
        chosen += ["--step", repr(abs(stop) / 10 ** chance.uniform(1, 5))]
        modes.append("step")
        if chance.random() < 0.5:
            shorter = (f"--stop={start + stop * chance.uniform(0.1, 0.9)!r}",)
            modes.append("extended")
    chosen += ["--outputs", random_outputs(chance, name)]
    return Scene((*chosen, *random_checkpoints(chance)), f"{name}.h5", tuple(modes), shorter)


def random_sweep(chance: random.Random) -> Scene:
    """Many motions that take about a second."""
    name = chance.choice(list(SWEPT))
    over, at_random = SWEPT[name]
    sampled, members = chance.random() < 0.5, int(10 ** chance.uniform(0.5, 3.5))
    modes = ["sweep", "sampled" if sampled else "ends"]
    chosen = ["sweep", str(SYSTEMS / f"{name}.yaml"), "--stop", repr(SECOND[name] / members)]
    if chance.random() < 0.6:
        chosen += ["--over", over.format(members)]
    else:
        chosen += ["--random", f"{at_random}=normal(0.5,0.1)", "--members", str(members)]
        modes.append("random")
    if sampled:
        chosen += ["--samples", str(chance.randint(2, 300)), "--outputs", random_outputs(chance, name)]
    if chance.random() < 0.3:
        chosen += ["--jobs", chance.choice(("1", "2"))]
    return Scene((*chosen, *random_checkpoints(chance)), f"{name}_sweep.h5", tuple(modes))


def random_section(chance: random.Random) -> Scene:
    """Crossings that take about a second, of one motion or of many."""
    name = chance.choice(list(CROSSED))
    surface, over, crossings = CROSSED[name]
    modes, most = ["section"], int(crossings * chance.uniform(0.2, 1.0))
    chosen = ["section", str(SYSTEMS / f"{name}.yaml"), *surface]
    if chance.random() < 0.6:
        members = int(10 ** chance.uniform(0.5, 2.5))
        chosen += ["--over", over.format(members)]
        modes, most = [*modes, "section of many"], max(3, most // members)
    chosen += ["--crossings", str(most)]
    if chance.random() < 0.5:
        chosen += ["--outputs", random_outputs(chance, name)]
    return Scene((*chosen, *random_checkpoints(chance)), f"{name}_section.h5", tuple(modes))


def random_outputs(chance: random.Random, name: str) -> str:
    """Some, or all."""
    if chance.random() < 0.3:
        return "all"
    known = [one for one in OUTPUTS if name not in WITHOUT_PARTICLES or one not in PARTICLE_OUTPUTS]
    if name in GUIDED or name in HAPPENING:
        return ",".join(chance.sample(("q", "v", "p", "h", "ledger"), chance.randint(1, 5)))
    return ",".join(chance.sample(known, chance.randint(1, len(known))))


def random_checkpoints(chance: random.Random) -> tuple[str, ...]:
    """How often they are written."""
    if chance.random() < 0.2:
        return ("--checkpoint", "1000", "--checkpoint-count", str(int(10 ** chance.uniform(1, 5))))
    return ("--checkpoint", chance.choice(("0", "0.01", "0.03", "0.05", "0.2")))


@dataclass(frozen=True)
class Kill:
    """One of the times a run was ended: by what, when, and what it left."""

    number: signal.Signals
    after: float
    left: tuple[str, ...]
    whole: bool


def undisturbed(scene: Scene, folder: Path) -> tuple[bytes, float]:
    """What the command writes, and in how many seconds where it need not be compiled."""
    began = time.monotonic()
    run = lagrange_process(*scene.arguments, "--json", cwd=folder)
    seconds = time.monotonic() - began
    assert run.returncode in (0, 4), run.stderr
    took = json.loads(run.stdout)["seconds"]
    seconds -= took["derive"] + took["compile"]
    content = (folder / scene.output).read_bytes()
    (folder / scene.output).unlink()
    return content, seconds


def disturbed(
    scene: Scene,
    folder: Path,
    expected: bytes,
    seconds: float,
    chance: random.Random,
    most: int = MOST,
    signals: tuple[signal.Signals, ...] = KILLS,
) -> Iterator[Kill]:
    """Run the command, each time with ``--resume``, and end it at a random moment, until it comes to its
    end or has been ended so often; then it is left in peace."""
    output, kills, earlier = folder / scene.output, 0, None
    if scene.shorter:
        run = lagrange_process(*scene.arguments, *scene.shorter, cwd=folder)
        assert run.returncode in (0, 4), run.stderr
        earlier = output.read_bytes()
    while True:
        fresh = ["--no-cache"] if chance.random() < 0.05 else []
        command = [sys.executable, "-m", "lagrange_cli", *scene.arguments, "--resume", "--json", *fresh]
        process = subprocess.Popen(
            command, cwd=folder, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        number, after = chance.choice(signals), chance.uniform(0.25, 0.8) * seconds
        try:
            _, err = process.communicate(timeout=after if kills < most else None)
        except subprocess.TimeoutExpired:
            process.send_signal(number)
            _, err = process.communicate(timeout=PATIENCE)
        assert "Traceback" not in err and "report it" not in err, err
        whole = output.exists() and output.read_bytes() != earlier and is_whole(output, expected)
        if process.returncode in (0, 4):
            assert whole, "the output is not that of a run left in peace"
            assert sorted(path.name for path in folder.iterdir()) == [scene.output]
            return
        assert process.returncode in (130, -number), (process.returncode, err)
        kills += 1
        yield Kill(number, after, tuple(sorted(path.name for path in folder.iterdir())), whole)


def is_whole(output: Path, expected: bytes) -> bool:
    """Whether the run has come to its end; raises where what is under its name is neither that nor an
    interrupted one."""
    with h5py.File(output) as file:
        status = file.attrs["status"]
        assert status in ("complete", "interrupted", "failed", "stopped")
        assert file.attrs["message"]
    if status != "interrupted":
        assert output.read_bytes() == expected, "other bytes than those of a run left in peace"
    return bool(status != "interrupted")


def soak(kills: int, seed: int) -> int:
    """End runs so many times, and say how many of the kills were survived; 1 if not all were."""
    done = lost = runs = 0
    modes: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        while done < kills:
            number = seed * 1_000_000 + runs
            chance = random.Random(number)
            scene = random_scene(chance)
            folder = Path(name) / str(runs)
            folder.mkdir()
            print(f"     run {number}: lagrange {shlex.join(scene.arguments)}", flush=True)
            count = 0
            try:
                expected, seconds = undisturbed(scene, folder)
                for kill in disturbed(scene, folder, expected, seconds, chance):
                    count += 1
                    left = ", ".join(kill.left) or "nothing"
                    print(
                        f"{done + count:4} {kill.number.name} after {kill.after:.3f} s leaves {left}",
                        flush=True,
                    )
                for path in folder.iterdir():
                    path.unlink()
            except (AssertionError, OSError, KeyError, subprocess.TimeoutExpired) as error:
                lost += 1
                print(f"     run {number}: LOST: {error!r}", flush=True)
            done, runs = done + count, runs + 1
            modes.update(dict.fromkeys(scene.modes, count))
    print(", ".join(f"{mode} {count}" for mode, count in sorted(modes.items())))
    print(f"{done} kills of {runs} runs; {runs - lost} of them ended with the bytes of one left in peace")
    return int(lost > 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    sys.exit(soak(options.kills, options.seed))
