"""Models as ROSS saves them, of a shaft of four elements.

Written for the tests, after the layout of its files.
"""

import copy
import json

STEEL = {"name": "steel", "rho": 7840.0, "E": 2.08e11, "G_s": 2.08e11 / 2.58, "color": "#525252"}
SPEEDS = [100.0, 200.0, 400.0, 800.0]  # rad/s


def element(node, **changed):
    own = {
        "L": 0.1, "idl": 0.0, "odl": 0.05, "idr": 0.0, "odr": 0.05, "n": node, "axial_force": 0, "torque": 0, "shear_effects": True,
        "rotary_inertia": True, "gyroscopic": True, "shear_method_calc": "cowper", "tag": f"Shaft Element {node}", "alpha": 0.0, "beta": 0.0,
        "material": dict(STEEL),
    }  # fmt: skip
    return {**own, **changed}


def bearing(node, tag="", **changed):
    zero = {f"{kind}{entry}": [0] for kind in "kcm" for entry in ("xx", "xy", "yx", "yy", "zz")}
    own = {
        "kxx": [1e7],
        "kyy": [2e7],
        "cxx": [1e3],
        "cyy": [2e3],
        "n": node,
        "tag": tag or f"Bearing {node}",
        "scale_factor": 1,
    }
    return {**zero, **own, **changed}


def table(node, **changed):
    rows = {
        "kxx": [1e7, 1.2e7, 1.9e7, 3.5e7],
        "kyy": [2e7, 2.1e7, 2.4e7, 3e7],
        "cxx": [9e3, 7e3, 5e3, 4e3],
        "cyy": [8e3, 7e3, 6e3, 5e3],
    }
    return bearing(node, **{"frequency": SPEEDS, **rows, **changed})


def model(version="2.3.0", **sections):
    """The model, whose further sections have __ for the underscore behind the class: BearingElement__left."""
    found = {
        "ross_version": version,
        "parameters": {},
        **{f"ShaftElement_Shaft Element {n}": element(n) for n in range(4)},
        "DiskElement_Disk 0": {"n": 2, "m": 5.0, "Id": 0.01, "Ip": 0.02, "tag": "Disk 0"},
        "BearingElement_Bearing 0": bearing(0),
        "BearingElement_Bearing 4": table(4) if version < "3" else table(4, frequency=None, speed=SPEEDS),
    }
    found |= {name.replace("__", "_", 1): values for name, values in sections.items()}
    return copy.deepcopy({name: values for name, values in found.items() if values is not None})


def saved(folder, found, name="model.json"):
    """Its path, as JSON."""
    (folder / name).write_text(json.dumps(found), encoding="utf-8")
    return str(folder / name)


def as_toml(found):
    """The text of a model, as ROSS writes it; None is absent there."""
    lines = []
    for name, values in found.items():
        if not isinstance(values, dict):
            lines.append(f"{name} = {json.dumps(values)}")
            continue
        plain = {key: value for key, value in values.items() if value is not None}
        lines += [
            f'\n["{name}"]',
            *(f"{key} = {json.dumps(value)}" for key, value in plain.items() if key != "material"),
        ]
        if "material" in plain:
            lines += [
                f'\n["{name}".material]',
                *(f"{key} = {json.dumps(value)}" for key, value in plain["material"].items()),
            ]
    return "\n".join(lines) + "\n"
