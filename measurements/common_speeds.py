"""The runs of a campaign at the speeds that all of them have: differences between runs are of these."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ksmea.arrays import Indices
from ksmea.equal_speeds import COMMON_SPEED, common_speeds
from ksmea.errors import SettingError, unknown
from measurements.run_up import RunUp


def at_common_speeds(runs: Sequence[RunUp], names: Sequence[str], reference: str, file: str) -> list[RunUp]:
    """The runs at their common speeds, with a remark on what that leaves out; `SettingError` where differences from the
    reference mean nothing."""
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
    ends = np.cumsum([0, *(len(run.speed) for run in runs)])
    rows = [slice(start, stop) for start, stop in pairwise(ends.tolist())]
    common = common_speeds(np.concatenate([run.speed for run in runs]), rows)
    if not len(common):
        raise SettingError(
            f"{file}: expected speeds that all runs have for differences, equal within {100 * COMMON_SPEED:g} %, got none; measure"
            " the runs at the same speeds, or leave measurement.reference out"
        )
    return [_part(run, common[(common >= own.start) & (common < own.stop)] - own.start) for run, own in zip(runs, rows)]


def _part(run: RunUp, kept: Indices) -> RunUp:
    left_out = len(run.speed) - len(kept)
    remark = (f"{left_out} of {len(run.speed)} speeds left out: not all runs have them",) if left_out else ()
    return dataclasses.replace(
        run,
        speed=run.speed[kept],
        values=run.values[kept],
        sigma=None if run.sigma is None else run.sigma[kept],
        time=None if run.time is None else run.time[kept],
        order=run.order[kept],
        remarks=(*run.remarks, *remark),
    )
