"""The description of a rotor refuses what cannot be built, in one line that says what to do."""

import pytest

from ksmea.errors import SettingError
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment

STEEL = Material(young_modulus=200e9, density=7800.0, poisson_ratio=0.3)
SEGMENT = ShaftSegment(0.5, 0.02, STEEL, 2)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Material(-1.0, 7800.0, 0.3), "Young's modulus: expected a number above 0"),
        (lambda: Material(2e11, 0.0, 0.3), "density: expected a number above 0"),
        (lambda: Material(2e11, 7800.0, 0.6), "Poisson's ratio"),
        (lambda: ShaftSegment(0.0, 0.02, STEEL), "length of a shaft segment"),
        (lambda: ShaftSegment(0.5, 0.02, STEEL, inner_radius=0.02), "inner < outer"),
        (lambda: ShaftSegment(0.5, 0.02, STEEL, 0), "at least 1, got 0"),
        (lambda: Disk(0.0, 0.0, 1.0, 1.0), "mass of a disk"),
        (lambda: Disk(0.0, 1.0, -1.0, 1.0), "polar inertia"),
        (
            lambda: Disk.from_geometry(0.0, outer_radius=0.1, inner_radius=0.2, thickness=0.1, density=1.0),
            "radii of a disk",
        ),
        (lambda: Bearing(0.0, kxx=float("inf")), "kxx of the bearing at 0 m"),
        (lambda: UnbalancePlane(0.0, -1e-3), "magnitude of an unbalance"),
        (lambda: UnbalancePlane(0.0, 1e-3, float("nan")), "phase of an unbalance"),
        (lambda: Rotor(()), "at least one segment"),
        (
            lambda: Rotor((SEGMENT,), (Disk(0.3, 1.0, 0.1, 0.1),)),
            "disk at 0.3 m: expected a node.*nearest is at 0.25 m",
        ),
        (lambda: Rotor((SEGMENT,), bearings=(Bearing(0.7),)), "bearing at 0.7 m: expected a position on the shaft"),
        (lambda: Rotor((SEGMENT,), unbalance=(UnbalancePlane(-0.1),)), "unbalance at -0.1 m"),
    ],
)
def test_bad_description(make, message):
    with pytest.raises(SettingError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_node_positions_run_over_all_segments():
    rotor = Rotor((SEGMENT, ShaftSegment(0.3, 0.01, STEEL, 3)))
    assert rotor.node_positions == pytest.approx([0, 0.25, 0.5, 0.6, 0.7, 0.8])
    assert rotor.node_at(0.6, "disk") == 3
