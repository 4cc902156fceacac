"""A small part of `python -m benchmarks.fuzz_importers`: damaged files are refused in one line or read right."""

import dataclasses
import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument_files import TABLES

FUZZER = Path(__file__).resolve().parents[2] / "benchmarks" / "fuzz_importers.py"


@pytest.fixture(scope="module")
def fuzz_importers():
    spec = importlib.util.spec_from_file_location("fuzz_importers", FUZZER)
    module = sys.modules["fuzz_importers"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", TABLES)
def test_damaged_files_are_refused_or_read_right(fuzz_importers, name, tmp_path):
    found = fuzz_importers.fuzz(name, range(40), tmp_path, apart=False)
    faults = {seed: outcome for seed, outcome in found.items() if outcome.ending in fuzz_importers.FAULTS}
    assert not faults
    assert any(outcome.ending == "refused" for outcome in found.values())


def test_what_is_silently_wrong_is_seen(fuzz_importers, tmp_path):
    """The judge is no rubber stamp: a conjugate, a factor at half of the speeds and a shifted speed are faults."""
    example = fuzz_importers.EXAMPLES["csv_wide"]()
    (tmp_path / example.name).write_bytes(example.content)
    healthy = fuzz_importers.File(path=str(tmp_path / example.name), **example.settings).read()
    half = np.where(np.arange(len(healthy.speed))[:, None] % 2, 2.0, 1.0)
    for values, speed in (
        (healthy.values * half, healthy.speed),
        (np.conj(healthy.values) * half, healthy.speed),
        (healthy.values, healthy.speed * np.linspace(1, 2, len(healthy.speed))),
    ):
        wrong = dataclasses.replace(healthy, values=values, speed=speed)
        assert fuzz_importers.judged(wrong, healthy, fuzz_importers.SAME).ending == "silently wrong"
    assert fuzz_importers.judged(healthy, healthy, fuzz_importers.SAME).ending == "fine"
