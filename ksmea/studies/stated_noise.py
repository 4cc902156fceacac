"""What a report says of noise that is not as large as it is stated."""

from __future__ import annotations

import numpy as np

from ksmea.diagnosis.diagnosis import Diagnosis
from ksmea.diagnosis.stated_noise import is_stated_too_large
from ksmea.measurement import Measurement


def believed(found: Diagnosis) -> Measurement:
    """The measurement with the noise that a diagnosis goes by."""
    return found.baseline.likelihood.measurement


def stated_noise_remarks(found: Diagnosis, measurement: Measurement) -> tuple[str, ...]:
    """A remark where stated noise is not believed, or is larger than what the data leave room for."""
    stated, taken = measurement.noise, believed(found).noise
    if stated is None or taken is None:
        return ()
    factor = float(np.nanmax(taken.sd(np.abs(measurement.values)) / stated.sd(np.abs(measurement.values))))
    if factor > 1:
        return (
            (
                f"the data scatter {factor:.2f} times as much as their stated noise, evenly over speeds and channels: noise"
                f" is taken {factor:.2f} times as large; if it is not, something is wrong that looks like noise"
            ),
        )
    fit, quality = (found.baseline, found.baseline_quality)
    if found.best is not None and found.best_quality is not None:
        fit, quality = found.best, found.best_quality
    if is_stated_too_large(quality, fit.likelihood.n_residual - fit.likelihood.d, found.level / 2):
        return (
            (
                f"the data scatter {np.sqrt(quality.reduced_chi2):.2f} times as much as their stated noise: intervals are wider, and"
                " effects must be larger to be seen, than with noise as large as that"
            ),
        )
    return ()
