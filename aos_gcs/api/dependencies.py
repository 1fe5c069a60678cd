"""What the routes need from the application, as injectable dependencies."""

from __future__ import annotations

from typing import Annotated, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from aos_gcs.api.access import Access, Session
from aos_gcs.api.hub import EventHub
from aos_gcs.mission.model import MissionControl


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
OperatorAccess = Annotated[Access, Depends(_get_access)]
CurrentSession = Annotated[Session, Depends(_get_session)]
