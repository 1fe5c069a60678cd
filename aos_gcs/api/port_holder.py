"""The process that listens at a port, from Linux's /proc; unknown on other systems and for other users' processes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_PROC: Final = Path("/proc")
_TABLES: Final = ("net/tcp", "net/tcp6")
_LISTENING: Final = "0A"
_STOPPED: Final = frozenset("Tt")
_NAME_LENGTH: Final = 80


@dataclass(frozen=True, slots=True)
class PortHolder:
    """Process that listens at a port."""

    pid: int
    name: str
    """Command line of the process, shortened."""
    is_stopped: bool
    """Whether it stands still, as after Ctrl-Z: it keeps the port until it goes on."""

    def describe(self) -> str:
        """Return the process and the remedy as a clause."""
        who = f"process {self.pid} ({self.name})"
        if self.is_stopped:
            return f"{who}, which is stopped and keeps it: end it with kill -9 {self.pid}"
        return f"{who}: stop it"


def find_holder(port: int, proc: Path = _PROC) -> PortHolder | None:
    """Return the process that listens at a port; None where that cannot be found out."""
    sockets = {f"socket:[{inode}]" for table in _TABLES for inode in _listening_inodes(proc / table, port)}
    if not sockets:
        return None
    for folder in proc.glob("[0-9]*"):
        if not sockets.isdisjoint(_open_files(folder)):
            with suppress(OSError, IndexError):
                return _describe(folder)
    return None


def _listening_inodes(table: Path, port: int) -> Iterator[str]:
    with suppress(OSError):
        for line in table.read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == _LISTENING and int(fields[1].rpartition(":")[2], 16) == port:
                yield fields[9]


def _open_files(folder: Path) -> Iterator[str]:
    # Processes end while they are looked at, and those of other users cannot be.
    with suppress(OSError):
        for link in (folder / "fd").iterdir():
            with suppress(OSError):
                yield str(link.readlink())


def _describe(folder: Path) -> PortHolder:
    words = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace").strip()
    # The command in parentheses may hold spaces and parentheses itself.
    state = (folder / "stat").read_text().rpartition(")")[2].split()[0]
    name = words if len(words) <= _NAME_LENGTH else f"{words[:_NAME_LENGTH]} …"
    return PortHolder(int(folder.name), name, is_stopped=state in _STOPPED)
