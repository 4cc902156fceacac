"""Facts on the unknowns of each cell for tables, including the Cramér–Rao lower bound (CRLB).

Cells of a grid often differ in their method or in what data hide, and have the same CRLB. It is computed once for all whose
problem, true values and noise have the same content.
"""

from __future__ import annotations

import hashlib
import pickle

from bench.plan.plan import ParameterFacts
from bench.plan.setup import Setup


class FactsOfCells:
    """Facts of the cells of one plan."""

    def __init__(self) -> None:
        self._crlbs: dict[str, list[float | None]] = {}

    def of(self, setup: Setup, with_crlb: bool) -> tuple[ParameterFacts, ...]:
        """Facts on a cell's unknowns; none if its study needs no problem."""
        if setup.aligned_problem is None:
            return ()
        parameters = setup.problem.parameters
        crlbs = self._crlb(setup) if with_crlb else [None] * len(parameters)
        return tuple(
            ParameterFacts(part.name, part.unit, part.si_per_unit, setup.truth.get(part.name), crlb, lower, upper)
            for part, crlb, lower, upper in zip(
                parameters, crlbs, parameters.lower.tolist(), parameters.upper.tolist(), strict=True
            )
        )

    def _crlb(self, setup: Setup) -> list[float | None]:
        content = _content(setup)
        if content is None:
            return setup.crlb()
        if content not in self._crlbs:
            self._crlbs[content] = setup.crlb()
        return self._crlbs[content]


def _content(setup: Setup) -> str | None:
    """The hash of all that the CRLB depends on; None if that cannot be written down. Nothing is read back."""
    source = setup.source
    try:
        content = pickle.dumps((setup.problem, setup.truth, source.noise, source.kind, source.noise_known))
    except Exception:  # whatever a problem of other people raises
        return None
    return hashlib.sha256(content).hexdigest()
