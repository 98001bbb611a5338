"""What holds for every test: compiled programs are kept in a folder of the test run's own."""

import os
import shutil
import tempfile


def pytest_configure(config):
    config.cache_of_programs = tempfile.mkdtemp()
    os.environ["LAGRANGE_CACHE_DIR"] = os.path.join(config.cache_of_programs, "cache")
    os.environ.pop("LAGRANGE_NO_CACHE", None)


def pytest_unconfigure(config):
    shutil.rmtree(config.cache_of_programs, ignore_errors=True)
