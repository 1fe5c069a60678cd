"""What the routes need from the application, as injectable dependencies."""

from __future__ import annotations

from typing import Annotated, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from aos_gcs.api.hub import EventHub
from aos_gcs.mission.model import MissionControl


def _get_mission(connection: HTTPConnection) -> MissionControl:
    return cast("MissionControl", connection.app.state.mission)


def _get_hub(connection: HTTPConnection) -> EventHub:
    return cast("EventHub", connection.app.state.hub)


Mission = Annotated[MissionControl, Depends(_get_mission)]
Hub = Annotated[EventHub, Depends(_get_hub)]
