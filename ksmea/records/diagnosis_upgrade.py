"""Names of diagnosis records of earlier versions, as they are now."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

FIELDS = {  # at any depth of a record
    "class": "ambiguity_group",
    "places": "locations",
    "place": "location",
    "gain": "predictive_gain",
    "likeness": "collinearity",
    "tried": "effects",
    "fall": "deviance_drop",
    "hidden_fall": "hidden_deviance_drop",
    "at_bound": "at_limit",
    "log_score": "elpd_difference",
}
STATISTICS = {
    "neighbours": "autocorrelation over speed",
    "channels together": "cross-channel correlation",
    "largest": "largest residual",
    "level": "χ²",
}
VERBATIM = ("settings", "curves")  # what holds no names of these


def is_older(data: Mapping[str, Any]) -> bool:
    return "class" in data


def renamed(data: Mapping[str, Any]) -> dict[str, Any]:
    """Older data with the present names of fields and statistics."""
    found: dict[str, Any] = _renamed(data)
    tests = found["lack_of_fit"]
    for when in ("before", "after"):
        if tests[when] is not None:
            tests[when] = _with_statistics(tests[when])
    return found


def _renamed(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {FIELDS.get(name, name): value if name in VERBATIM else _renamed(value) for name, value in data.items()}
    return [_renamed(value) for value in data] if isinstance(data, list) else data


def _with_statistics(test: Mapping[str, Any]) -> dict[str, Any]:
    by_statistic = {STATISTICS.get(name, name): p for name, p in test["p_by_statistic"].items()}
    return {**test, "statistic": STATISTICS.get(test["statistic"], test["statistic"]), "p_by_statistic": by_statistic}
