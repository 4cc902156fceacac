"""Records of a model extended by effects.

Its gain on left-out data, and averages over indistinguishable explanations.

The elpd difference of two models is how much better one predicts left-out data than the other, block by block: the expected log
predictive density (elpd) of a model is estimated by the log density of data that it was not fitted to. The
difference of two models is a sum over blocks of left-out data, and often one block holds nearly all of it: a resonance
that the worse model puts at another speed costs a million, the other blocks a hundred each. The standard error of such a
sum is as large as the sum itself although every block says the same. Whether the data support an extension is therefore
asked of the ranks of the differences, which no single block can dominate.

The rule: left-out data *support* an extension where the elpd difference is positive and the one-sided, exact Wilcoxon
signed-rank test of the differences per block gives p ≤ 0.05. At least five blocks are needed, since all of n blocks better
is p = 2⁻ⁿ. The blocks are taken as independent, though the fits to the others share most of their data.

A. Vehtari, A. Gelman and J. Gabry, Stat. Comput. 27 (2017) 1413–1432, doi 10.1007/s11222-016-9696-4 (elpd and its
standard error); F. Wilcoxon, Biometrics Bulletin 1 (1945) 80–83, doi 10.2307/3001968.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import scipy

from ksmea.arrays import Array
from ksmea.records.estimate import EstimateRecord
from ksmea.records.record import Record
from ksmea.records.statement import StatementRecord
from ksmea.units import Vibration

SUPPORT_LEVEL = 0.05  # p of the signed-rank test up to which a positive elpd difference counts as supported


@dataclass(frozen=True)
class ElpdDifference:
    """Log density of each left-out block under the extended model minus that under the baseline model.

    >>> import numpy as np
    >>> found = ElpdDifference(np.array([1.5e6, 90.0, 40.0, 35.0, 12.0, 7.0]))
    >>> found.total > 2 * found.standard_error, found.n_better, found.p_wilcoxon, found.is_supported
    (False, 6, 0.015625, True)
    """

    by_block: Array  # (n_block,)

    @property
    def total(self) -> float:
        """The elpd difference: the sum over blocks."""
        return float(self.by_block.sum())

    @property
    def standard_error(self) -> float:
        """Standard error of the total, from the scatter of the blocks."""
        return float(self.by_block.std(ddof=1) * np.sqrt(len(self.by_block)))

    @property
    def median(self) -> float:
        """Median of the differences per block."""
        return float(np.median(self.by_block))

    @property
    def n_better(self) -> int:
        """Blocks that the extended model predicts better."""
        return int(np.sum(self.by_block > 0))

    @property
    def p_sign(self) -> float:
        """Exact one-sided sign test: the chance of so many better blocks by equally good models."""
        unequal = int(np.sum(self.by_block != 0))
        return float(scipy.stats.binomtest(self.n_better, unequal, alternative="greater").pvalue) if unequal else 1.0

    @property
    def p_wilcoxon(self) -> float:
        """Exact one-sided Wilcoxon signed-rank test of the differences; equal blocks are left out."""
        unequal = self.by_block[self.by_block != 0]
        return (
            float(scipy.stats.wilcoxon(unequal, alternative="greater", method="exact").pvalue) if len(unequal) else 1.0
        )

    @property
    def is_supported(self) -> bool:
        """Whether left-out data support the extension, by the rule above."""
        return self.total > 0 and self.p_wilcoxon <= SUPPORT_LEVEL


@dataclass(frozen=True)
class EffectRecord(Record):
    """An effect at its location, with the settings that a problem file needs to have it there."""

    name: str
    location: str
    settings: Mapping[str, Any]
    statement: StatementRecord | None = (
        None  # what is said of it at its fitted sizes; None in older records, and where it has none
    )


@dataclass(frozen=True)
class PredictiveGainRecord(Record):
    """Gain of the extended model in predicting blocks of speeds that are left out.

    `is_supported` by the rule above.
    """

    elpd_difference: float  # sum over blocks
    standard_error: float
    by_block: tuple[float, ...]
    median: float  # of the blocks
    n_better: int  # blocks that the extended model predicts better
    p_sign: float  # exact, one-sided
    p_wilcoxon: float  # exact, one-sided
    is_supported: bool
    rmse_before: Vibration
    rmse_after: Vibration

    @classmethod
    def of(cls, elpd: ElpdDifference, rmse_before: float, rmse_after: float) -> Self:
        return cls(
            elpd_difference=elpd.total,
            standard_error=elpd.standard_error,
            by_block=tuple(elpd.by_block.tolist()),
            median=elpd.median,
            n_better=elpd.n_better,
            p_sign=elpd.p_sign,
            p_wilcoxon=elpd.p_wilcoxon,
            is_supported=elpd.is_supported,
            rmse_before=rmse_before,
            rmse_after=rmse_after,
        )


@dataclass(frozen=True)
class ExtensionRecord(Record):
    """One effect that extends a model, and all unknowns as fitted with it, in their units."""

    effect: EffectRecord
    values: Mapping[str, float]
    units: Mapping[str, str]
    delta_bic: float | None = None  # above the baseline model; None in records that do not say


@dataclass(frozen=True)
class ExplanationRecord(Record):
    """Effects that together explain the data."""

    label: str
    effects: tuple[EffectRecord, ...]
    deviance_drop: float  # against the baseline model
    delta_bic: float
    weight: float | None = None  # in the average; None: it is not averaged


@dataclass(frozen=True)
class AveragedRecord(Record):
    """The unknowns of the baseline model averaged over the explanations (ksmea.diagnosis.model_averaging).

    `interval` is 'mixture'.
    """

    level: float
    coefficients: tuple[EstimateRecord, ...]


@dataclass(frozen=True)
class BandRecord(Record):
    """Averaged amplitudes and the ends of their intervals, (n_speed, n_channel) m."""

    value: tuple[tuple[Vibration, ...], ...]
    low: tuple[tuple[Vibration, ...], ...]
    high: tuple[tuple[Vibration, ...], ...]
