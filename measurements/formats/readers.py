"""Readers of formats, and the one way from a file's content to rows."""

from __future__ import annotations

from collections.abc import Callable

from ksmea.measurement.notation import Notation
from measurements.formats.adre import read_adre
from measurements.formats.binary.excel import read_excel
from measurements.formats.binary.mat import read_mat
from measurements.formats.binary.tdms import read_tdms
from measurements.formats.binary.uff import curves_of_datasets, datasets
from measurements.formats.curve import Curve
from measurements.formats.lazy_file import Opened
from measurements.formats.sheet import Sheet, read_delimited
from measurements.formats.system1 import read_system1
from measurements.formats.table import read_table, roles_of
from measurements.formats.to_rows import decided
from measurements.formats.user_answers import Answers
from measurements.formats.waveforms.waveform import read_waveform
from measurements.run_up_rows import MAX_BYTES, Rows


def _headings(answers: Answers) -> list[str]:
    return list(dict.fromkeys(roles_of(answers.columns).headings.values()))


def _csv(opened: Opened, answers: Answers) -> list[Curve]:
    headings = _headings(answers)
    return _table(opened, answers, lambda content: read_delimited(content, answers.path, headings))


def _excel(opened: Opened, answers: Answers) -> list[Curve]:
    headings = _headings(answers)
    return _table(opened, answers, lambda content: read_excel(content, answers.path, answers.sheet, headings))


def _mat(opened: Opened, answers: Answers) -> list[Curve]:
    headings = _headings(answers)
    return _table(opened, answers, lambda content: read_mat(content, answers.path, headings))


def _tdms(opened: Opened, answers: Answers) -> list[Curve]:
    headings = _headings(answers)
    return _table(opened, answers, lambda content: read_tdms(content, answers.path, headings))


def _table(opened: Opened, answers: Answers, read: Callable[[bytes], Sheet]) -> list[Curve]:
    key = (answers.format, answers.sheet, *_headings(answers))
    return read_table(opened.once("sheet", key, lambda: read(opened.content(MAX_BYTES))), answers)


def _uff(opened: Opened, answers: Answers) -> list[Curve]:
    sets = opened.once("datasets", None, lambda: datasets(opened.content(MAX_BYTES), answers.path))
    return curves_of_datasets(sets, answers)


def _system1(opened: Opened, answers: Answers) -> list[Curve]:
    return opened.once(
        "system1", (tuple(answers.harmonics), answers.phase), lambda: read_system1(opened.content(MAX_BYTES), answers)
    )


def _adre(opened: Opened, answers: Answers) -> list[Curve]:
    return opened.once("adre", None, lambda: read_adre(opened.content(MAX_BYTES), answers))


READERS: dict[str, Callable[[Opened, Answers], list[Curve]]] = {
    "csv": _csv,
    "excel": _excel,
    "mat": _mat,
    "tdms": _tdms,
    "uff": _uff,
    "system1": _system1,
    "adre": _adre,
    "waveform": read_waveform,
}


def foreign_rows(opened: Opened, answers: Answers) -> tuple[Rows, tuple[str, ...], bool, Notation]:
    """Rows of a foreign file, the remarks on them, whether slow roll is subtracted, and its notation."""
    curves = READERS[answers.format](opened, answers)
    rows, remarks, notation = decided(curves, answers)
    notes = dict.fromkeys(note for curve in curves for note in curve.notes)
    return rows, (*notes, *remarks), any(curve.is_compensated for curve in curves), notation
