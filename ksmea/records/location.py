"""The record of a location: where something acts that a model lacks, and what it does there.

Lengths are in m, speeds in rad/s; values of unknowns in the unit given with them. Of complex numbers over speed
there are real and imaginary parts under Re(f e^{iΩt}), with the ends of their intervals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from ksmea.measurement.notation import Notation
from ksmea.problem.load import FORCE, MOMENT
from ksmea.records.estimate import EstimateRecord, NoiseLevelRecord
from ksmea.records.extension import ExtensionRecord, PredictiveGainRecord
from ksmea.records.hidden import HiddenEffect
from ksmea.records.in_notation import InNotation, without_default_notation
from ksmea.records.record import Record
from ksmea.units import SPEED, Length, Quantity

STIFFNESS, WORK = Quantity("N/m"), Quantity("J")

UNSEEN = "unseen"  # basis of the interval of an unknown that the data do not show beside what is unknown
PAIR, LATERAL = "pair of forces", "force and moment"  # at two positions, at one
Series = tuple[float, ...]  # (n_speed,)
NOTHING, NONE = "nothing", "none"  # kinds of a location: nothing is missing; none of what was tried explains the data
NEAR = 6.0  # ΔBIC within which laws, also at different sites, cannot be told apart (Kass & Raftery 1995)
SAME = 1e-6  # m between positions of one place
# If so much is accepted, nothing is located: of all sites, or of the places of forces and moments, in each case so many at least
MAX_SHARE, MAX_PLACES, FEWEST_SPREAD = 0.5, 1 / 3, 3


def is_nearest(position: float, tried: Sequence[float], accepted: Sequence[float]) -> bool:
    """Whether a position (m) has none of the tried ones nearer to it than an accepted one."""
    nearest = min((abs(each - position) for each in tried), default=0.0)
    return any(abs(each - position) <= nearest + SAME for each in accepted)


def is_at_most_sites(n_accepted: int, n_tried: int) -> bool:
    """Whether so many of the tried sites explain the data, three or more, that none of them is located."""
    return n_accepted >= FEWEST_SPREAD and n_accepted > MAX_SHARE * n_tried


@dataclass(frozen=True)
class SiteRecord(Record):
    """Something unknown at one position, or at two, fitted and tested."""

    kind: str  # force, moment, force and moment, pair of forces, reading
    position: Length  # the first one
    p: float  # of the lack-of-fit test
    p_by_statistic: Mapping[str, float]
    chi2: float  # in units of the noise
    n_left: int  # real data that neither the unknowns nor what is free take
    accepted: bool
    second: Length | None = None  # position of the other force of a pair

    @property
    def positions(self) -> tuple[float, ...]:
        return (self.position,) if self.second is None else (self.position, self.second)

    def __str__(self) -> str:
        return f"{self.kind} at {' and '.join(f'{position:g} m' for position in self.positions)}"


@dataclass(frozen=True)
class PlainRecord(Record):
    """The model with nothing unknown."""

    p: float
    chi2: float
    n_left: int


@dataclass(frozen=True)
class SeriesRecord(Record):
    """A real quantity over speed with its interval."""

    value: Series
    low: Series
    high: Series


@dataclass(frozen=True)
class PartRecord(Record):
    """One part of what acts: x, y, forward or backward; of force and moment together x and y of each."""

    part: str
    unit: str
    real: SeriesRecord
    imaginary: SeriesRecord
    amplitude: SeriesRecord


@dataclass(frozen=True)
class StiffnessRecord(Record):
    """−f/q of one part, N/m: what the force amounts to where it follows the motion of its site."""

    part: str
    coherence: float  # of force and motion over speed: 1 where it is one complex stiffness
    real: Annotated[SeriesRecord, STIFFNESS]
    imaginary: Annotated[SeriesRecord, STIFFNESS]


@dataclass(frozen=True)
class ForceRecord(Record):
    """Action at the best site, which is the site of the best law if one holds.

    `work` in J per turn, above 0 where it feeds the motion, and `stiffness` of a force.
    """

    kind: str
    position: Length
    parts: tuple[PartRecord, ...]
    work: Annotated[SeriesRecord | None, WORK]
    stiffness: tuple[StiffnessRecord, ...]
    second: Length | None = None  # position of the other force of a pair

    @property
    def positions(self) -> tuple[float, ...]:
        return (self.position,) if self.second is None else (self.position, self.second)


@dataclass(frozen=True)
class LawCoefficientRecord(Record):
    name: str
    unit: str
    value: float
    sd: float


def _of_law(record: LawRecord) -> Quantity:
    return Quantity("N" if record.kind == FORCE else "N m")


@dataclass(frozen=True)
class LawRecord(Record):
    """A law that the force or moment might follow, fitted at a site.

    `accepted` where it leaves no more than the free one does.
    """

    law: str
    position: Length
    p: float
    bic: float
    accepted: bool
    coefficients: tuple[LawCoefficientRecord, ...]
    amplitude: Annotated[tuple[Series, ...], _of_law]  # in x and y
    key: str = ""  # by which settings name the law
    kind: str = FORCE
    amplitude_sd: Annotated[tuple[Series, ...], _of_law] = ()  # of a law of speed alone


@dataclass(frozen=True)
class CoefficientsRecord(Record):
    """Unknown by the plain model, at the best site, and with an interval over all accepted sites."""

    name: str
    plain: EstimateRecord
    best: EstimateRecord | None
    over_sites: EstimateRecord | None


@dataclass(frozen=True)
class LocationRecord(InNotation):
    """Result of a location.

    `kind` belongs to the best site; it is 'nothing' if the plain model is enough, 'none' if nothing that was tried
    explains the data. The best site has the best law, or else leaves least. `candidates` are
    ordered: the accepted ones first, and of these the one that leaves least. `extension` is the model with the best law
    as part of it, `predictive_gain` its gain over the model without.
    """

    kind: str
    candidates: tuple[SiteRecord, ...]
    plain: PlainRecord
    noise: NoiseLevelRecord
    noise_known: bool
    coefficients: tuple[CoefficientsRecord, ...]
    force: ForceRecord | None
    speed: Annotated[Series, SPEED]
    shaft: tuple[Length, Length]  # its ends, or the outermost positions that are known
    landmarks: Mapping[str, Length]  # what sits where on the shaft
    planes: tuple[Length, ...]  # of the probes
    level: float
    interval_level: float
    laws: tuple[LawRecord, ...] = ()  # lowest BIC first; a diagnosis seeks none where an effect explains the data
    extension: ExtensionRecord | None = None  # None where no law holds
    predictive_gain: PredictiveGainRecord | None = None
    hidden: tuple[HiddenEffect, ...] = ()
    seconds: float | None = None  # of a core
    n_channel: int | None = None  # of the measurement; older records do not have it
    breaks: tuple[int, ...] = ()  # where the speeds of a further run begin
    remarks: tuple[str, ...] = ()  # on the model at these speeds
    notation: Notation = field(default_factory=Notation)  # of the measurement's own file

    def to_data(self) -> dict[str, Any]:
        return without_default_notation(super().to_data(), self.notation)

    def shown_data(self) -> dict[str, Any]:
        """Kind, accepted sites, law and work first; then all that was tried."""
        data = self.to_data()
        first = {
            "kind": self.kind,
            "sites": [each.to_data() for each in self.sites],
            "law": None if self.law is None else self.law.to_data(),
            "work": None if self.work is None else self.work.to_data(),
            "force": data["force"],
        }
        return first | {name: value for name, value in data.items() if name not in first}

    @property
    def work(self) -> Annotated[SeriesRecord | None, WORK]:
        return None if self.force is None else self.force.work

    @property
    def law(self) -> LawRecord | None:
        """The accepted law with the lowest BIC."""
        return next((law for law in self.laws if law.accepted), None)

    @property
    def law_status(self) -> str:
        """Reason for a missing law.

        Laws are sought if some site explains the data and, in a diagnosis, no effect does.
        """
        return "found" if self.law else "none holds" if self.laws else "not sought"

    @property
    def law_class(self) -> tuple[LawRecord, ...]:
        """The accepted laws that the data cannot tell from the best one, which comes first."""
        best = self.law
        return () if best is None else tuple(law for law in self.laws if law.accepted and law.bic < best.bic + NEAR)

    @property
    def sites(self) -> tuple[SiteRecord, ...]:
        """Accepted sites, best first; none where nothing is missing."""
        return () if self.kind == NOTHING else tuple(each for each in self.candidates if each.accepted)

    def accepts(self, position: float) -> bool:
        """Whether any of the candidates nearest to a position is accepted.

        Args:
            position: position on the shaft, m.
        """
        return is_nearest(position, [each.position for each in self.candidates], [each.position for each in self.sites])

    def share(self, *kinds: str) -> float:
        """Share of the single positions tried for some kinds at which any of them is accepted.

        Positions are weighted by the length of shaft that they stand for.

        Args:
            *kinds: kinds of quantities, such as force and moment.
        """
        tried = np.unique([each.position for each in self.candidates if each.kind in kinds])
        accepted = [each.position for each in self.sites if each.kind in kinds]
        width = np.gradient(tried) if len(tried) > 1 else np.ones(len(tried))
        return float(np.sum(width[np.isin(tried, accepted)]) / np.sum(width)) if len(tried) else 0.0

    @property
    def share_of_places(self) -> float:
        """The part of the places at which a force, a moment or both explain the data."""
        return self.share(FORCE, MOMENT, LATERAL)

    @property
    def is_anywhere(self) -> bool:
        """Whether something unknown explains the data at most of the sites."""
        return is_at_most_sites(len(self.sites), len(self.candidates))

    @property
    def is_spread(self) -> bool:
        """Whether something unknown explains the data at so many places that none of them is where it acts.

        A force at most places and a moment at others often fit as well as a cause all along the shaft. If fewer places
        are accepted, a law that holds at few of them alone may distinguish them.
        """
        places = {each.position for each in self.sites if each.kind in (FORCE, MOMENT, LATERAL)}
        if self.is_anywhere or len(places) < FEWEST_SPREAD or self.share_of_places < MAX_PLACES:
            return self.is_anywhere
        of_law = {each.position for each in self.law_class}
        return not of_law or self.share_of_places > MAX_SHARE or len(of_law) >= MAX_PLACES * self._n_place

    @property
    def _n_place(self) -> int:
        return len({each.position for each in self.candidates if each.kind in (FORCE, MOMENT, LATERAL)})

    @property
    def is_local(self) -> bool:
        """Whether something unknown explains the data at some places and not at many.

        A law that holds at one of many proves nothing, since a cause that is spread along the shaft often does as much as one mass
        or spring.
        """
        return bool(self.sites) and not self.is_spread
