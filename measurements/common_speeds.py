"""Runs of a campaign at speeds that two of them or more have; mean vectors of repeated speeds.

Differences use these.

Runs that were measured at their own speeds can be interpolated to common ones, as channels are
(`measurements/shared_speeds.py` has the method and the uncertainty): the run with the fewest speeds gives them, between
the speeds that all reach. A speed that occurs several times in a channel, as in exports with rounded speeds, is
replaced by the mean vector.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import chain, pairwise
from typing import Any

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.errors import SettingError, shortened, unknown
from ksmea.measurement.speeds import COMMON_SPEED, compared_speeds, equal_speeds
from measurements.formats.curve import Flags
from measurements.run_up import RunUp
from measurements.run_up_rows import Rows, rows_at
from measurements.shared_speeds import Interpolated, interpolated
from measurements.slow_roll import vectors, with_vectors


def at_compared_speeds(
    runs: Sequence[RunUp], names: Sequence[str], reference: str, file: str, *, interpolate: bool = False
) -> list[RunUp]:
    """The runs at the speeds that others have too, with a remark on what that leaves out.

    Raises `SettingError` if differences from the reference mean nothing.
    """
    if reference not in names:
        raise SettingError(f"{file}: {unknown('run of measurement.reference:', reference, names)}")
    if len(runs) < 2:
        raise SettingError(
            f"{file}: expected two runs or more for differences, got one; leave measurement.reference out"
        )
    if not np.iscomplexobj(runs[0].values):
        raise SettingError(
            f"{file}: expected phases for differences between runs, got amplitudes; leave measurement.reference out"
        )
    if interpolate:
        runs = _interpolated_runs(runs, names, file)
    ends = np.cumsum([0, *(len(run.speed) for run in runs)])
    rows = [slice(start, stop) for start, stop in pairwise(ends.tolist())]
    speed = np.concatenate([run.speed for run in runs])
    compared = compared_speeds(speed, rows)
    kept = [compared[(compared >= own.start) & (compared < own.stop)] for own in rows]
    for name, own in zip(names, kept):
        if not len(own):
            raise SettingError(
                f"{file}: expected speeds of run {shortened(name)} that another run has for differences, equal within"
                f" {100 * COMMON_SPEED:g} %, got none; measure the runs at the same speeds, interpolate them"
                " (measurement.incomplete=interpolate), or leave measurement.reference out"
            )
    groups = [compared[each] for each in equal_speeds(speed[compared], COMMON_SPEED)]
    lacking = [sum(not np.any(np.isin(own, group)) for group in groups) for own in kept]
    return [
        _part(run, own - at.start, f"lacks {n} of the {len(groups)} speeds that other runs have" if n else "")
        for run, own, at, n in zip(runs, kept, rows, lacking)
    ]


def _interpolated_runs(runs: Sequence[RunUp], names: Sequence[str], file: str) -> list[RunUp]:
    """The runs at the speeds of the one with the fewest, where their rows lie near enough to each other."""
    for name, run in zip(names, runs):
        if len(run.speed) < 2 or np.any(np.diff(run.speed) <= 0):
            raise SettingError(
                f"{file}: expected two speeds or more of run {name}, each once, to interpolate between, got others; average"
                " repeats, or measure the runs at the same speeds"
            )
    low, high = max(run.speed[0] for run in runs), min(run.speed[-1] for run in runs)
    inside = [run.speed[(run.speed >= low) & (run.speed <= high)] for run in runs]
    common = min(inside, key=len)
    moved = [
        [
            interpolated(
                run.speed, run.values[:, channel], None if run.sigma is None else run.sigma[:, channel], common
            )
            for channel in range(len(run.channels))
        ]
        for run in runs
    ]
    kept = np.ones(len(common), dtype=bool)
    for each in chain.from_iterable(moved):
        kept &= each.is_kept
    if not np.any(kept):
        raise SettingError(
            f"{file}: expected runs whose rows lie near enough to each other to be interpolated, got none; measure the runs at"
            " the same speeds"
        )
    return [_moved(run, each, common, kept) for run, each in zip(runs, moved)]


def _moved(run: RunUp, channels: Sequence[Interpolated], common: Array, kept: Flags) -> RunUp:
    if np.array_equal(run.speed, common[kept]):
        return run
    first = channels[0]
    values: Any = np.stack([each.values for each in channels], axis=1)[kept]
    remark = f"interpolated from {len(run.speed)} speeds to {np.count_nonzero(kept)} that all runs share"
    return dataclasses.replace(
        run,
        speed=common[kept],
        values=values,
        sigma=None if run.sigma is None else np.stack([_given(each.sigma) for each in channels], axis=1)[kept],
        time=None if run.time is None else np.sum(first.weights * run.time[first.neighbours], axis=1)[kept],
        order=run.order[first.neighbours[np.arange(len(common)), np.argmax(first.weights, axis=1)]][kept],
        remarks=(*run.remarks, remark),
    )


def _given(sigma: Array | None) -> Array:
    assert sigma is not None  # of a run that states it
    return sigma


def _part(run: RunUp, kept: Indices, lacking: str) -> RunUp:
    left_out = len(run.speed) - len(kept)
    remarks = [f"{left_out} of {len(run.speed)} speeds left out: no other run has them"] if left_out else []
    if lacking:
        remarks.append(f"{lacking}, and has no part in the differences there")
    return dataclasses.replace(
        run,
        speed=run.speed[kept],
        values=run.values[kept],
        sigma=None if run.sigma is None else run.sigma[kept],
        time=None if run.time is None else run.time[kept],
        order=run.order[kept],
        remarks=(*run.remarks, *remarks),
    )


def averaged(rows: Rows) -> tuple[Rows, str | None]:
    """Each speed of a channel once, at its first place, and a remark if that changes anything.

    Stated standard deviations become standard deviations of the mean of independent rows.
    """
    together: dict[tuple[float, tuple[float, str, float]], list[int]] = {}
    for index, key in enumerate(zip(rows.speed, rows.channel)):
        together.setdefault(key, []).append(index)
    if len(together) == len(rows.line):
        return rows, None
    values = vectors(rows)
    sigma = None if rows.sigma is None else np.array(rows.sigma)
    for indices in together.values():
        if len(indices) > 1:
            values[indices[0]] = np.mean(values[indices])
            if sigma is not None:
                sigma[indices[0]] = np.sqrt(np.sum(sigma[indices] ** 2)) / len(indices)
    most = max(map(len, together.values()))
    remark = f"repeats: {len(rows.line)} rows averaged to {len(together)} (complex mean, at most {most} of one speed)"
    return rows_at(with_vectors(rows, values, sigma), [indices[0] for indices in together.values()]), remark
