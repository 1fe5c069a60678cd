"""Drops images into folders, as a companion computer does."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Self

from aos_gcs.errors import ConfigurationError


class ImageFolder:
    """Writes ``<system id>/<image index>.tiff`` below a folder; every file appears under its name when it is whole.

    Raises:
        ConfigurationError: on entering, if the folder cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    async def __aenter__(self) -> Self:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(f"--image-folder {self._folder} cannot be made: {error.strerror}.") from error
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the images where they are."""

    def publish(self, system_id: int, index: int, data: bytes) -> str:
        """Write an image and return its path."""
        path = self._folder / str(system_id) / f"{index:05d}.tiff"
        path.parent.mkdir(exist_ok=True)
        unfinished = path.with_suffix(".part")
        unfinished.write_bytes(data)
        unfinished.replace(path)
        return str(path)
