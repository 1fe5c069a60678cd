"""Live pictures of a mission, rendered in a process of their own while somebody watches."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from aos_gcs.api.events.hub import loop_time_s
from aos_gcs.clock import machine_utc_s
from aos_gcs.config.model import ApiConfig
from aos_gcs.mission.control import MissionView
from aos_gcs.runtime.processes.workers import WALL
from aos_gcs.wall.board import Wall
from aos_gcs.wall.model import WallSettings
from aos_gcs.wall.source import ReplayedTime, WallSource
from aos_gcs.workers.process import open_worker


def make_wall(
    mission: MissionView, folder: Callable[[], Path], config: ApiConfig, replay: ReplayedTime | None = None
) -> Wall:
    """Return the live pictures of a mission by its record; the dashboard's application runs it.

    Args:
        mission: mission that is shown.
        folder: returns its folder.
        config: rate and sizes.
        replay: replay of the mission; None for one in flight.
    """
    settings = WallSettings(config.wall_rate_hz, config.wall_width_px, config.wall_follow_width_px)
    source = WallSource(mission, folder, machine_utc_s, replay)
    return Wall(source, partial(open_worker, WALL), settings, loop_time_s)
