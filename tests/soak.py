"""Kills runs at random times and resumes them: ``python -m tests.soak [--kills 200] [--seed 1]``.

Each run is killed and resumed until it completes. After every kill there must be no output, or a whole file
of a complete or interrupted run. The last one must have the same bytes as that of an uninterrupted run.
"""

from __future__ import annotations

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py

from tests.cli.command import ENVIRONMENT, SYSTEMS, lagrange

KILLS = (signal.SIGKILL,) * 9 + (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Most of them the process cannot handle."""
OFTEN = ("--checkpoint", "0.03")


@dataclass(frozen=True)
class Scene:
    """A command, and the name of what it writes."""

    arguments: tuple[str, ...]
    output: str


SCENES = {
    "samples": Scene(
        ("solve", str(SYSTEMS / "double_pendulum.yaml"), "--stop", "40000", "--samples", "400001", *OFTEN),
        "double_pendulum.h5",
    ),
    "steps": Scene(
        ("solve", str(SYSTEMS / "double_pendulum.yaml"), "--stop", "40000", "--samples", "11", *OFTEN),
        "double_pendulum.h5",
    ),
    "ledger": Scene(
        ("solve", str(SYSTEMS / "driven_damped_pendulum.yaml"), "--stop", "100000", "--step", "0.5",
         "--outputs", "q,ledger,action,positions", *OFTEN),
        "driven_damped_pendulum.h5",
    ),
    "members": Scene(
        ("sweep", str(SYSTEMS / "double_pendulum.yaml"), "--over", "theta1=0:2:999", "--stop", "100", *OFTEN),
        "double_pendulum_sweep.h5",
    ),
    "trajectories": Scene(
        ("sweep", str(SYSTEMS / "driven_damped_pendulum.yaml"), "--random", "theta=normal(0,1)", "--members",
         "3000", "--stop", "400", "--outputs", "q,v,h", "--samples", "201", *OFTEN),
        "driven_damped_pendulum_sweep.h5",
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Kill:
    """One of the times a run was ended: by what, when, and what it left."""

    number: signal.Signals
    after: float
    left: tuple[str, ...]
    whole: bool


def undisturbed(scene: Scene, folder: Path) -> tuple[bytes, float]:
    """What the command writes, and in how many seconds."""
    lagrange(*scene.arguments, cwd=folder)  # compiled by now
    (folder / scene.output).unlink()
    began = time.monotonic()
    run = lagrange(*scene.arguments, cwd=folder)
    assert (run.returncode, run.stderr) == (0, ""), run.stderr
    content = (folder / scene.output).read_bytes()
    (folder / scene.output).unlink()
    return content, time.monotonic() - began


def disturbed(
    scene: Scene, folder: Path, expected: bytes, seconds: float, chance: random.Random
) -> Iterator[Kill]:
    """Run the command, each time with ``--resume``, and end it at a random moment, until it comes to its
    end."""
    output = folder / scene.output
    command = [sys.executable, "-m", "lagrange_cli", *scene.arguments, "--resume", "--json"]
    while True:
        process = subprocess.Popen(
            command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        number, after = chance.choice(KILLS), chance.uniform(0.3, 1.0) * seconds
        try:
            _, err = process.communicate(timeout=after)
        except subprocess.TimeoutExpired:
            process.send_signal(number)
            _, err = process.communicate(timeout=60)
        assert "Traceback" not in err and "report it" not in err, err
        whole = output.exists() and is_whole(output, expected)
        if process.returncode == 0:
            assert whole and sorted(path.name for path in folder.iterdir()) == [scene.output]
            return
        assert process.returncode in (130, -number), (process.returncode, err)
        yield Kill(number, after, tuple(sorted(path.name for path in folder.iterdir())), whole)


def is_whole(output: Path, expected: bytes) -> bool:
    """Whether the run is complete; raises where what is under its name is neither that nor an interrupted
    one."""
    with h5py.File(output) as file:
        status = file.attrs["status"]
        assert status in ("complete", "interrupted")
        assert file.attrs["message"]
    if status == "complete":
        assert output.read_bytes() == expected
    return bool(status == "complete")


def soak(kills: int, seed: int) -> int:
    """End runs so many times, and say how many of the kills were survived; 1 if not all were."""
    chance, done, lost, runs = random.Random(seed), 0, 0, 0
    with tempfile.TemporaryDirectory() as name:
        expected = {key: undisturbed(scene, Path(name)) for key, scene in SCENES.items()}
        while done < kills:
            key = list(SCENES)[runs % len(SCENES)]
            folder = Path(name) / str(runs)
            folder.mkdir()
            try:
                for kill in disturbed(SCENES[key], folder, *expected[key], chance):
                    done += 1
                    left = ", ".join(kill.left) or "nothing"
                    what = f"{kill.number.name} after {kill.after:.3f} s leaves {left}"
                    print(f"{done:4} {key}: {what}", flush=True)
            except (AssertionError, OSError, KeyError) as error:
                lost += 1
                print(f"     {key}: lost: {error!r}", flush=True)
            runs += 1
    print(
        f"{done - lost} kills survived of {done}; "
        f"{runs - lost} of {runs} runs ended with the bytes of one left in peace"
    )
    return int(lost > 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.soak", description=__doc__.partition("\n\n")[2])
    parser.add_argument("--kills", type=int, default=200, help="number of kills [200]")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random numbers [1]")
    options = parser.parse_args()
    sys.exit(soak(options.kills, options.seed))
