"""Words for a location: its sites and kind, and the law of its force with direction and size."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from ksmea.measurement.channel import DIRECTIONS
from ksmea.records.location import NONE, NOTHING, PAIR, LawRecord, LocationRecord, SiteRecord
from ksmea.show.text import angle_with_error, with_error

MAX_PAIRS = 8  # of places that a line lists


def headline(record: LocationRecord) -> str:
    """The located cause in short."""
    if record.kind == NOTHING:
        return "The model is enough: nothing needs to be located"
    if record.kind == NONE:
        return "Nothing that was tried explains the data"
    if record.is_spread:
        return f"Something unknown explains the data, {over_the_shaft(record)}"
    ended = "," if record.law is not None else ""  # of its clause
    return f"An unknown {in_short(record)}{ended} explains the data"


def in_short(record: LocationRecord) -> str:
    """The places of the law that holds, or the accepted sites of each quantity, in a line.

    'force at 0.5 m (disk 2), which acts as a spring', 'force at 0.5 m (disk 2) or moment at 0.2 m (disk 1)'.
    """
    if (law := record.law) is not None:
        places = dict.fromkeys(each.position for each in record.law_class if each.key == law.key)
        return f"{law.kind} at {' or '.join(place(record, each) for each in places)}, which acts as {law.law}"
    quantities = dict.fromkeys(site.kind for site in record.sites)
    return " or ".join(f"{quantity} {spread(record, quantity)}" for quantity in quantities)


def over_the_shaft(record: LocationRecord) -> str:
    """Where something acts that so many places explain that it is at none of them."""
    return f"spread over the shaft ({100 * record.share_of_places:.0f} % of all places explain the data)"


def place(record: LocationRecord, *positions: float) -> str:
    """For example '0.5 m (disk 2) and 0.8 m'."""
    named = [(position, landmark(record, position)) for position in positions]
    return " and ".join(f"{position:.4g} m ({name})" if name else f"{position:.4g} m" for position, name in named)


def landmark(record: LocationRecord, position: float) -> str:
    """Landmarks at a position, in words."""
    return ", ".join(name for name, there in record.landmarks.items() if np.isclose(there, position, atol=1e-6))


def landmarks(record: LocationRecord, site: SiteRecord) -> str:
    """Landmarks at the positions of a site."""
    return " and ".join(name for position in site.positions if (name := landmark(record, position)))


def spread(record: LocationRecord, quantity: str) -> str:
    """Where sites of a quantity are accepted, and how much of what was tried that is."""
    accepted = sorted(site.positions for site in record.sites if site.kind == quantity)
    if len(accepted) == 1:
        return f"at {place(record, *accepted[0])}"
    tried = sorted(site.positions for site in record.candidates if site.kind == quantity)
    if quantity == PAIR:
        shown = "; ".join(place(record, *each) for each in accepted[:MAX_PAIRS])
        more = "; …" if len(accepted) > MAX_PAIRS else ""
        return f"at {shown}{more} ({len(accepted)} of the {len(tried)} pairs that leave least)"
    places = ", ".join(place(record, *each) for each in accepted)
    return f"at {places} ({100 * record.share(quantity):.0f} % of what was tried)"


def law_words(law: LawRecord) -> str:
    """Action of a law, as "it opposes the motion like a spring, 2.1 ± 0.2 MN/m, only above 9 ± 1 µm".

    A record without the key of its law has its name and sizes.
    """
    said = _WORDS.get(law.key)
    return said(law) if said else f"it acts as {law.law}: {_sizes(law)}"


def _turning(what: str) -> Callable[[LawRecord], str]:
    """A vector that turns with the shaft, by its parts at angle 0 and a quarter turn on."""
    return lambda law: f"it is {what}: {_vector(law)}"


def _signed(opposing: str, driving: str, mixed: str) -> Callable[[LawRecord], str]:
    """By whether all coefficients are positive, all negative, or neither."""

    def said(law: LawRecord) -> str:
        signs = {bool(each.value > 0) for each in law.coefficients}
        return f"it {(opposing if signs == {True} else driving if signs == {False} else mixed)}, {_sizes(law)}"

    return said


def _asymmetry(law: LawRecord) -> str:
    return f"it acts as a stiffness that is larger along one axis of the turning shaft than across it, ± {_vector(law, turns=2)}"


def _stop(law: LawRecord) -> str:
    stiffness, clearance, *friction = (f"{with_error(each.value, each.sd)} {each.unit}" for each in law.coefficients)
    verb = "opposes" if law.coefficients[0].value > 0 else "drives"
    rubbing = f", with a friction coefficient of {friction[0].strip()}" if friction else ""
    return f"it {verb} the motion like a spring, {stiffness}, only above {clearance}{rubbing}"


def _smooth(law: LawRecord) -> str:
    sizes = " and ".join(
        f"{min(series):.3g} to {max(series):.3g} N in {axis}" for axis, series in zip(DIRECTIONS, law.amplitude)
    )
    return f"it follows none of the simple laws but changes smoothly with speed ({len(law.coefficients) // 4} knots), {sizes}"


def _vector(law: LawRecord, turns: int = 1) -> str:
    """Size and angle of two coefficients; the angle that they have is `turns` times that in the shaft."""
    first, second = law.coefficients
    size = np.hypot(first.value, second.value)
    along, across = np.array([first.value, second.value]) / size, np.array([second.value, -first.value]) / size
    sd, sideways = (np.hypot(part[0] * first.sd, part[1] * second.sd) for part in (along, across))
    angle, spread = np.degrees([np.arctan2(second.value, first.value), sideways / size]) / turns
    return f"{with_error(size, sd)} {first.unit} at {angle_with_error(angle, min(spread, 180.0))}"


def _sizes(law: LawRecord) -> str:
    return ", ".join(f"{each.name} = {with_error(each.value, each.sd)} {each.unit}" for each in law.coefficients)


_WORDS: Mapping[str, Callable[[LawRecord], str]] = MappingProxyType(
    {
        "constant": _turning("a constant force that turns with the shaft"),
        "proportional_to_speed": _turning("a force ∝ Ω that turns with the shaft"),
        "unbalance": _turning("an unbalance (a force ∝ Ω² that turns with the shaft)"),
        "constant_moment": _turning("a constant moment that turns with the shaft"),
        "moment_proportional_to_speed": _turning("a moment ∝ Ω that turns with the shaft"),
        "skew": _turning("a moment ∝ Ω² that turns with the shaft, as of a skewed disk"),
        "spring": _signed(
            "opposes the motion like a spring",
            "drives the motion as if a spring were missing",
            "acts on the motion like a spring",
        ),
        "spring_proportional_to_speed": _signed(
            "opposes the motion like a spring ∝ Ω", "drives the motion like a spring ∝ Ω", "acts like a spring ∝ Ω"
        ),
        "damper": _signed("damps the motion", "feeds the motion as if a damper were missing", "acts like a damper"),
        "mass": _signed("acts like a mass", "acts as if a mass were missing", "acts like a mass"),
        "cross_coupling": _signed(
            "pushes across the motion and feeds forward whirl",
            "pushes across the motion and feeds backward whirl",
            "pushes across the motion",
        ),
        "spring_and_damper": lambda law: f"it acts like a spring and a damper, {_sizes(law)}",
        "spring_damper_and_mass": lambda law: f"it acts like a spring, a damper and a mass, {_sizes(law)}",
        "cross_coupled_spring_and_damper": lambda law: (
            f"it acts like a spring and a damper that push across the motion too, {_sizes(law)}"
        ),
        "seal": lambda law: (
            f"it acts like a seal, a spring and a damper that turn with part of the speed, {_sizes(law)}"
        ),
        "spring_mass": lambda law: (
            f"it acts like a mass on a spring (absorber, flexible disk or blades), {_sizes(law)}"
        ),
        "rotating_asymmetry": _asymmetry,
        "cubic_spring": _signed(
            "opposes the motion with the cube of its amplitude, a spring that hardens",
            "drives the motion with the cube of its amplitude, a spring that softens",
            "follows the cube of the amplitude",
        ),
        "spring_above_an_amplitude": _stop,
        "rub": _stop,
        "smooth": _smooth,
    }
)
