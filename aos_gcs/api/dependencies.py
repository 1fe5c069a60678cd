"""Injectable dependencies of the routes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from aos_gcs.api.access.operators import Access, Session
from aos_gcs.api.access.plan_check_turns import PlanChecks
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.events.hub import EventHub
from aos_gcs.errors import MissionError
from aos_gcs.mission.control import FindingControl, MissionControl, PlanControl, ReplayControl
from aos_gcs.mission.viewing import ViewControl
from aos_gcs.store.plan_folder import PlanFolder


def _get_mission(connection: HTTPConnection) -> MissionControl:
    return cast("MissionControl", connection.app.state.mission)


def _get_hub(connection: HTTPConnection) -> EventHub:
    return cast("EventHub", connection.app.state.hub)


def _get_access(connection: HTTPConnection) -> Access:
    return cast("Access", connection.app.state.access)


def _get_session(connection: HTTPConnection) -> Session:
    return _get_access(connection).session_of(connection)


Mission = Annotated[MissionControl, Depends(_get_mission)]
Hub = Annotated[EventHub, Depends(_get_hub)]


def _get_planning(connection: HTTPConnection) -> PlanControl:
    planning = cast("PlanControl | None", connection.app.state.planning)
    if planning is None:
        raise MissionError("Planning is not available: this service only shows a mission.")
    return planning


def _get_replay(connection: HTTPConnection) -> ReplayControl:
    replay = cast("ReplayControl | None", connection.app.state.replay)
    if replay is None:
        raise NotFoundError("This is a live mission, not a replay.")
    return replay


def _get_viewer(connection: HTTPConnection) -> ViewControl:
    viewer = cast("ViewControl | None", connection.app.state.viewer)
    if viewer is None:
        raise NotFoundError("This mission is not recorded; there are no frames to show.")
    return viewer


def _get_findings(connection: HTTPConnection) -> FindingControl:
    findings = cast("FindingControl | None", connection.app.state.findings)
    if findings is None:
        raise MissionError("Findings cannot be changed: this service only shows a mission.")
    return findings


def _get_plans(connection: HTTPConnection) -> PlanFolder:
    return cast("PlanFolder", connection.app.state.plans)


def _get_plan_checks(connection: HTTPConnection) -> PlanChecks:
    return cast("PlanChecks", connection.app.state.plan_checks)


def _get_basemap_file(connection: HTTPConnection) -> Path | None:
    return cast("Path | None", connection.app.state.basemap_file)


BasemapFile = Annotated[Path | None, Depends(_get_basemap_file)]
Planning = Annotated[PlanControl, Depends(_get_planning)]
Replay = Annotated[ReplayControl, Depends(_get_replay)]
Viewer = Annotated[ViewControl, Depends(_get_viewer)]
Findings = Annotated[FindingControl, Depends(_get_findings)]
Checks = Annotated[PlanChecks, Depends(_get_plan_checks)]
Plans = Annotated[PlanFolder, Depends(_get_plans)]
OperatorAccess = Annotated[Access, Depends(_get_access)]
CurrentSession = Annotated[Session, Depends(_get_session)]
