"""Check that a file is a base map that the dashboard can show.

Source: PMTiles Version 3 Specification, section 3 (header).
"""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Final

from aos_gcs.errors import ConfigurationError

MISSION_BASEMAP: Final = "basemap.pmtiles"
"""Name of the base map in a mission folder, which is shown where the configuration names none."""

_MAGIC: Final = b"PMTiles"
_VERSION: Final = 3
_HEADER: Final = struct.Struct("<7sB8Q3Q6B")
"""Header up to the zoom levels: magic, version, offsets and lengths of four sections, counts, flags, codes, zooms."""
_SECTIONS: Final = ("root directory", "metadata", "leaf directories", "tiles")
_COMPRESSIONS: Final = {1: "none", 2: "gzip", 3: "brotli", 4: "zstd"}
_DECOMPRESSED_BY_BROWSERS: Final = {"none", "gzip"}
_TILE_TYPES: Final = {1: "MVT", 2: "PNG", 3: "JPEG", 4: "WebP", 5: "AVIF"}
_URL: Final = re.compile(r"[a-z][a-z0-9+.-]+:/", re.IGNORECASE)
"""A scheme has two letters at least; one is a Windows drive."""


def check_basemap(file: Path) -> None:
    """Read a base map's header, and refuse files that the page cannot show.

    Raises:
        ConfigurationError: it is not a file on this machine, not a PMTiles archive of version 3, incomplete, or of a
            kind or compression that browsers do not read; the text says which, and the remedy.
    """
    if _URL.match(str(file)):
        raise ConfigurationError(
            f"api.basemap must be a file on this machine, not {file}: the dashboard loads nothing from a network. "
            "Download the archive, or the part of it that the mission needs, and name that file."
        )
    try:
        size = file.stat().st_size
        with file.open("rb") as archive:
            head = archive.read(_HEADER.size)
    except OSError as error:
        raise ConfigurationError(f"api.basemap cannot be read: {file}: {error.strerror or error}.") from error
    if len(head) < _HEADER.size or not head.startswith(_MAGIC):
        raise ConfigurationError(f"api.basemap: {file} is not a PMTiles archive; make one with aos-gcs basemap.")
    _, version, *numbers = _HEADER.unpack(head)
    if version != _VERSION:
        raise ConfigurationError(
            f"api.basemap: {file} is a PMTiles archive of version {version}; convert it to version {_VERSION}."
        )
    _check_sections(file, size, numbers[:8])
    _, internal, tiles, tile_type, *_ = numbers[11:]
    if tile_type not in _TILE_TYPES:
        known = ", ".join(_TILE_TYPES.values())
        raise ConfigurationError(f"api.basemap: the tiles of {file} are of the unknown type {tile_type}, not {known}.")
    for what, code in (("directories", internal), ("tiles", tiles)):
        compression = _COMPRESSIONS.get(code, f"unknown ({code})")
        if compression not in _DECOMPRESSED_BY_BROWSERS:
            raise ConfigurationError(
                f"api.basemap: the {what} of {file} have the compression {compression}, which browsers do not read; "
                "make the archive with gzip."
            )


def _check_sections(file: Path, size: int, places: list[int]) -> None:
    for name, offset, length in zip(_SECTIONS, places[::2], places[1::2], strict=True):
        if offset + length > size:
            raise ConfigurationError(
                f"api.basemap: {file} is incomplete: its {name} end at byte {offset + length}, but it has {size} "
                "bytes; copy it again."
            )
