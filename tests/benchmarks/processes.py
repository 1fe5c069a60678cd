"""Processor time and memory of processes, by ``/proc``: for Linux."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


def stat(pid: int) -> list[str]:
    """Return the fields of ``/proc/PID/stat`` behind the name: state, parent, …

    Raises:
        OSError: there is no such process.
    """
    return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()


def cpu_s(pid: int) -> float:
    """Return the processor time of a process and of those of its children that have ended.

    Raises:
        OSError: there is no such process.
    """
    return sum(map(int, stat(pid)[11:15])) / os.sysconf("SC_CLK_TCK")


def children(pid: int) -> list[int]:
    """Return the ids of the processes that a process has started."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if int(stat(int(path.name))[1]) == pid:
                found.append(int(path.name))
    return found


def family(pid: int) -> list[int]:
    """Return the ids of a process and of all that it and they have started."""
    found = [pid]
    for one in found:
        found += children(one)
    return found


def proportional_mb(pid: int) -> float:
    """Return the proportional set size of a process: what it shares counts in parts.

    Raises:
        OSError: there is no such process, or it belongs to somebody else.
    """
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()
    return next(int(one.split()[1]) for one in lines if one.startswith("Pss:")) / 1024.0
