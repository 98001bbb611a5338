"""What holds for every test: one cache of compiled programs, random draws, no deadlines."""

import gc
import importlib
import os
import random
import shutil
import signal
import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from lagrange_cli.cli.progress import Line
from tests.support import compiling, draws

sys.dont_write_bytecode = False
"""pytest rewrites the assertions of the tests, which takes longer than to import all: not in every run."""

# How long an example takes depends on what else the machine does. What a failure is due to is printed.
settings.register_profile(
    "suite", deadline=None, print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)  # fmt: skip
settings.load_profile("suite")


@pytest.fixture(autouse=True)
def no_line_is_left():
    """A line of progress that a test leaves behind would be wiped away amid what another test says."""
    yield
    left, Line.shown = Line.shown, None
    assert left is None, "the test leaves a line of progress on its terminal"


@pytest.fixture
def however_small(monkeypatch):
    """Small systems are families, too."""
    monkeypatch.setattr("lagrange_cli.families.system.FEWEST", 0)
    monkeypatch.setattr("lagrange_cli.families.system.FEWEST_JOINTED", 0)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, which is empty."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def pytest_addoption(parser):
    parser.addoption("--seed", type=int, help="seed of the draw from exhaustive suites [random]")
    parser.addoption("--times", type=float, help="run so many times as many cases of each as usually [all]")


def pytest_configure(config):
    if thorough(config):
        draws.be_thorough()
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as shells have it in the background
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(config, "workerinput"):  # it has the environment of its controller
        config.option.seed = config.workerinput["seed"]
        return
    if config.option.seed is None:
        config.option.seed = random.SystemRandom().randrange(10**9)
    config.cache_of_programs = tempfile.mkdtemp()
    os.environ["LAGRANGE_CACHE_DIR"] = os.path.join(config.cache_of_programs, "cache")
    os.environ.pop("LAGRANGE_NO_CACHE", None)


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node):
    """Workers have the options of the command line; the seed may be one that was drawn since."""
    node.workerinput["seed"] = node.config.option.seed


def pytest_sessionstart(session):
    if not thorough(session.config):
        compiling.begin_quickly()
        compiling.compile_once()
    worker = getattr(session.config, "workerinput", None)
    if worker and session.config.args == session.config.getini("testpaths"):
        import_from_elsewhere(worker)


def import_from_elsewhere(worker):
    """Import the tests, each worker from another place on: what one has compiled, others load.

    It takes six seconds to rewrite the assertions of all tests, and each worker needs them all, while the
    process that started them needs none. One that cannot be imported ends the run.
    """
    root = Path(__file__).parents[1]
    files = sorted(path.relative_to(root) for path in (root / "tests").rglob("test_*.py"))
    begin = int(worker["workerid"].removeprefix("gw")) * len(files) // worker["workercount"]
    for path in files[begin:] + files[:begin]:
        importlib.import_module(".".join(path.with_suffix("").parts))


def pytest_unconfigure(config):
    if not hasattr(config, "workerinput"):
        shutil.rmtree(config.cache_of_programs, ignore_errors=True)


def exhaustive(config):
    return config.option.markexpr == draws.MARKER


def thorough(config):
    """All cases of the exhaustive suites, with more examples, and the code that LLVM makes for users."""
    return exhaustive(config) and config.option.times is None


def pytest_collection_modifyitems(config, items):
    if any("::" in argument for argument in config.args):
        return
    chosen = draws.sampled(items, config.option.seed, exhaustive(config), config.option.times)
    kept = set(chosen)
    config.hook.pytest_deselected(items=[item for item in items if item not in kept])
    items[:] = chosen


def pytest_collection_finish(session):
    """What has been imported and collected stays: it is not looked through for garbage again and again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(200_000)  # as the command has it


def pytest_terminal_summary(terminalreporter, config):
    terminalreporter.write_line(f"cases of the exhaustive suites drawn with --seed {config.option.seed}")
