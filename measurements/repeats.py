"""Speeds that a channel has several times, as exports with rounded speeds have them: the mean vector stands for all."""

from __future__ import annotations

import numpy as np

from measurements.run_up_rows import Rows, rows_at
from measurements.vectors import vectors, with_vectors


def averaged(rows: Rows) -> tuple[Rows, str | None]:
    """Each speed of a channel once, where it stands first, and a remark where that changes anything. Stated standard deviations
    are those of the mean of independent rows."""
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
    told = f"repeats: {len(rows.line)} rows averaged to {len(together)} (complex mean, at most {most} of one speed)"
    return rows_at(with_vectors(rows, values, sigma), [indices[0] for indices in together.values()]), told
