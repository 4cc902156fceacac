"""A run in one word: `bare`, or the known weights that the shaft carries, `150@0.2@30`.

A weight is its size (g mm), its position from the left end (m) and its angle (degrees, 0 where it is left out), with @
between. Several weights are joined by +.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ksmea.campaign import Weight
from ksmea.errors import SettingError
from ksmea.units import DEGREE, GRAM_MILLIMETRE

BARE = "bare"  # a run without a weight


def weights_of(run: str) -> tuple[Weight, ...]:
    """The weights of a run; `SettingError` where the word says none.

    >>> [str(weight) for weight in weights_of("150@0.2+80@1@-90")]
    ['150 g mm at 0.2 m, 0°', '80 g mm at 1 m, -90°']
    """
    return () if run == BARE else tuple(_weight(word, run) for word in run.split("+"))


def notation(weights: Sequence[Weight]) -> str:
    """The word of a run with these weights.

    >>> notation(weights_of("150@0.2+80@1@-90")), notation(())
    ('150@0.2+80@1@-90', 'bare')
    """
    return "+".join(map(_word, weights)) or BARE


def _weight(word: str, run: str) -> Weight:
    try:
        size, position, *angle = map(float, word.split("@"))
    except ValueError:
        raise _no_run(run) from None
    if len(angle) > 1 or size <= 0 or not all(map(math.isfinite, (size, position, *angle))):
        raise _no_run(run)
    return Weight(position, size * GRAM_MILLIMETRE, sum(angle) * DEGREE)


def _word(weight: Weight) -> str:
    parts = [weight.magnitude / GRAM_MILLIMETRE, weight.position, weight.angle / DEGREE]
    return "@".join(f"{part:.12g}" for part in (parts if weight.angle else parts[:2]))


def _no_run(run: str) -> SettingError:
    return SettingError(
        f"runs: expected {BARE}, or weights such as 150@0.2@30 (g mm, m, degrees) joined by +, got '{run}'; write it so"
    )
