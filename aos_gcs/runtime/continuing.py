"""A sortie that continues the search of an earlier mission, whose record lies in a folder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from aos_gcs.config.model import ServiceConfig
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.groundmap.figures import view_raster
from aos_gcs.mission.next_sortie import NextSortie, carried_findings
from aos_gcs.runtime.recorded.searched_ground import read_searched_ground
from aos_gcs.store.reader import MissionReader


def continued_sortie(config: ServiceConfig, folder: Path) -> NextSortie:
    """Return the beginning of a sortie by a configuration that continues a mission: its map, findings and looks.

    Args:
        config: configuration of the sortie.
        folder: mission folder.

    Raises:
        ConfigurationError: the mission had another origin, or searched another area; the text names both.
        InputDataError: the folder holds no map of searched ground, or is damaged.
    """
    ground, settings = read_searched_ground(folder), mission_settings(config)
    if settings.origin is not None and settings.origin != ground.origin:
        raise ConfigurationError(
            f"--continue {folder}: that mission had the origin {_place(ground.origin)}, but the configuration has "
            f"{_place(settings.origin)}. Take over its origin as mission.origin_deg, or leave that out."
        )
    both = view_raster({}, (*ground.area_enu_m, *settings.area_enu_m))
    # Without an area, the mission waits for a plan.
    if settings.area_enu_m and not (both.inside(ground.area_enu_m) & both.inside(settings.area_enu_m)).any():
        raise ConfigurationError(
            f"--continue {folder}: that mission searched another area, which this one's search area does not meet. "
            "Continue a mission of this area, or leave --continue out."
        )
    with MissionReader(folder) as reader:
        manifest, last = reader.manifest(), reader.last_snapshot()
    number, operation, mission_id = manifest.get("sortie", 1), manifest.get("operation"), folder.resolve().name
    return NextSortie(
        settings=replace(settings, origin=ground.origin),
        findings=() if last is None else carried_findings(last.findings, mission_id),
        left_for_later=() if last is None else last.left_for_later,
        former_id=mission_id,
        number=(number if isinstance(number, int) else 1) + 1,
        operation=operation if isinstance(operation, str) else mission_id,
        text=f"The map of searched ground and the findings of mission {mission_id} go on.",
        folder=folder.resolve(),
    )


def _place(position: GeodeticPosition) -> str:
    """Return a position as the configuration has it."""
    return f"[{position.latitude_deg}, {position.longitude_deg}, {position.altitude_amsl_m}]"
