"""Make a base map of tiles that a server sends, where its terms allow copies."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np

from aos_gcs.basemaps.archive import TileFormat, tile_archive
from aos_gcs.basemaps.making import BasemapReport, Progress, described, require_ending
from aos_gcs.basemaps.mercator import MAX_LATITUDE_DEG, MAX_ZOOM, WorldBox, from_degrees
from aos_gcs.basemaps.pyramid import Advance
from aos_gcs.basemaps.tiles.addresses import TileTemplate
from aos_gcs.basemaps.tiles.pictures import as_webp, kind_of
from aos_gcs.basemaps.tiles.requests import CONNECTIONS, Pace, TileRequests, tile_session
from aos_gcs.basemaps.tiles.store import Place, TileStore, tile_store
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra

MAX_TILES: Final = 20_000
"""Greatest number of tiles of a download, over all its zooms."""
MAX_ATTRIBUTION: Final = 200
"""Greatest number of characters of an attribution: as many as the page shows."""


@dataclass(frozen=True, slots=True)
class TileArea:
    """Tiles of a part of the world."""

    box: WorldBox
    min_zoom: int
    max_zoom: int

    @classmethod
    def checked(cls, degrees: tuple[float, float, float, float], min_zoom: int, max_zoom: int) -> TileArea:
        """Return the tiles of a rectangle.

        Args:
            degrees: western longitude, southern latitude, eastern longitude and northern latitude.
            min_zoom: coarsest zoom.
            max_zoom: finest zoom.

        Raises:
            ConfigurationError: it is no rectangle of the map, the zooms are none, or the tiles are too many.
        """
        west, south, east, north = degrees
        if not (-180.0 <= west < east <= 180.0 and -MAX_LATITUDE_DEG <= south < north <= MAX_LATITUDE_DEG):
            raise ConfigurationError(
                f"The area must be west,south,east,north in degrees, from -180 to 180 and from "
                f"-{MAX_LATITUDE_DEG:.0f} to {MAX_LATITUDE_DEG:.0f}; got {west:g},{south:g},{east:g},{north:g}."
            )
        if not 0 <= min_zoom <= max_zoom <= MAX_ZOOM:
            raise ConfigurationError(
                f"--zoom must be MIN-MAX within 0 to {MAX_ZOOM}, the smaller first; got {min_zoom}-{max_zoom}."
            )
        x, y = from_degrees(np.array([west, east]), np.array([south, north]))
        area = cls(WorldBox(float(x[0]), float(y[1]), float(x[1]), float(y[0])), min_zoom, max_zoom)
        if area.count > MAX_TILES:
            raise ConfigurationError(
                f"The area has {area.count:,} tiles of zooms {min_zoom} to {max_zoom}; {MAX_TILES:,} are allowed: "
                "give a smaller --area, or a smaller finest --zoom, of which each less is a quarter of the tiles."
            )
        return area

    @property
    def count(self) -> int:
        """Number of tiles."""
        return sum(len(columns) * len(rows) for columns, rows in map(self.box.tiles, self._zooms()))

    def places(self) -> Iterator[Place]:
        """Yield all tiles, coarse ones first."""
        for zoom in self._zooms():
            columns, rows = self.box.tiles(zoom)
            yield from ((zoom, column, row) for row, column in product(rows, columns))

    def _zooms(self) -> range:
        return range(self.min_zoom, self.max_zoom + 1)


def download_basemap(
    out: Path, template: TileTemplate, area: TileArea, attribution: str, *, pace: Pace, progress: Progress
) -> BasemapReport:
    """Make a PMTiles archive of the tiles of a server. What an interrupted run has got is not asked for again.

    Args:
        out: archive; an existing one is replaced when the new one is complete.
        template: addresses of the tiles.
        area: tiles to ask for.
        attribution: text that the server's terms ask for, shown on the map.
        pace: times of requests.
        progress: shows the tiles that are done.

    Raises:
        ConfigurationError: a name or a text cannot be used, a library is missing, the archive cannot be written, or the
            server refuses.
        InputDataError: what the server sends is no tile, it has none there, or tiles of an earlier run cannot be used.
        LinkError: the server does not answer.
        BaseExceptionGroup: one or several of these, while tiles are asked for.
    """
    require_ending(out)
    if not (attribution := attribution.strip()) or len(attribution) > MAX_ATTRIBUTION:
        raise ConfigurationError(
            f"--attribution needs the text that the terms of {template.host} ask for, of at most {MAX_ATTRIBUTION} "
            "characters: it is shown on the map."
        )
    for library in ("pmtiles.writer", "PIL.Image"):
        load_extra(library, "geo", "Copying tiles")
    with tile_store(out, template.fingerprint) as store:
        with progress(area.count) as advance:
            asyncio.run(_fetch(store, template, area, pace, advance))
        tiles = _write(out, store, template, area, attribution)
    return BasemapReport(tiles, area.min_zoom, area.max_zoom, out.stat().st_size)


async def _fetch(store: TileStore, template: TileTemplate, area: TileArea, pace: Pace, advance: Advance) -> None:
    """Ask for all tiles that the store lacks."""
    known = store.places()
    lacking = [place for place in area.places() if place not in known]
    advance(area.count - len(lacking))
    waiting = iter(lacking)
    async with tile_session() as session, asyncio.TaskGroup() as tasks:
        requests = TileRequests(template, session, pace)

        async def work() -> None:
            for place in waiting:
                _keep(store, template, place, await requests.tile(*place))
                advance(1)

        for _ in range(CONNECTIONS):
            tasks.create_task(work())


def _keep(store: TileStore, template: TileTemplate, place: Place, content: bytes) -> None:
    kind: TileFormat | None = None
    if content:
        try:
            kind = kind_of(content)
        except InputDataError as error:
            zoom, column, row = place
            raise InputDataError(
                f"{template.host}: what was sent for tile {zoom}/{column}/{row} {error}: check the address in --tiles."
            ) from error
    store.add(place, kind, content)


def _write(out: Path, store: TileStore, template: TileTemplate, area: TileArea, attribution: str) -> int:
    """Write an archive of one kind of tiles, and return their number."""
    wanted = set(area.places())
    kinds = {kind for place, kind, _ in store.tiles() if place in wanted}
    if not kinds:
        raise InputDataError(f"{template.host} has no tiles of this area and these zooms: check --area and --zoom.")
    is_mixed = len(kinds) > 1
    with tile_archive(out) as archive:
        for place, _, content in store.tiles():
            if place in wanted:
                archive.add(*place, as_webp(content) if is_mixed else content)
        archive.finish(TileFormat.WEBP if is_mixed else kinds.pop(), area.box, described(out, [attribution]))
    return archive.tiles
