"""Drops images into folders, as a companion computer does."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

from aos_gcs.errors import ConfigurationError


class ImageFolder:
    """Writes ``<system id>/<image index>.tiff`` below a folder; every file appears under its name when it is whole.

    Raises:
        ConfigurationError: on entering, if the folders cannot be made.
    """

    def __init__(self, folder: Path, system_ids: Iterable[int]) -> None:
        self._folders = {system_id: folder / str(system_id) for system_id in system_ids}

    async def __aenter__(self) -> Self:
        try:
            for folder in self._folders.values():
                folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(f"--image-folder: {error.filename} cannot be made ({error.strerror}).") from error
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the images where they are."""

    def publish(self, system_id: int, index: int, data: bytes) -> str:
        """Write an image and return its path."""
        path = self._folders[system_id] / f"{index:05d}.tiff"
        unfinished = path.with_suffix(".part")
        unfinished.write_bytes(data)
        unfinished.replace(path)
        return str(path)
