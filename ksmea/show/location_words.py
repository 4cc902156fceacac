"""A location in a line: its places in words, and what was found there."""

from __future__ import annotations

import numpy as np

from ksmea.records.location import NONE, NOTHING, PAIR, LocationRecord, SiteRecord

MAX_PAIRS = 8  # of places that a line lists


def headline(record: LocationRecord) -> str:
    """What was located."""
    if record.kind == NOTHING:
        return "The model is enough: nothing needs to be located"
    if record.kind == NONE:
        return "Nothing that was tried explains the data"
    if record.is_spread:
        return "Something unknown at most places explains the data: its cause may as well be spread along the shaft"
    ended = "," if record.law is not None else ""  # of its clause
    return f"An unknown {in_short(record)}{ended} explains the data"


def in_short(record: LocationRecord) -> str:
    """The places of the law that holds, or the accepted sites of each kind, in a line: 'force at 0.5 m (disk 2), which acts
    as a spring', 'force at 0.5 m (disk 2) or moment at 0.2 m (disk 1)'."""
    if (law := record.law) is not None:
        places = dict.fromkeys(each.position for each in record.law_class if each.key == law.key)
        return f"{law.kind} at {' or '.join(place(record, each) for each in places)}, which acts as {law.law}"
    kinds = dict.fromkeys(site.kind for site in record.sites)
    return " or ".join(f"{kind} {spread(record, kind)}" for kind in kinds)


def place(record: LocationRecord, *positions: float) -> str:
    """For example '0.5 m (disk 2) and 0.8 m'."""
    named = [(position, landmark(record, position)) for position in positions]
    return " and ".join(f"{position:g} m ({name})" if name else f"{position:g} m" for position, name in named)


def landmark(record: LocationRecord, position: float) -> str:
    """What sits at a position, in words."""
    return ", ".join(name for name, there in record.landmarks.items() if np.isclose(there, position, atol=1e-6))


def landmarks(record: LocationRecord, site: SiteRecord) -> str:
    """What sits at the positions of a site."""
    return " and ".join(name for position in site.positions if (name := landmark(record, position)))


def spread(record: LocationRecord, kind: str) -> str:
    """Where sites of a kind are accepted, and how much of what was tried that is."""
    accepted = sorted(site.positions for site in record.sites if site.kind == kind)
    if len(accepted) == 1:
        return f"at {place(record, *accepted[0])}"
    tried = sorted(site.positions for site in record.candidates if site.kind == kind)
    if kind == PAIR:
        shown = "; ".join(place(record, *each) for each in accepted[:MAX_PAIRS])
        more = "; …" if len(accepted) > MAX_PAIRS else ""
        return f"at {shown}{more} ({len(accepted)} of the {len(tried)} pairs that leave least)"
    neighbours = np.gradient(np.array([position for (position,) in tried])) if len(tried) > 1 else np.ones(1)
    share = sum(width for position, width in zip(tried, neighbours) if position in accepted) / sum(neighbours)
    places = ", ".join(place(record, *each) for each in accepted)
    return f"at {places} ({100 * share:.0f} % of what was tried)"
