"""Shaft elements and couplings of ROSS."""

from __future__ import annotations

import math
from collections.abc import Sequence

from problems.rotor_import.model import Entry, ImportedRotor, ShaftElement
from problems.rotor_import.ross_sections import Section, optional, tag_of, truth, whole

ROUNDING = 1e-12  # of the outer diameter: smaller bores are none
DIGITS = 12  # of Poisson's ratio, which ROSS saves as two moduli
SWITCHES = ("rotary_inertia", "gyroscopic")
SHEAR_METHODS = ("cowper", "hutchinson")


def shaft_element(rotor: ImportedRotor, section: Section) -> ShaftElement:
    """One element; its material goes into the rotor's."""
    left, right = (section.number(f"od{side}", "m", above=0) for side in "lr")
    inner_left, inner_right = (_bore(section, f"id{side}", left) for side in "lr")
    name, ratio = _material(rotor, section)
    entry: Entry = {"outer_diameter": left}
    entry |= {"inner_diameter": inner_left} if inner_left or inner_right else {}
    entry |= {"outer_diameter_right": right} if right != left else {}
    entry |= {"inner_diameter_right": inner_right} if inner_right != inner_left else {}
    entry["material"] = name
    method = str(section.values.get("shear_method_calc") or SHEAR_METHODS[0])
    if method not in SHEAR_METHODS:
        raise section.error("shear_method_calc", f"expected {' or '.join(SHEAR_METHODS)}, got {method!r}")
    if not truth(section, "shear_effects"):
        entry["theory"] = "euler_bernoulli"
    elif method == "hutchinson":
        entry["shear_coefficient"] = hutchinson_of_ross(ratio, (inner_left + inner_right) / (left + right))
        rotor.remark("hutchinson: the shear coefficient is as ROSS computes it, 1 + ν times below Hutchinson's own")
    entry |= {key: False for key in SWITCHES if not truth(section, key)}
    if force := optional(section, "axial_force"):
        entry["axial_force"] = force
    damping = {name: optional(section, key, at_least=0) for name, key in (("mass", "alpha"), ("stiffness", "beta"))}
    if any(damping.values()):
        entry["standing_damping"] = damping
    return ShaftElement(whole(section, "n"), section.number("L", "m", above=0), entry)


def _bore(section: Section, key: str, outer: float) -> float:
    """An inner diameter, m, which may be rounding on either side of 0."""
    return 0.0 if abs(section.number(key, "m")) < ROUNDING * outer else section.number(key, "m", at_least=0)


def _material(rotor: ImportedRotor, section: Section) -> tuple[str, float]:
    """The name in the rotor file, and Poisson's ratio: the file has E and G."""
    own = section.block("material")
    modulus, shear = (own.number(key, "Pa", above=0) for key in ("E", "G_s"))
    ratio = round(modulus / (2 * shear) - 1, DIGITS)
    density = own.number("rho", "kg/m3", above=0)
    return rotor.material(str(own.values.get("name") or "material"), modulus, density, ratio), ratio


def hutchinson_of_ross(nu: float, ratio: float) -> float:
    """κ as ROSS computes it from Poisson's ratio and the ratio of radii.

    (1 + ν)² belongs into the numerator (Hutchinson 2001).

    >>> round(hutchinson_of_ross(0.29, 0.0), 3)
    0.716
    """
    squared = ratio**2
    ring = (1 + squared) ** 2
    return 6 * ring * (1 + nu) / (ring * (7 + 12 * nu + 4 * nu**2) + 4 * squared * (5 + 6 * nu + 2 * nu**2))


def tell_torque(rotor: ImportedRotor, sections: Sequence[Section], length: float) -> None:
    """Remark on a torque that the rotor here does not have, relative to the buckling torque 2πEI/L.

    Source: Greenhill 1883.
    """
    parts = []
    for section in sections:
        if torque := abs(optional(section, "torque")):
            outer, inner = (min(section.number(f"{key}{side}") for side in "lr") for key in ("od", "id"))
            bending = section.block("material").number("E") * math.pi / 64 * (outer**4 - inner**4)
            parts.append((torque * length / (2 * math.pi * bending), torque))
    if parts:
        part, torque = max(parts)
        rotor.left_out.append(
            f"torque, up to {torque:g} N m on {len(parts)} elements: {100 * part:.2g} % of the buckling torque; frequencies"
            " change by less"
        )


def coupling_element(rotor: ImportedRotor, section: Section) -> ShaftElement:
    """A coupling in line; axial and torsional stiffness have no part in lateral motion."""

    def pair(first: str, second: str) -> list[float]:
        return [optional(section, key, at_least=0) for key in (first, second)]

    parts = {
        "stiffness": pair("kt_x", "kt_y"),
        "angular_stiffness": pair("kr_x", "kr_y"),
        "damping": pair("ct_x", "ct_y"),
        "angular_damping": pair("cr_x", "cr_y"),
        "masses": pair("m_l", "m_r"),
        "polar_inertias": pair("Ip_l", "Ip_r"),
        "diametral_inertias": pair("Id_l", "Id_r"),
    }
    kept = {key: value for key, value in parts.items() if any(value) or key in ("stiffness", "angular_stiffness")}
    entry: Entry = {"coupling": kept}
    if diameter := optional(section, "o_d", at_least=0):
        entry["outer_diameter"] = diameter
    if any(optional(section, f"{kind}_z") for kind in ("kt", "kr", "ct", "cr")):
        rotor.left_out.append(f"axial and torsional stiffness of {tag_of(section)}")
    return ShaftElement(whole(section, "n"), section.number("L", "m", above=0), entry)
