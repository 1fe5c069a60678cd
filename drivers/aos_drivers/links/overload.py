"""Datagrams that the system had to drop because this station did not read them in time."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from aos_gcs.ports import Clock

_TABLES = (Path("/proc/net/udp"), Path("/proc/net/udp6"))
_PERIOD_S = 5.0
_LEAST_DROPS = 20
"""Fewer in one period are no overload."""
_PAUSE_S = 60.0
_INODE, _DROPS = 9, 12
"""Columns of the tables."""


def inode_of(descriptor: int) -> int | None:
    """Return the number by which the system lists a socket; None if it has none."""
    try:
        return os.fstat(descriptor).st_ino
    except OSError:
        return None


def drops_in(table: str, inode: int) -> int | None:
    """Return the datagrams dropped so far for a socket, from the text of /proc/net/udp; None if it is not listed."""
    for line in table.splitlines()[1:]:
        columns = line.split()
        if len(columns) > _DROPS and columns[_INODE] == str(inode):
            return int(columns[_DROPS])
    return None


def dropped_datagrams(inode: int) -> int | None:
    """Return the datagrams dropped so far for a socket; None where the system does not tell."""
    for path in _TABLES:
        try:
            drops = drops_in(path.read_text(encoding="ascii"), inode)
        except OSError:
            continue
        if drops is not None:
            return drops
    return None


class OverloadWatch:
    """Watches one socket, and reports an overload at most once a minute."""

    def __init__(self, name: str, count: Callable[[], int | None], report: Callable[[str], None]) -> None:
        """``count`` returns the datagrams dropped so far, ``report`` takes a sentence about the link ``name``."""
        self._name = name
        self._count = count
        self._report = report
        self._before = count()
        self._told_at_s: float | None = None

    async def run(self, clock: Clock) -> None:
        """Watch until cancelled, or until the system does not tell."""
        while self._before is not None:
            await clock.sleep(_PERIOD_S)
            self.look(clock.now_s())

    def look(self, now_s: float) -> None:
        """Count again."""
        drops = self._count()
        lost = 0 if drops is None or self._before is None else drops - self._before
        self._before = drops
        is_told = self._told_at_s is not None and now_s - self._told_at_s < _PAUSE_S
        if lost >= _LEAST_DROPS and not is_told:
            self._told_at_s = now_s
            self._report(
                f"this station is overloaded: it lost {lost} packets at {self._name} within {_PERIOD_S:.0f} s. "
                "Close other programs on this computer, reduce the rates of telemetry, or find what else sends here"
            )
