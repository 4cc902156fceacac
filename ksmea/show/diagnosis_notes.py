"""Remarks of a diagnosis on the data and on effects, for text and page."""

# Shorter than 40 lines: remarks are no part of the finding, which has a file of its own.

from __future__ import annotations

from ksmea.records.diagnosis import DiagnosisRecord


def notes(record: DiagnosisRecord) -> str:
    """Remarks, a line each, in which effects have their words."""
    return "\n".join(f"Note: {_in_words(remark, record)}" for remark in record.remarks)


def _in_words(remark: str, record: DiagnosisRecord) -> str:
    """A remark on an effect, 'residual_bow: …', with its words in place of its name."""
    name, colon, said = remark.partition(": ")
    words = [each.statement.words for each in record.applied if each.name == name and each.statement is not None]
    return f"{words[0]}{colon}{said}" if words else remark
