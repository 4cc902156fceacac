"""What a file leaves open: the one question at which its reading stops, and all of them at once.

The rest of a file can be read with any answer, to see what else is open: `Question.meanwhile` is such an answer. Nothing that was
read with it is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ksmea.errors import SettingError

MOST = 20  # questions: a file has less


@dataclass(frozen=True)
class Question:
    """`setting` answers it, each of `shown` is an answer with capitals in place of what only the user knows; `meanwhile` is one with which
    the rest of the file can be read, None where nothing can."""

    setting: str
    said: str
    shown: tuple[str, ...]
    meanwhile: Any


class OpenQuestion(SettingError):
    """Reading a file stops because something is left open."""

    def __init__(self, said: str, setting: str, shown: tuple[str, ...], meanwhile: Any) -> None:
        super().__init__(said)
        self.question = Question(setting, str(self), shown, meanwhile)


def open_questions(read: Callable[[Mapping[str, Any]], object], settings: Mapping[str, Any]) -> list[Question]:
    """All that `read` leaves open with these settings, in the order in which it meets them. Where it then fails for another reason,
    that may come of a preliminary answer, and is not told; where it fails at first, `SettingError`."""
    found: dict[str, Question] = {}
    tried = dict(settings)
    for _ in range(MOST):
        try:
            read(tried)
        except OpenQuestion as error:
            question = error.question
            earlier = found.get(question.setting)
            found[question.setting] = question if earlier is None else _joined(earlier, question)
            if question.meanwhile is None:
                break
            tried[question.setting] = question.meanwhile
        except SettingError:
            if not found:
                raise
            break
        else:
            break
    return list(found.values())


def _joined(one: Question, other: Question) -> Question:
    """Two questions that one setting answers: the later one knows more of the answer."""
    return Question(one.setting, f"{one.said}; {other.said}", other.shown, other.meanwhile)
