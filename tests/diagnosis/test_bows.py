"""A bent shaft is found whatever its shape, and the unbalance is reported over the shapes that fit as well."""

import os
from pathlib import Path

import numpy as np
import pytest

import ksmea
from bench import main
from ksmea.fits.linear_start import solved_start
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from tests.diagnosis.conftest import FEW_STARTS
from tolerant_pump import pump, true_values

CASES = Path(os.environ.get("KSMEA_DATA", Path(__file__).resolve().parents[3] / "shared" / "data")).parent / "cases"
PROBES = ("1YD@0.16", "1XD@0.16", "2YD@1.04", "2XD@1.04")


def test_a_bent_overhung_rotor_of_another_program_is_named_with_its_unbalance(tmp_path, monkeypatch):
    """25 µm at 110° before the phase origin of −73°, half a sine between the bearings; u2 60 g mm at 140°."""
    if not (CASES / "overhung").exists():
        pytest.skip(f"no cases at {CASES}; KSMEA_DATA names the directory of public data beside them")
    monkeypatch.chdir(tmp_path)
    words = [word for probe in PROBES for word in ("--probe", probe)]
    raw = str(CASES / "overhung" / "bow.csv")
    assert main.run(["import", raw, "--format", "system1", *words, "--rotation", "ccw", "--out", "run.csv"]) == 0
    rotor = ksmea.load_problem(str(CASES / "overhung" / "my_rotor.yaml"))
    effects = ["residual_bow", "coupling_misalignment", "runout", "unbalance"]
    found = ksmea.diagnose(rotor, ksmea.read_measurement("run.csv"), effects=effects, **FEW_STARTS)
    record = found.record
    assert record.verdict == "ambiguous" and set(record.ambiguity_group) == {"residual_bow", "runout"}
    averaged = {each.name: each for each in record.averaged.coefficients}
    for name, true in (("u1", 150), ("u2", 60), ("kxx", 9), ("kyy", 16), ("cxx", 8), ("cyy", 11)):
        assert averaged[name].low < true < averaged[name].high
    assert averaged["u2"].high - averaged["u2"].low > 10  # g mm: the shapes disagree by more than noise says
    sine = next(each for each in record.ranking if each.location == "half sine between the bearings")
    assert np.hypot(*(each.value for each in sine.parameters)) == pytest.approx(25, abs=0.5)
    assert any(remark.startswith("residual_bow: the shape of the bend decides") for remark in record.remarks)


def test_vectors_that_enter_linearly_are_solved_for(tmp_path):
    """From any unbalance, phase and bow the truth follows in one step, where bearings are true."""
    bow = registry.create("effect", "residual_bow", {"shapes": ["force at 0.85"]})
    settings = pump(tmp_path)
    problem = bow.added_to(settings.build().with_phase_origin())
    truth = np.array([*true_values(settings), 0.7, 2e-5, -3e-5])
    [response] = problem.response(truth[None])
    data = Measurement(problem.speed, problem.channels, response, Noise(0.05, 0.0), "made for a test")
    start = truth + np.array([0, 0, 0, 1e-4, -2.5, 4e-5, 5e-5])
    u = solved_start(Case(problem, data), problem.parameters.to_cube(start), 5, data.noise)
    # sensitivities are differenced: 1e-6
    assert problem.parameters.to_si(u) == pytest.approx(truth, rel=1e-4)
