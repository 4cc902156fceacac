"""Whether a class gives a member of a contract, which may be left out."""

from __future__ import annotations


class Given:
    """An attribute of a base class: whether the class of an object has a member of its own in place of the base class's.

    >>> class Shape:
    ...     def area(self): raise NotImplementedError
    ...     has_area = Given("area")
    >>> class Square(Shape):
    ...     def area(self): return 1
    >>> Shape().has_area, Square().has_area
    (False, True)
    """

    def __init__(self, member: str) -> None:
        self._member = member

    def __set_name__(self, base: type, name: str) -> None:
        self._base = base

    def __get__(self, instance: object, kind: type) -> bool:
        return getattr(kind, self._member) is not getattr(self._base, self._member)
