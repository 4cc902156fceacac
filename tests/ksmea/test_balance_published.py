"""Published balancing jobs, second-hand transcriptions of trial-weight vectors: the answers that their authors print."""

import json
import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import ksmea
from balancing_cases import campaign, corrections, polar
from ksmea.balancing.correction import least_squares

DATA = Path(os.environ.get("KSMEA_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
CASES = DATA / "balancing" / "cases.json"
pytestmark = pytest.mark.skipif(
    not CASES.exists(), reason=f"no cases at {CASES}; KSMEA_DATA names the directory of public data"
)


@cache
def case(name):
    return json.loads(CASES.read_text())[name]


def vectors(values):
    return np.array([vectors(each) if isinstance(each, list) else polar(each) for each in values])


def job(found, kept):
    """The runs of a two-plane job; `kept`: the first trial weight stays on in the second run."""
    bare, trials, weights = vectors(found["A"]), vectors(found["B"]), vectors(found["U"])
    one, two = {1.0: weights[0]}, {2.0: weights[1]}
    runs = [("bare", {}, bare), ("one", one, trials[:, 0]), ("two", one | two if kept else two, trials[:, 1])]
    return campaign([(name, on, values[None]) for name, on, values in runs], [1000.0])


@pytest.mark.parametrize(
    "name, kept, expected",
    [
        # the paper's aft weight is that of trial weights that stay on; the transcription has the other one
        ("feese_grazier_2004_two_plane", True, ["15.3@3", "6.6@113"]),
        ("feese_grazier_2004_two_plane", False, ["5.4@-137", "6.6@113"]),
        ("bk_two_plane", False, ["1.96@-122", "1.06@121"]),
    ],
)
def test_two_plane_jobs(name, kept, expected):
    """To the digits printed, 0.05 and half a degree of 15; the second job's trial vector is transcribed as 185, 186 and
    189, which is worth 2 % and 2°."""
    found = corrections(ksmea.balance(job(case(name), kept)))
    np.testing.assert_allclose(np.abs(found), np.abs(vectors(expected)), rtol=0.02)
    assert np.max(np.abs(np.angle(found / vectors(expected), deg=True))) < 2.0


def test_printed_influence_coefficients_of_four_sensors():
    """Kelm & Pavelek's, printed with two digits: answers to 3 % and 2°; the second angle as recomputed by the transcriber."""
    found = case("kelm_pavelek_2016")
    weights = least_squares(np.vstack([vectors(found["A"]), vectors(found["alpha"]).T]))
    expected = vectors(["17.5@230", "30.3@-9"])
    np.testing.assert_allclose(np.abs(weights), np.abs(expected), rtol=0.03)
    assert np.max(np.abs(np.angle(weights / expected, deg=True))) < 2.0


def test_least_squares_beside_a_published_minimum_of_the_largest():
    """Foiles minimises the largest of eleven readings: least squares leave a smaller sum of squares and a larger largest."""
    found = case("foiles_2000")
    bare, alpha = vectors(found["A"]), vectors(found["alpha"])
    own, published = least_squares(np.vstack([bare, alpha.T])), vectors(found["published_correction_minmax"])
    left, theirs = np.abs(bare + alpha @ own), np.abs(bare + alpha @ published)
    assert np.linalg.norm(left) < np.linalg.norm(theirs) < np.linalg.norm(bare)
    assert theirs.max() < left.max() < np.abs(bare).max()


def test_an_entry_that_does_not_fit_its_neighbours_is_found():
    """Jeong's table at 19 000 rpm has one vector twice: 0.0192@178.2, where its neighbours have 0.45 and 0.77."""
    found = case("jeong_2016_turbo_blower")
    bare, trials, weights = vectors(found["A"]), vectors(found["B"]), vectors(found["trial"])
    runs = [
        ("bare", {}, bare),
        ("one", {1.0: weights[0]}, trials[:, :, 0]),
        ("two", {2.0: weights[1]}, trials[:, :, 1]),
    ]
    record = ksmea.balance(campaign(runs, found["speeds_rpm"])).record
    [misfit] = record.entry_misfits
    assert (misfit.run, misfit.entry.channel) == ("two", "x at 0.1 m")
    assert misfit.entry.speed * 30 / np.pi == pytest.approx(19_000)
    assert 0.45 < misfit.expected.size < 0.77 and misfit.measured.size == pytest.approx(0.0192)
