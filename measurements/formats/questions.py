"""Open questions of a file: the one that stops its reading, and all that can be seen without answers.

The rest of a file can be read with any answer, to see what else is open: `Question.meanwhile` is such an answer. Nothing that was
read with it is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ksmea.errors import SettingError

MOST = 20  # questions: a file has fewer

Source = TypeVar("Source")


@dataclass(frozen=True)
class Question:
    """Open question of an import.

    `setting` answers it, each of `shown` is an answer with capitals in place of what only the user knows; `meanwhile`
    is one with which the rest of the file can be read, None if nothing can.
    """

    setting: str
    said: str
    shown: tuple[str, ...]
    meanwhile: Any

    @property
    def is_suggested(self) -> bool:
        """Whether what is shown is an answer as it stands, which the file suggests."""
        return self.meanwhile in (list(self.shown), *self.shown)


class OpenQuestion(SettingError):
    """Reading a file stops because something is left open."""

    def __init__(self, said: str, setting: str, shown: tuple[str, ...], meanwhile: Any) -> None:
        super().__init__(said)
        self.question = Question(setting, str(self), shown, meanwhile)


@dataclass(frozen=True)
class Asked(Generic[Source]):
    """Open questions, in the order in which reading meets them; `is_all`: no others are open.

    `source` is what was read; None if a question is open.
    """

    questions: tuple[Question, ...]
    is_all: bool
    source: Source | None = None


def open_questions(read: Callable[[Mapping[str, Any]], Source], settings: Mapping[str, Any]) -> Asked[Source]:
    """All questions that `read` leaves open with these settings.

    More may be open if it stops before the end, on a question without a preliminary answer or on an error that may
    result from one. Raises `SettingError` if it fails before any question.
    """
    found: dict[str, Question] = {}
    tried = dict(settings)
    for _ in range(MOST):
        try:
            source = read(tried)
        except OpenQuestion as error:
            question = error.question
            earlier = found.get(question.setting)
            found[question.setting] = question if earlier is None else _joined(earlier, question)
            if question.meanwhile is None or (earlier and question.meanwhile == tried[question.setting]):
                break  # nothing more is seen with that answer
            tried[question.setting] = question.meanwhile
        except SettingError:
            if not found:
                raise
            break
        else:
            return Asked(tuple(found.values()), is_all=True, source=None if found else source)
    return Asked(tuple(found.values()), is_all=False)


def _joined(one: Question, other: Question) -> Question:
    """Two questions that one setting answers: the later one knows more of the answer."""
    said = one.said if other.said in one.said else f"{one.said}; {other.said}"
    return Question(one.setting, said, other.shown, other.meanwhile)
