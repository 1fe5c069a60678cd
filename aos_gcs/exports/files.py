"""Files that are either written as a whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from aos_gcs.errors import ConfigurationError


def check_writable(path: Path) -> None:
    """Refuse an output path before long work is done for it.

    Raises:
        ConfigurationError: naming the path and what is wrong with it.
    """
    folder = path.absolute().parent
    if path.is_dir():
        raise ConfigurationError(f"Cannot write {path}: it is a folder; name a file in it.")
    if not folder.is_dir():
        raise ConfigurationError(f"Cannot write {path}: the folder {folder} does not exist; create it first.")
    if not os.access(folder, os.W_OK):
        raise ConfigurationError(f"Cannot write {path}: you have no permission to write into {folder}.")


@contextmanager
def written_whole(path: Path) -> Iterator[BinaryIO]:
    """Yield a file that takes the place of ``path`` when the block ends, and leaves no trace when it fails.

    Raises:
        ConfigurationError: if the file cannot be written; the text names it.
    """
    with replaced_whole(path) as temporary, temporary.open("wb") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def replaced_whole(path: Path) -> Iterator[Path]:
    """Yield the path of an empty file beside ``path``, for libraries that open files themselves.

    It takes the place of ``path`` when the block ends, and leaves no trace when it fails.

    Raises:
        ConfigurationError: if the file cannot be written; the text names it.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.absolute().parent, prefix=f".{path.name}.")
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            # Temporary files are private; results get the permissions that any new file would have.
            temporary.chmod(0o666 & ~_umask())
            temporary.replace(path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise ConfigurationError(f"Cannot write {path}: {error.strerror or error}.") from error


def _umask() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return umask
