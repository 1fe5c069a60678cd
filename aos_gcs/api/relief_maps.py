"""The relief about the mission, made once for all clients, in a thread beside the loop."""

from __future__ import annotations

import asyncio
import hashlib
from dataclasses import dataclass

from aos_gcs.api.convert import relief as convert
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.planning.settings import TerrainSettings
from aos_gcs.planning.terrain.ground import EnuBounds, file_versions
from aos_gcs.planning.terrain.relief import HeightUnit, Relief, contours, read_relief, relief_bounds, shading_png


@dataclass(frozen=True, slots=True)
class ReliefMap:
    """Heights and shading of one place."""

    version: str
    """Changes whenever they do."""
    origin: GeodeticPosition
    relief: Relief
    shading_png: bytes


class ReliefMaps:
    """The relief map that was asked for last: about one mission, all clients want the same."""

    def __init__(self) -> None:
        self._turn = asyncio.Lock()
        self._made: ReliefMap | None = None
        self._contours_json: dict[HeightUnit, bytes] = {}
        """Contour lines of the relief that was made last, by the unit of their heights."""

    async def about(self, snapshot: MissionSnapshot, terrain: TerrainSettings | None) -> ReliefMap | None:
        """Return the relief map of a mission; None without an elevation model or an origin.

        Raises:
            ConfigurationError: a setting of the model cannot be used, or a library is missing.
            InputDataError: a file of the model cannot be used or read, or has no heights there.
        """
        origin = snapshot.origin
        if terrain is None or origin is None:
            return None
        bounds = relief_bounds([*_homes_enu_m(snapshot, origin), *snapshot.area_enu_m, *snapshot.fence_enu_m])
        # One at a time: whoever comes meanwhile gets what was made.
        async with self._turn:
            version = await asyncio.to_thread(_version, terrain, origin, bounds)
            if self._made is None or self._made.version != version:
                self._made = await asyncio.to_thread(_make, version, terrain, origin, bounds)
                self._contours_json.clear()
            return self._made

    async def contours_json(self, made: ReliefMap, unit: HeightUnit) -> bytes:
        """Return the contour lines of a relief map as they are sent.

        Raises:
            ConfigurationError: a library is missing.
        """
        async with self._turn:
            if made is not self._made:  # it was replaced meanwhile
                return await asyncio.to_thread(_contours_json, made, unit)
            if unit not in self._contours_json:
                self._contours_json[unit] = await asyncio.to_thread(_contours_json, made, unit)
            return self._contours_json[unit]


def _homes_enu_m(snapshot: MissionSnapshot, origin: GeodeticPosition) -> list[tuple[float, float]]:
    frame = LocalFrame(origin)
    places = [frame.to_enu(home) for vehicle in snapshot.vehicles if (home := vehicle.telemetry.home) is not None]
    return [(float(east_m), float(north_m)) for east_m, north_m, _ in places]


def _version(terrain: TerrainSettings, origin: GeodeticPosition, bounds: EnuBounds) -> str:
    key = repr((terrain, file_versions(terrain), origin, bounds))
    return hashlib.blake2b(key.encode(), digest_size=8).hexdigest()


def _make(version: str, terrain: TerrainSettings, origin: GeodeticPosition, bounds: EnuBounds) -> ReliefMap:
    relief = read_relief(terrain, origin, bounds)
    return ReliefMap(version, origin, relief, shading_png(relief))


def _contours_json(made: ReliefMap, unit: HeightUnit) -> bytes:
    lines = convert.contours(contours(made.relief, unit), made.relief.bounds, made.origin)
    return lines.model_dump_json().encode()
