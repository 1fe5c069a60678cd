"""Requests that arrive by several ways and are carried out once."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Callable, Coroutine, Hashable
from typing import Any, Final, TypeVar

KEPT: Final = 256
"""Answers that are kept for copies that arrive later."""

T = TypeVar("T")


class Once:
    """Carries out what arrives under a name once, and gives all who ask for it the one answer."""

    def __init__(self) -> None:
        self._tasks: OrderedDict[Hashable, asyncio.Task[Any]] = OrderedDict()

    async def run(self, key: Hashable | None, begin: Callable[[], Coroutine[Any, Any, T]]) -> T:
        """Return the result of the first call of ``begin`` under a key; without a key, of this one.

        What has begun goes on when the one who asks for it is gone.
        """
        if key is None:
            return await begin()
        task: asyncio.Task[T] | None = self._tasks.get(key)
        if task is None:
            task = self._tasks[key] = asyncio.create_task(begin())
            task.add_done_callback(_look_at)
            if len(self._tasks) > KEPT:
                self._tasks.popitem(last=False)
        return await asyncio.shield(task)


def _look_at(task: asyncio.Task[Any]) -> None:
    """Take note of an error that nobody waits for any more: it was an answer to a client."""
    if not task.cancelled():
        task.exception()
