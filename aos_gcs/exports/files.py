"""Files that are either written as a whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from aos_gcs.errors import ConfigurationError


def check_writable(path: Path) -> None:
    """Refuse an output path before long work is done for it.

    Raises:
        ConfigurationError: naming the path and what is wrong with it.
    """
    if path.is_dir():
        raise ConfigurationError(f"Cannot write {path}: it is a folder; name a file in it.")
    _check_parent(path)


def check_suffix(option: str, path: Path, *suffixes: str) -> None:
    """Refuse a name that ends like a file of another kind.

    Raises:
        ConfigurationError: naming the option, the file and the endings that fit.
    """
    if path.suffix.lower() not in suffixes:
        raise ConfigurationError(f"{option} {path}: the name must end in {' or '.join(suffixes)}.")


def check_new_folder(folder: Path) -> None:
    """Refuse a folder for :func:`folder_whole` before long work is done for it.

    Raises:
        ConfigurationError: if there is something in it already, or it cannot be made; the text names it.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ConfigurationError(
            f"Cannot write {folder}: it exists and is not empty; name a folder that does not exist."
        )
    _check_parent(folder)


def _check_parent(path: Path) -> None:
    folder = path.absolute().parent
    if not folder.is_dir():
        raise ConfigurationError(f"Cannot write {path}: the folder {folder} does not exist; create it first.")
    if not os.access(folder, os.W_OK):
        raise ConfigurationError(f"Cannot write {path}: you have no permission to write into {folder}.")


def check_folder(folder: Path) -> None:
    """Refuse a folder for results before long work is done for them, unless it can be made or written into.

    Raises:
        ConfigurationError: naming the folder and what is wrong with it.
    """
    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        raise ConfigurationError(f"Cannot make the folder {folder}: {there} is a file.")
    if not os.access(there, os.W_OK):
        raise ConfigurationError(f"Cannot make the folder {folder}: you have no permission to write into {there}.")


def check_apart(results: Iterable[Path], folder: Path | None, inputs: Iterable[Path]) -> None:
    """Refuse results that would take the place of what they are made of.

    Args:
        results: files to write.
        folder: folder in which files of any name are written, if there is one.
        inputs: files that are read.

    Raises:
        ConfigurationError: naming the file or folder.
    """
    results = list(results)
    if twice := [path for path in results if sum(path.resolve() == one.resolve() for one in results) > 1]:
        raise ConfigurationError(f"Cannot write {twice[0]}: it is named for two results; give each its own file.")
    read = {path.resolve() for path in inputs}
    for path in results:
        if path.resolve() in read:
            raise ConfigurationError(f"Cannot write {path}: it is a file of the recording.")
    if folder is not None and folder.resolve() in {path.parent for path in read}:
        raise ConfigurationError(f"Cannot write into {folder}: it holds the images of the recording.")


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
        # NumPy reports a write that ended early without the system's reason.
        reason = error.strerror or f"the disk may be full ({error})"
        raise ConfigurationError(f"Cannot write {path}: {reason}.") from error


@contextmanager
def folder_whole(folder: Path) -> Iterator[Path]:
    """Yield an empty folder beside ``folder`` that takes its place when the block ends, and vanishes when it fails.

    Raises:
        ConfigurationError: if there is something in ``folder`` already, or it cannot be written; the text names it.
    """
    check_new_folder(folder)
    try:
        temporary = Path(tempfile.mkdtemp(dir=folder.absolute().parent, prefix=f".{folder.name}."))
        try:
            yield temporary
            temporary.chmod(0o777 & ~_umask())
            temporary.replace(folder)
        except BaseException:
            shutil.rmtree(temporary, ignore_errors=True)
            raise
    except OSError as error:
        raise ConfigurationError(f"Cannot write {folder}: {error.strerror or error}.") from error


def _umask() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return umask
