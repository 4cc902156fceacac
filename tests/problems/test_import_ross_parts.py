"""Parts of ROSS models: tables by version, supports, layers, couplings, options, and what is refused by name."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from problems.rotor_import.axes import in_own_axes
from problems.rotor_import.model import ImportedRotor, mass_of
from problems.rotor_import.ross import read_ross
from problems.rotor_import.ross_shaft import hutchinson_of_ross
from problems.rotor_import.yaml_text import Wanted, rotor_yaml
from ross_models import SPEEDS, bearing, element, model, saved, table

PARTS = {"kxx": 1.0, "kxy": 2.0, "kyx": 3.0, "kyy": 4.0}


@pytest.fixture
def read(tmp_path):
    def of(version="2.3.0", **sections):
        return read_ross(saved(tmp_path, model(version, **sections)))

    return of


@pytest.mark.parametrize(
    ("version", "axis"),
    [("1", "frequency"), ("1", "w"), ("2.3.0", "frequency"), ("3.1.0", "speed"), ("3.1.0", "frequency")],
)
def test_tables_of_all_versions_are_over_the_speed_of_rotation(read, version, axis):
    """A file of 2.x has speeds under `frequency`, which ROSS 3 takes for whirl; at 1X both are the speed of rotation."""
    axes = {"frequency": None, axis: SPEEDS}
    rotor = read(version, **{"BearingElement__Bearing 4": table(4, **axes)})
    assert rotor.bearings[1]["table"]["speed"] == SPEEDS
    assert rotor.bearings[1]["table"]["kxx"] == [1e7, 1.2e7, 1.9e7, 3.5e7]
    is_whirl = any("frequency of whirl" in each for each in rotor.remarks)
    assert is_whirl == (version == "3.1.0" and axis == "frequency")


def test_the_axis_of_a_file_of_2_is_not_mistaken(tmp_path):
    """ROSS 3 loads a file of 2.x and reads it on the wrong axis: kxx at speed 800, whirl 100 rad/s, is then that of 100."""
    rotor = read_ross(saved(tmp_path, model("2.3.0")))
    rows = dict(zip(rotor.bearings[1]["table"]["speed"], rotor.bearings[1]["table"]["kxx"], strict=True))
    assert rows[800.0] == 3.5e7


def test_tables_over_speed_and_whirl_are_taken_where_both_are_alike(read):
    speed, whirl = [100.0, 400.0, 800.0], [50.0, 400.0, 600.0]
    values = [[1e7 + 1e4 * a + 2e3 * b for b in whirl] for a in speed]  # a plane, which straight lines meet exactly
    rotor = read(
        "3.1.0", **{"BearingElement__Bearing 4": bearing(4, speed=speed, frequency=whirl, kxx=values, kyy=values)}
    )
    own = rotor.bearings[1]["table"]
    assert own["speed"] == [100.0, 400.0, 600.0]
    assert own["kxx"] == pytest.approx([1e7 + 1.2e4 * point for point in own["speed"]], rel=1e-14)
    assert own["cxx"] == [1e3] * 3


def test_magnetic_bearings_are_read_as_their_table(read):
    rotor = read(BearingElement__amb=table(3, g0=5e-4, kp_pid=1500.0, kxy=[1e-9] * 4, tag="amb"))
    assert "kxy" not in rotor.bearings[1]["table"]  # rounding beside 1e7
    assert any("amb: a magnetic bearing" in each for each in rotor.remarks)


def test_rolling_bearings_and_seals_are_read_as_their_coefficients(read):
    rotor = read(
        BallBearingElement__b=bearing(1, n_balls=9),
        RollerBearingElement__r=bearing(2),
        SealElement__s=bearing(3, mxx=[1.5]),
    )
    assert [each["position"] for each in rotor.bearings] == pytest.approx([0.0, 0.1, 0.2, 0.4])
    assert rotor.seals == [
        {"position": 0.3, "kxx": 1e7, "kyy": 2e7, "cxx": 1e3, "cyy": 2e3, "mxx": 1.5, "name": "Bearing 3"}
    ]


def test_supports_stand_beyond_the_shaft(read):
    rotor = read(
        **{
            "BearingElement__Bearing 0": bearing(0, n_link=5),
            "BearingElement__pedestal": bearing(5, kxx=[9e7], mxx=[2.0]),
        },
        PointMass__one={"n": 5, "m": 24.0},
        PointMass__two={"n": 5, "mx": 1.0, "my": 3.0},
    )
    support = rotor.bearings[0]["support"]
    assert support == {"kxx": 9e7, "kyy": 2e7, "cxx": 1e3, "cyy": 2e3, "mxx": 27.0, "myy": 27.0}


def test_a_support_as_a_table_becomes_a_dynamic_stiffness(read):
    rotor = read(**{"BearingElement__Bearing 0": bearing(0, n_link=5), "BearingElement__pedestal": table(5, mxx=[2.0])})
    own = rotor.bearings[0]["support"]["table"]
    assert own["frequency"] == SPEEDS
    omega = np.array(SPEEDS)
    assert own["re_zxx"] == pytest.approx(np.array([1e7, 1.2e7, 1.9e7, 3.5e7]) - 2 * omega**2)
    assert own["im_zxx"] == pytest.approx(omega * [9e3, 7e3, 5e3, 4e3])


def test_point_masses_on_the_shaft(read):
    rotor = read(PointMass__even={"n": 1, "m": 2.0}, PointMass__odd={"n": 3, "mx": 1.0, "my": 3.0})
    assert rotor.masses == [{"position": 0.1, "mass": 2.0}]
    assert rotor.seals == [{"position": pytest.approx(0.3), "mxx": 1.0, "myy": 3.0, "name": "odd"}]


def test_sections_may_stand_in_any_order_and_layers_add(read):
    sleeve = {
        **element(2, odl=0.09, odr=0.08, idl=0.05, idr=0.05),
        "material": {"name": "steel", "rho": 8000.0, "E": 6895.0, "G_s": 6895.0},
    }
    rotor = read(
        **{"ShaftElement__Shaft Element 0": None, "ShaftElement__sleeve": sleeve, "ShaftElement__last": element(0)}
    )
    plain, layered, after = rotor.shaft
    assert (plain["elements"], after["elements"]) == (2, 1)
    assert layered["layers"] == [
        {"outer_diameter": 0.09, "inner_diameter": 0.05, "outer_diameter_right": 0.08, "material": "steel_2"}
    ]
    assert rotor.materials["steel_2"] == {"young_modulus": 6895.0, "density": 8000.0, "poisson_ratio": -0.5}


def test_equal_cones_stay_apart_and_equal_cylinders_are_one_entry(read):
    """Two equal cones in a row are a sawtooth, and so are two equal conical layers."""
    cones = {f"ShaftElement__Shaft Element {n}": element(n, odr=0.06) for n in (0, 1)}
    sleeves = {f"ShaftElement__sleeve {n}": element(n, odl=0.09, odr=0.08, idl=0.05, idr=0.05) for n in (2, 3)}
    assert [each["elements"] for each in read(**cones, **sleeves).shaft] == [1, 1, 1, 1]
    assert [(each["elements"], each["length"]) for each in read().shaft] == [(4, pytest.approx(0.4))]


def test_limits_of_the_unbalance_follow_from_the_mass(read):
    """Ten times G 40 at the highest speed, of all that turns: a drum has no disk."""
    rotor = read(**{"DiskElement__Disk 0": None})
    mass = 7840 * np.pi / 4 * 0.05**2 * 0.4
    assert mass_of(rotor) == pytest.approx(mass)
    text = rotor_yaml(rotor, Wanted(unbalance=[0.2], speeds=(100.0, 3000.0, 10)))
    assert f"upper: {float(f'{10 * 0.04 / (100 * np.pi) * mass * 1e6:.2g}'):g}," in text.partition("name: u1")[2]


def test_switches_coefficients_damping_and_forces_of_elements(read):
    changed = element(
        1,
        shear_method_calc="hutchinson",
        rotary_inertia=False,
        gyroscopic=False,
        axial_force=2e4,
        alpha=3.0,
        beta=2e-6,
        torque=150.0,
    )
    rotor = read(
        **{"ShaftElement__Shaft Element 1": changed, "ShaftElement__Shaft Element 2": element(2, shear_effects=False)}
    )
    own = rotor.shaft[1]
    assert own["shear_coefficient"] == pytest.approx(hutchinson_of_ross(0.29, 0.0))
    assert (own["rotary_inertia"], own["gyroscopic"], own["axial_force"]) == (False, False, 2e4)
    assert own["standing_damping"] == {"mass": 3.0, "stiffness": 2e-6}
    assert rotor.shaft[2]["theory"] == "euler_bernoulli"
    buckling = 2 * np.pi * 2.08e11 * np.pi / 64 * 0.05**4 / 0.4
    (left_out,) = rotor.left_out
    assert f"{100 * 150 / buckling:.2g} % of the buckling torque" in left_out


def test_a_coupling_is_a_segment_and_a_place(read):
    coupling = {
        "n": 4,
        "L": 0.2,
        "o_d": 0.08,
        "kt_x": 1e6,
        "kt_y": 2e6,
        "kt_z": 5.0,
        "kr_x": 1e4,
        "kr_y": 2e4,
        "m_l": 3.0,
        "Ip_r": 0.1,
        "tag": "flex",
    }
    rotor = read(CouplingElement__flex=coupling, **{"ShaftElement__Shaft Element 5": element(5)})
    assert rotor.shaft[1]["coupling"] == {
        "stiffness": [1e6, 2e6], "angular_stiffness": [1e4, 2e4], "masses": [3.0, 0.0], "polar_inertias": [0.0, 0.1],
    }  # fmt: skip
    assert rotor.couplings == [{"position": pytest.approx(0.5)}]
    assert rotor.left_out == ["axial and torsional stiffness of flex"]


def test_damping_of_the_whole_rotor_reaches_disks_and_lumped_masses(read):
    rotor = read(
        "3.1.0",
        parameters={"alpha": 6.0, "beta": 4e-6, "default_damping_ratio": 0.01},
        PointMass__m={"n": 1, "m": 2.0},
        DiskElement__inertia={"n": 3, "m": 0.0, "Id": 0.1, "Ip": 0.2},
    )
    assert [each["standing_damping"] for each in rotor.disks] == [6.0, 6.0] and len(rotor.masses) == 1
    assert all(each["standing_damping"] == {"mass": 6.0, "stiffness": 4e-6} for each in rotor.shaft)
    assert "default_damping_ratio 0.01" in rotor.left_out[0]


@pytest.mark.parametrize(("version", "said"), [("2.3.0", "a smoothing cubic spline"), ("3.1.0", "straight lines")])
def test_the_distance_to_the_interpolation_of_ross_is_said(read, version, said):
    axis = {"frequency" if version < "3" else "speed": SPEEDS}
    rotor = read(
        version, **{"BearingElement__Bearing 4": table(4, **{"frequency": None, **axis}, interpolation="linear")}
    )
    (remark,) = rotor.remarks
    assert said in remark and "%" in remark


def test_masses_that_ross_2_smooths_away_are_said(read):
    """ROSS 2 misses points by as much as 1 kg each: of masses of 2 kg it reads others, where PCHIP goes through the points."""
    speed, masses = np.linspace(100, 800, 8).tolist(), [2.0, 2.4, 1.9, 2.5, 2.0, 2.6, 1.8, 2.4]
    rotor = read(**{"BearingElement__Bearing 4": bearing(4, frequency=speed, mxx=masses)})
    (remark,) = rotor.remarks
    assert "of the largest mxx" in remark and float(remark.partition(" %")[0].split()[-1]) > 10
    assert rotor.bearings[1]["table"]["mxx"] == masses


def test_axes_along_the_load_are_turned_a_quarter_turn():
    """q' = R q with x' down and y' = x: K = Rᵀ K' R."""
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    entry = {
        "position": 0.0,
        **PARTS,
        "table": {"speed": [1.0], **{name: [value] for name, value in PARTS.items()}},
        "support": dict(PARTS),
    }
    (own,) = in_own_axes(ImportedRotor("x", bearings=[entry]), "load").bearings
    expected = turn.T @ np.array(list(PARTS.values())).reshape(2, 2) @ turn
    for found in (own, own["support"], {name: values[0] for name, values in own["table"].items()}):
        assert [found[name] for name in PARTS] == expected.ravel().tolist()


NO_MATERIAL = {key: value for key, value in element(1).items() if key != "material"}
REFUSED = [
    ({"GearElement__gear": {"n": 1}}, "got GearElement_gear (gears: several shafts and torsion)"),
    ({"ShaftElement__Shaft Element 1": element(1, L=-0.1)}, "ShaftElement_Shaft Element 1.L: expected a number above 0 (m), got -0.1"),
    ({"ShaftElement__Shaft Element 1": NO_MATERIAL}, "material: expected a mapping"),
    ({"ShaftElement__Shaft Element 1": element(1, n=7)}, "expected shaft elements one after the other, got none at node 1"),
    ({"ShaftElement__Shaft Element 1": element(1, n="1")}, "n: expected a node, a whole number from 0 on, got '1'"),
    ({"ShaftElement__Shaft Element 1": element(1, shear_effects="no")}, "shear_effects: expected true or false, got 'no'"),
    ({"ShaftElement__Shaft Element 1": element(1, shear_method_calc="x")}, "expected cowper or hutchinson, got 'x'"),
    ({"ShaftElement__Shaft Element 1": element(1, odl=10**400)}, "odl: expected a number above 0 (m)"),
    ({"ShaftElement__sleeve": element(1, L=0.2)}, "expected layers of one length at node 1, got 0.1 and 0.2 m"),
    ({"ShaftElement__sleeve": element(1, idl=0.05, odl=0.06, alpha=1.0)}, "expected standing_damping to be alike in all layers at node 1"),
    ({"BearingElement__b": bearing(9)}, None),
    ({"BearingElement__b": bearing(1, n_link=9)}, "n_link: expected a bearing element from node 9 to the ground, got none"),
    ({"BearingElement__b": bearing(1, n_link=3)}, "n_link: expected a support beyond the shaft, got node 3 of the shaft itself"),
    ({"BearingElement__b": bearing(9, n_link=8)}, "expected a support on the ground, got one on node 8"),
    (
        {"BearingElement__a": bearing(1, n_link=9), "BearingElement__b": bearing(2, n_link=9), "BearingElement__c": bearing(9)},
        "n_link: expected a support of its own, got node 9, which carries Bearing 1",
    ),
    ({"BearingElement__b": bearing(1, kxx=[1.0, 2.0])}, "frequency: expected the speeds of its table, got none"),
    ({"BearingElement__b": table(1, kxx=[1.0, 2.0])}, "kxx: expected 4 numbers, one for each speed, got 2"),
    ({"BearingElement__b": table(1, kxx=["a"] * 4)}, "kxx: expected numbers, got a list"),
    ({"BearingElement__b": table(1, frequency=["a"] * 4)}, "frequency: expected numbers, got a list"),
    ({"BearingElement__b": bearing(1, kxx=[float("nan")])}, "kxx: expected numbers, got a list"),
    ({"BearingElement__b": bearing(1, kxx=[[1.0], [1.0, 2.0]])}, "kxx: expected numbers, got a list"),
    ({"PointMass__p": {"n": 9, "m": 1.0}}, "expected a node of the shaft or of a support, got 9"),
    ({"DiskElement__d": {"n": 9, "m": 1.0, "Id": 0.0, "Ip": 0.0}}, "expected a node of the shaft, up to 4, got 9"),
    ({"parameters": [1]}, "parameters: expected a section, got a list"),
]  # fmt: skip


@pytest.mark.parametrize(("sections", "said"), REFUSED)
def test_what_cannot_be_read_is_refused_by_name(read, sections, said):
    if said is None:
        assert read(**sections).left_out == ["support at node 9: no bearing stands on it"]
        return
    with pytest.raises(SettingError) as caught:
        read(**sections)
    assert said in str(caught.value) and "model.json" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"[a", b"{", b"\xff\xfe", b"a = 1", b"[]", b'{"a": ' * 5000])
def test_other_files_are_refused_in_one_line(tmp_path, content):
    path = tmp_path / "model.toml"
    path.write_bytes(content)
    with pytest.raises(SettingError, match="expected a model that ROSS has saved") as caught:
        read_ross(str(path))
    assert "\n" not in str(caught.value)
