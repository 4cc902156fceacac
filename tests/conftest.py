"""One BLAS thread per process, set before numpy loads: the cores belong to the processes that the tests run in."""

import compileall
import os
import signal
from pathlib import Path

import pytest

# As bench/__main__.py does for its workers, so that those of this process compute the same to the last digit.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# What commands keep between them is the tests' own, not the user's.
os.environ.setdefault("BENCH_CACHE", str(Path(__file__).parents[1] / ".pytest_cache"))

PACKAGES = ("bench", "hydra_plugins", "ksmea", "measurements", "optimizers", "problems", "surrogates")

collect_ignore = ["helpers/run_ups_by_ross.py"]  # needs the extra `peers`, as tests/test_peer_data.py says


@pytest.fixture
def heeds_sigint():
    """SIGINT interrupts this process and those that it starts, also if a shell started the tests in its background, where it is
    ignored and would be by all of them."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.hookimpl(optionalhook=True)  # of xdist
def pytest_xdist_auto_num_workers():
    """One worker more than cores: tests that wait, for a cluster or a deadline, leave their core to another."""
    from ksmea.numerics.parallel import available_cores  # after the threads of BLAS are set

    return available_cores() + 1


def pytest_sessionstart(session):
    """Compile the project once, not in each of the hundreds of processes that tests start where Python may write no bytecode."""
    if not hasattr(session.config, "workerinput"):
        for package in PACKAGES:
            compileall.compile_dir(Path(__file__).parents[1] / package, quiet=2)


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items):
    """Tests that share a fixture of their module are one worker's: each other worker would make the fixture again."""
    for item in items:
        if item.get_closest_marker("xdist_group") is None and shares_with_its_module(item):
            item.add_marker(pytest.mark.xdist_group(item.location[0]))


def shares_with_its_module(item):
    """Whether a fixture of the test is made once for a module."""
    definitions = item._fixtureinfo.name2fixturedefs.values()  # pytest has no public way to ask
    return any(found[-1].scope == "module" for found in definitions)
