"""The three-disk problem: its settings, its data, and probes between nodes."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from problems.rotor.finite_elements.mesh import share_elements
from problems.three_disk import SEGMENT_LENGTHS, ThreeDisk


def counts(problem):
    return tuple(segment.n_element for segment in problem.rotor.segments)


@pytest.mark.parametrize(
    ("mesh", "expected"), [(4, (1, 1, 1, 1)), (13, (2, 3, 5, 3)), (21, (3, 5, 8, 5)), (26, (4, 6, 10, 6))]
)
def test_elements_are_shared_by_length(mesh, expected):
    assert counts(ThreeDisk(mesh=mesh).build()) == expected


@pytest.mark.parametrize("mesh", range(4, 60))
def test_every_mesh_has_its_count_and_no_empty_segment(mesh):
    shares = share_elements(mesh, SEGMENT_LENGTHS)
    assert sum(shares) == mesh
    assert min(shares) >= 1


def test_short_segments_take_from_long_ones():
    assert share_elements(4, [0.01, 0.01, 10.0]) == (1, 1, 2)


def test_disks_have_the_published_masses():
    # By the density and the rings of Table 1, as every program that is given them finds: three decimals.
    masses = [disk.mass for disk in ThreeDisk().build().rotor.disks]
    assert masses == pytest.approx([14.580, 45.946, 55.135], abs=5e-4)
    thin = ThreeDisk().build().rotor.disks[1]
    assert thin.polar_inertia == pytest.approx(thin.mass * (0.2**2 + 0.05**2) / 2)
    assert thin.diametral_inertia == pytest.approx(thin.polar_inertia / 2 + thin.mass * 0.05**2 / 12)


def test_reference_is_table_1_inside_the_bounds_and_not_in_the_problem():
    settings = ThreeDisk()
    problem, reference = settings.build(), settings.reference()
    assert tuple(reference) == problem.parameters.names
    assert problem.parameters.in_units([reference[name] for name in reference]) == pytest.approx(
        [50, 70, 0.5, 0.7, 200]
    )
    x = np.array(list(reference.values()))
    assert np.all((problem.parameters.lower < x) & (x < problem.parameters.upper))


@pytest.mark.parametrize(("reading", "unit"), [("rad_s", 1.0), ("rpm", 2 * np.pi / 60)])
def test_reading_of_the_band(reading, unit):
    speed = ThreeDisk(reading=reading).build().speed
    assert len(speed) == 53
    assert speed[[0, -1]] == pytest.approx([200 * unit, 1500 * unit])
    assert np.allclose(np.diff(speed), 25 * unit)


def test_channels_are_probes_times_directions():
    channels = ThreeDisk(sensors=[0.1, 0.6], directions=["y"]).build().channels
    assert [str(channel) for channel in channels] == ["y at 0.1 m", "y at 0.6 m"]


def test_partial_bounds_keep_the_other_defaults():
    parameters = ThreeDisk(limits={"kxx": [30, 80]}).build().parameters
    assert parameters.lower == pytest.approx([30e6, 10e6, 10, 10, 5e-5])
    assert parameters.upper == pytest.approx([80e6, 100e6, 1000, 1000, 5e-4])


def test_probe_between_nodes_of_the_finer_mesh():
    # z = 0.1 m is a node of 13 elements and lies inside an element of 21. Static deflections are exact on any mesh;
    # below half the first critical speed inertia adds a part of (1500/3620)² with the mesh's error of some 1e-5.
    x = np.array(list(ThreeDisk().reference().values()))
    on_node, between = (ThreeDisk(mesh=mesh, reading="rpm", speed_from=200, speed_to=1500).build() for mesh in (13, 21))
    assert np.any(np.isclose(on_node.rotor.node_positions, 0.1))
    assert not np.any(np.isclose(between.rotor.node_positions, 0.1))
    assert between.response(x[None]) == pytest.approx(on_node.response(x[None]), rel=1e-5)


def test_refinement_converges_at_a_probe_between_nodes():
    x = np.array(list(ThreeDisk().reference().values()))[None]
    speeds = {"reading": "rpm", "speed_from": 200, "speed_to": 1500, "n_speed": 5}
    finest = ThreeDisk(mesh=104, sensors=[0.15], **speeds).build().response(x)
    errors = [
        np.abs(ThreeDisk(mesh=mesh, sensors=[0.15], **speeds).build().response(x) - finest).max() for mesh in (13, 26)
    ]
    # Order 2 or better, see problems.rotor.finite_elements.shaft.
    assert errors[1] < errors[0] / 3.5


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mesh": 3}, "at least 4 elements, got 3; disks need a node"),
        ({"reading": "hz"}, "unknown value for reading"),
        ({"speed_from": 0}, "above 0"),
        ({"speed_from": 1500, "speed_to": 200}, "more than speed_from"),
        ({"n_speed": 0}, "at least 1"),
        ({"sensors": [1.4]}, "at most 1.3"),
        ({"sensors": []}, "at least one entry"),
        ({"sensors": [0.1, 0.1]}, "none twice"),
        ({"directions": ["z"]}, "expected x, y or degrees from x towards y, got 'z'"),
        ({"directions": []}, "at least one entry"),
        ({"limits": {"kx": [1, 2]}}, "did you mean 'kxx'"),
        ({"limits": {"kxx": [1]}}, r"expected \[lower, upper\] in MN/m"),
        ({"limits": {"kxx": [100, 10]}}, r"\[100, 10\] MN/m"),
        ({"limits": {"u": [float("nan"), 10]}}, "expected lower < upper"),
    ],
)
def test_bad_settings(changes, message):
    with pytest.raises(SettingError, match=message) as caught:
        ThreeDisk(**changes)
    assert "\n" not in str(caught.value)
