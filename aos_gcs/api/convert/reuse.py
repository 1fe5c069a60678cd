"""Conversions that are repeated only when their input has changed.

Most of a fleet's state is the same from one snapshot to the next. Objects that are handed out again cost nothing to
convert, and next to nothing to compare with what clients already have.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

FromT = TypeVar("FromT")
ToT = TypeVar("ToT")


class Reused(Generic[FromT, ToT]):
    """One value, converted again when it differs from the one before.

    Args:
        convert: called with the changed value.
    """

    def __init__(self, convert: Callable[[FromT], ToT]) -> None:
        self._convert = convert
        self._latest: tuple[FromT, ToT] | None = None

    def __call__(self, value: FromT) -> ToT:
        """Return the converted value."""
        if self._latest is None or not (value is self._latest[0] or value == self._latest[0]):
            self._latest = value, self._convert(value)
        return self._latest[1]


class ReusedItems(Generic[FromT, ToT]):
    """A list whose items are converted again when they differ from those at the same place before.

    Args:
        convert: called with each changed item.
    """

    def __init__(self, convert: Callable[[FromT], ToT]) -> None:
        self._convert = convert
        self._items: tuple[FromT, ...] = ()
        self._converted: list[ToT] = []

    def __call__(self, items: tuple[FromT, ...]) -> list[ToT]:
        """Return the converted items, which must not be changed."""
        if items is not self._items:
            former = zip(items, self._items, self._converted, strict=False)
            converted = [known if item == before else self._convert(item) for item, before, known in former]
            converted += [self._convert(item) for item in items[len(converted) :]]
            self._items, self._converted = items, converted
        return self._converted
