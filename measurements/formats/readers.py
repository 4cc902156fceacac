"""The reader of each format, and the one way from a file's content to rows."""

from __future__ import annotations

from collections.abc import Callable

from measurements.formats.adre import read_adre
from measurements.formats.answers import Answers
from measurements.formats.curve import Curve
from measurements.formats.decide import decided
from measurements.formats.delimited import read_delimited
from measurements.formats.excel import read_excel
from measurements.formats.mat import read_mat
from measurements.formats.system1 import read_system1
from measurements.formats.table import read_table, roles_of
from measurements.formats.uff import read_uff
from measurements.formats.waveform import read_waveform
from measurements.run_up_rows import Rows


def _headings(answers: Answers) -> list[str]:
    return list(dict.fromkeys(roles_of(answers.columns).headings.values()))


def _csv(content: bytes, answers: Answers) -> list[Curve]:
    return read_table(read_delimited(content, answers.path, _headings(answers)), answers)


def _excel(content: bytes, answers: Answers) -> list[Curve]:
    return read_table(read_excel(content, answers.path, answers.sheet, _headings(answers)), answers)


def _mat(content: bytes, answers: Answers) -> list[Curve]:
    return read_table(read_mat(content, answers.path, _headings(answers)), answers)


READERS: dict[str, Callable[[bytes, Answers], list[Curve]]] = {
    "csv": _csv,
    "excel": _excel,
    "mat": _mat,
    "uff": read_uff,
    "system1": read_system1,
    "adre": read_adre,
    "waveform": read_waveform,
}


def foreign_rows(content: bytes, answers: Answers) -> tuple[Rows, tuple[str, ...], bool]:
    """The rows of a file that is not the project's own, the remarks on them, and whether slow roll is subtracted in it."""
    curves = READERS[answers.format](content, answers)
    rows, remarks = decided(curves, answers)
    return rows, remarks, any(curve.is_compensated for curve in curves)
