"""The simulator's truth about a world, as a file: read, and refused where it tells of another world."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.walks import Walk
from aos_gcs.mission.model.snapshot import MissionSnapshot

_CLOCKS_APART_S = 60.0
"""Difference of the clocks of simulation and service that is no reason to refuse a file."""
_REMEDY = "Name the file that the simulator wrote for this mission."


def read_world(path: Path) -> dict[str, Any]:
    """Return the fields of a world file.

    Raises:
        InputDataError: the file cannot be read, or a field of it; the message names it.
    """
    try:
        world: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        missing = {"origin", "seed", "trees_per_ha", "targets"} - world.keys()
    except OSError as error:
        raise InputDataError(f"The world file {path} cannot be read: {error.strerror}.") from error
    except (ValueError, AttributeError) as error:
        raise InputDataError(f"{path} is not a world file of the simulator: {error}.") from error
    if missing:
        raise InputDataError(f"{path} is not a world file of the simulator: it lacks {', '.join(sorted(missing))}.")
    for name, read in _READERS.items():
        try:
            read(world.get(name, ()))
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputDataError(
                f"{path} is not a world file of the simulator: {name} cannot be read ({error})."
            ) from error
    return world


def check_world(path: Path, world: Mapping[str, Any], last: MissionSnapshot) -> None:
    """Refuse the truth about a world that the mission has not searched.

    Args:
        path: world file.
        world: its fields.
        last: last snapshot of the mission.

    Raises:
        InputDataError: the world has other vehicles or began after the mission, or their search areas lie apart.
    """
    _check_area(path, world, last)
    _check_vehicles(path, world, last)
    if last.started_utc_s is None:
        return
    later_s = float(world.get("start_utc_s") or 0.0) - (last.started_utc_s + last.elapsed_s)
    if later_s > _CLOCKS_APART_S:
        raise InputDataError(
            f"{path} is the truth about another world: its start_utc_s is {later_s:.0f} s after the mission's end. "
            f"{_REMEDY}"
        )


def _check_area(path: Path, world: Mapping[str, Any], snapshot: MissionSnapshot) -> None:
    if not world.get("area_enu_m") or not snapshot.area_enu_m or snapshot.origin is None:
        return
    frame, mission_frame = LocalFrame(GeodeticPosition(**world["origin"])), LocalFrame(snapshot.origin)
    corners = [
        mission_frame.to_enu(frame.to_geodetic((east_m, north_m, 0.0))) for east_m, north_m in world["area_enu_m"]
    ]
    area_m, searched_m = np.array(corners)[:, :2], np.array(snapshot.area_enu_m)[:, :2]
    apart_m = np.maximum(area_m.min(axis=0) - searched_m.max(axis=0), searched_m.min(axis=0) - area_m.max(axis=0))
    if apart_m.max() > 0.0:
        raise InputDataError(
            f"{path} is the truth about another world: its area_enu_m lies {apart_m.max():.0f} m outside the search "
            f"area of the mission. {_REMEDY}"
        )


def _check_vehicles(path: Path, world: Mapping[str, Any], last: MissionSnapshot) -> None:
    """Compare the flight controllers, whose identifiers are drawn by the world's seed."""
    boards = _board_ids(world.get("vehicles", ()))
    for state in (one.telemetry for one in last.vehicles):
        board_id = boards.get(state.vehicle_id, "")
        if board_id and state.board_id and board_id != state.board_id:
            raise InputDataError(
                f"{path} is the truth about another world: by its vehicles, the flight controller of vehicle "
                f"{state.vehicle_id} is {board_id}, but that of the mission is {state.board_id}. {_REMEDY}"
            )


def _board_ids(vehicles: Any) -> dict[int, str]:
    """Return the identifiers of a world's flight controllers by system id, as far as it knows them."""
    return {int(one["system_id"]): str(one.get("board_id", "")) for one in vehicles}


def _numbers(points: Any, count: int) -> None:
    for point in points:
        if len([float(number) for number in point]) != count:
            raise ValueError(f"{point} must be {count} numbers")


def _targets(targets: Any) -> None:
    _numbers([target["position_enu_m"] for target in targets], 3)
    for target in targets:
        if target.get("walk") is not None:
            Walk(**{key: float(value) for key, value in target["walk"].items()})


_READERS: Mapping[str, Callable[[Any], object]] = {
    "origin": GeodeticPosition.from_fields,
    "seed": range,
    "trees_per_ha": float,
    "targets": _targets,
    "start_utc_s": lambda start: float(start or 0.0),
    "vehicles": _board_ids,
    "area_enu_m": lambda area: _numbers(area, 2),
}
"""Readers of the fields of a world file, which fail where one is not what it should be."""
