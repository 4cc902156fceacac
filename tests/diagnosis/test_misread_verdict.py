"""Data that were misread end a diagnosis: the verdict says how, and all values are those of data read so."""

import dataclasses

import numpy as np
import pytest

import ksmea
from ksmea.studies import diagnose as module
from tiers import mostly_slow

SETTINGS = {"sensors": [0.1, 0.2, 0.5], "n_speed": 27}
MIL_PP = 25.4 / 2  # µm


def changed(data, way):
    if way == "Hz":
        return dataclasses.replace(data, speed=data.speed / 60)
    if way == "lag":
        return dataclasses.replace(data, values=np.conj(data.values))
    return dataclasses.replace(data, values=data.values / MIL_PP)


@pytest.mark.parametrize(
    ("way", "said"),
    mostly_slow(
        [
            ("Hz", "speeds are in Hz where rpm are expected"),
            ("lag", "phases are lags where leads are expected"),
            ("mil", "amplitudes are in mil peak to peak where µm 0-peak are expected"),
        ],
        but=["Hz"],
    ),
)
def test_a_misreading_ends_the_search_with_its_cure_and_the_values_of_data_read_so(way, said, monkeypatch):
    """No effect is fitted: read so the model leaves noise, and none could gain more."""
    asked = []
    real = module.diagnose
    monkeypatch.setattr(
        module, "diagnose", lambda case, effects, *words: asked.append(dict(effects)) or real(case, effects, *words)
    )
    rotor = ksmea.load_problem("three_disk", **SETTINGS)
    made = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", noise_known=False, phase_known=True)
    found = ksmea.diagnose(rotor, changed(made.measurement, way), screening=512, starts=3)
    assert found.verdict == "misread" and asked == [{}]
    assert said in found.record.reading and said in str(found)
    held = [row.before.holds(made.truth[row.name]) for row in found.record.coefficients]
    assert len(held) == 5 and sum(held) >= 4  # of five 95 % intervals one may miss
    assert found.record.lack_of_fit.before.p > found.record.lack_of_fit.level
