"""Injectable dependencies of the routes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, cast

from fastapi import Depends, Header, Query
from starlette.requests import HTTPConnection

from aos_gcs.api.access.desk import AccountDesk
from aos_gcs.api.access.operators import Access
from aos_gcs.api.access.plan_check_turns import PlanChecks
from aos_gcs.api.access.roles import Session
from aos_gcs.api.control_desk import ControlDesk
from aos_gcs.api.convert.seen import parse_seen
from aos_gcs.api.convert.wall import WallMessages
from aos_gcs.api.errors import NotFoundError, SeenMissingError
from aos_gcs.api.events.hub import EventHub
from aos_gcs.api.once import Once
from aos_gcs.api.relief_maps import ReliefMaps
from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.handover.model import HandoverControl
from aos_gcs.mission.control import FindingCommands, MissionCommands, MissionView, ReplayControl
from aos_gcs.mission.model.actions import Seen
from aos_gcs.mission.viewing import OperationView, SortieChoice, ViewControl
from aos_gcs.planning.settings import TerrainSettings
from aos_gcs.store.plan_folder import PlanFolder
from aos_gcs.wall.board import Wall
from aos_gcs.wall.video import VideoControl

_SEEN = "State of the mission by which this command is given: `seen` of an event, or this header of GET /api/mission."


def known_origin(mission: MissionView) -> GeodeticPosition:
    """Return the mission's origin.

    Raises:
        MissionError: it is not known yet.
    """
    origin = mission.snapshot().origin
    if origin is None:
        raise MissionError("The mission's origin is not known yet: wait until a vehicle has reported its home.")
    return origin


def _get_mission(connection: HTTPConnection) -> MissionView:
    return cast("MissionView", connection.app.state.mission)


def _get_commands(connection: HTTPConnection) -> MissionCommands | None:
    return cast("MissionCommands | None", connection.app.state.commands)


def commands_of(connection: HTTPConnection) -> MissionCommands:
    """Return the commands to the mission.

    Raises:
        MissionError: it is only shown.
    """
    commands = _get_commands(connection)
    if commands is None:
        raise MissionError("This service only shows a mission: it cannot be commanded or changed.")
    return commands


def _get_finding_commands(connection: HTTPConnection) -> FindingCommands:
    findings = cast("FindingCommands | None", connection.app.state.findings)
    if findings is None:
        raise MissionError("This service only shows a mission: its findings cannot be changed.")
    return findings


def _get_hub(connection: HTTPConnection) -> EventHub:
    return cast("EventHub", connection.app.state.hub)


def access_of(connection: HTTPConnection) -> Access:
    """Return who is signed in."""
    return cast("Access", connection.app.state.access)


def _get_desk_if_any(connection: HTTPConnection) -> AccountDesk | None:
    return cast("AccountDesk | None", connection.app.state.desk)


def _get_desk(connection: HTTPConnection) -> AccountDesk:
    desk = _get_desk_if_any(connection)
    if desk is None:
        raise NotFoundError("This service has no accounts; see api.accounts in docs/configuration.md.")
    return desk


def session_of(connection: HTTPConnection) -> Session:
    """Return the session of a request or WebSocket."""
    return access_of(connection).session_of(connection)


async def _get_session(connection: HTTPConnection) -> Session:
    return session_of(connection)  # in the loop, whose clock it needs, and not in a thread


def control_of(connection: HTTPConnection) -> ControlDesk:
    """Return what changes who has control.

    Raises:
        MissionError: nothing can be commanded.
    """
    commands_of(connection)
    return cast("ControlDesk", connection.app.state.control)


async def _claim(connection: HTTPConnection) -> None:
    """Refuse a command while another operator has control."""
    await control_of(connection).claim(session_of(connection))


def _get_seen(x_seen: Annotated[str | None, Header(description=_SEEN)] = None) -> Seen | None:
    return None if x_seen is None else parse_seen(x_seen)


def require_seen(seen: Annotated[Seen | None, Depends(_get_seen)]) -> Seen:
    """Return the state that a command names, or raise ``SeenMissingError``."""
    if seen is None:
        raise SeenMissingError(
            "The header X-Seen is missing: it names the state of the mission by which you command. "
            "Send what GET /api/mission has returned in it."
        )
    return seen


SeenState = Annotated[Seen, Depends(require_seen)]
SeenStateIfAny = Annotated[Seen | None, Depends(_get_seen)]
Mission = Annotated[MissionView, Depends(_get_mission)]
Commands = Annotated[MissionCommands, Depends(commands_of)]
CommandsIfAny = Annotated[MissionCommands | None, Depends(_get_commands)]
FindingChanges = Annotated[FindingCommands, Depends(_get_finding_commands)]
Hub = Annotated[EventHub, Depends(_get_hub)]


def once_of(connection: HTTPConnection) -> Once:
    """Return what carries out copies of requests once."""
    return cast("Once", connection.app.state.once)


def _get_replay(connection: HTTPConnection) -> ReplayControl:
    replay = cast("ReplayControl | None", connection.app.state.replay)
    if replay is None:
        raise NotFoundError("This is a live mission, not a replay.")
    return replay


def _get_sortie_choice(connection: HTTPConnection) -> SortieChoice | None:
    return cast("SortieChoice | None", connection.app.state.sortie_choice)


def _get_operation(connection: HTTPConnection) -> OperationView:
    operation = cast("OperationView | None", connection.app.state.operation)
    if operation is None:
        raise NotFoundError("This mission is not recorded; there is no operation that it belongs to.")
    return operation


async def viewer_of(connection: HTTPConnection, mission_id: str) -> ViewControl:
    """Return the views of the recorded frames of a mission of the operation; those of the shown one for no name.

    Raises:
        NotFoundError: nothing is recorded, or the operation has no such mission.
    """
    viewer = cast("ViewControl | None", connection.app.state.viewer)
    if viewer is None:
        raise NotFoundError("This mission is not recorded; there are no frames to show.")
    operation = cast("OperationView | None", connection.app.state.operation)
    shown_id = _get_mission(connection).snapshot().mission_id
    if operation is None:
        found = viewer if mission_id in ("", shown_id) else None
    else:
        found = await operation.viewer(mission_id or shown_id)
    if found is None:
        raise NotFoundError(f"The operation has no mission {mission_id or shown_id}; there are no frames to show.")
    return found


async def _get_viewer(
    connection: HTTPConnection,
    mission_id: Annotated[
        str, Query(max_length=200, description="A mission of the operation; none: the one shown.")
    ] = "",
) -> ViewControl:
    return await viewer_of(connection, mission_id)


def _get_handovers(connection: HTTPConnection) -> HandoverControl:
    handovers = cast("HandoverControl | None", connection.app.state.handovers)
    if handovers is None:
        raise NotFoundError("This mission is not recorded; there is nothing to hand over.")
    return handovers


def wall_of(connection: HTTPConnection) -> Wall | None:
    """Return the live pictures; None where there are none."""
    return cast("Wall | None", connection.app.state.wall)


def wall_messages_of(connection: HTTPConnection) -> WallMessages:
    """Return the messages to viewers of the live pictures, which there must be."""
    return cast("WallMessages", connection.app.state.wall_messages)


def _get_videos(connection: HTTPConnection) -> VideoControl:
    videos = cast("VideoControl | None", connection.app.state.videos)
    if videos is None:
        raise NotFoundError("This mission is not recorded; there are no pictures for a video.")
    return videos


def _get_plans(connection: HTTPConnection) -> PlanFolder:
    return cast("PlanFolder", connection.app.state.plans)


def _get_plan_checks(connection: HTTPConnection) -> PlanChecks:
    return cast("PlanChecks", connection.app.state.plan_checks)


def _get_basemap_file(connection: HTTPConnection) -> Path | None:
    return cast("Path | None", connection.app.state.basemap_file)


def _get_terrain(connection: HTTPConnection) -> TerrainSettings | None:
    commands = cast("MissionCommands | None", connection.app.state.commands)
    recorded = cast("TerrainSettings | None", connection.app.state.terrain)
    return recorded if commands is None else commands.settings.terrain


def _get_reliefs(connection: HTTPConnection) -> ReliefMaps:
    return cast("ReliefMaps", connection.app.state.reliefs)


BasemapFile = Annotated[Path | None, Depends(_get_basemap_file)]
OnceOnly = Annotated[Once, Depends(once_of)]
Operation = Annotated[OperationView, Depends(_get_operation)]
ChosenSortie = Annotated[SortieChoice | None, Depends(_get_sortie_choice)]
Terrain = Annotated[TerrainSettings | None, Depends(_get_terrain)]
Reliefs = Annotated[ReliefMaps, Depends(_get_reliefs)]
Replay = Annotated[ReplayControl, Depends(_get_replay)]
Viewer = Annotated[ViewControl, Depends(_get_viewer)]
Handovers = Annotated[HandoverControl, Depends(_get_handovers)]
Videos = Annotated[VideoControl, Depends(_get_videos)]
Checks = Annotated[PlanChecks, Depends(_get_plan_checks)]
Plans = Annotated[PlanFolder, Depends(_get_plans)]
ControlOfSwarm = Annotated[ControlDesk, Depends(control_of)]
IN_CONTROL = Depends(_claim)
Desk = Annotated[AccountDesk, Depends(_get_desk)]
DeskIfAny = Annotated[AccountDesk | None, Depends(_get_desk_if_any)]
OperatorAccess = Annotated[Access, Depends(access_of)]
CurrentSession = Annotated[Session, Depends(_get_session)]
