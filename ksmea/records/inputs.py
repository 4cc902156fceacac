"""Records of numbers that are known to a tolerance: as stated, and as the data leave them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from ksmea.problem.parameters import SEEN
from ksmea.units import OfUnknown, Part, Quantity

Share = Annotated[tuple[str, float], Quantity("name, part of the variance")]


@dataclass(frozen=True)
class InputRecord:
    """One number. Values are SI; divided by `si_per_unit` they are in `unit`."""

    IN_UNIT: ClassVar = ("stated", "stated_sd", "value", "sd")

    name: str
    words: str
    unit: str
    si_per_unit: float
    stated: float
    stated_sd: float
    value: float  # most likely, by the data and the statement
    sd: float  # of that
    pull: float  # (value − stated) / √(stated_sd² − sd²): standard normal where the statement holds
    is_contradicted: bool  # whether the largest of all pulls is so large where all statements hold in 1 % of cases only

    @property
    def is_seen(self) -> bool:
        """Whether the data say anything of it beyond the statement."""
        return self.sd < SEEN * self.stated_sd


@dataclass(frozen=True)
class Origin:
    """Origins of the uncertainty of an unknown.

    Standard deviations (SI) by noise and by numbers that are known to a tolerance, and the shares of the numbers that
    matter most in the variance.
    """

    sd_noise: OfUnknown
    sd_inputs: OfUnknown
    shares: tuple[Share, ...]

    @property
    def of_inputs(self) -> Part:
        return self.sd_inputs**2 / (self.sd_noise**2 + self.sd_inputs**2)
