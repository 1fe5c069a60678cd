"""Files that are whole or not there, and on the disk when they have to be."""

from __future__ import annotations

import os
from pathlib import Path


def replace_file(path: Path, content: bytes, *, is_lasting: bool = False) -> None:
    """Write a file that is either whole or not there; with ``is_lasting``, its content is on the disk then."""
    part = path.with_name(path.name + ".part")
    part.write_bytes(content)
    if is_lasting:
        _sync(part, os.O_RDWR)
    part.replace(path)


def sync_names(folder: Path) -> None:
    """Wait until the names of the files in a folder are on the disk, where the system can tell."""
    if os.name == "posix":
        _sync(folder, os.O_RDONLY)


def _sync(path: Path, flags: int) -> None:
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
