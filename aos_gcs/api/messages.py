"""Messages of the WebSocket ``/api/events``, a union discriminated by ``kind``.

A client receives ``hello`` first and then the mission's events. ``seq`` counts the messages of one connection from 1;
a gap says that events were lost to the client's own slowness, and that it should connect again for a new ``hello``.
Snapshots that a newer one has replaced before they could be sent leave no gap: nothing is lost with them.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from aos_gcs.api.models import MissionModel, NoticeModel, PictureModel, StepModel, WireModel


class HelloMessage(WireModel):
    """All that a client has to know to follow the events after it."""

    kind: Literal["hello"] = "hello"
    seq: int
    schema_version: int
    mission: MissionModel
    steps: list[StepModel]
    notices: list[NoticeModel]
    pictures: list[PictureModel]


class SnapshotMessage(WireModel):
    """The mission now."""

    kind: Literal["snapshot"] = "snapshot"
    seq: int
    utc_s: float
    mission: MissionModel


class StepMessage(WireModel):
    """A step was decided."""

    kind: Literal["step"] = "step"
    seq: int
    utc_s: float
    step: StepModel


class NoticeMessage(WireModel):
    """Something happened."""

    kind: Literal["notice"] = "notice"
    seq: int
    utc_s: float
    notice: NoticeModel


class PicturesMessage(WireModel):
    """New rasters can be fetched."""

    kind: Literal["pictures"] = "pictures"
    seq: int
    utc_s: float
    pictures: list[PictureModel]


class PlanMessage(WireModel):
    """The mission flies by another plan; ``GET /api/plan`` has it."""

    kind: Literal["plan"] = "plan"
    seq: int
    utc_s: float
    operator: str = Field(description="Who has applied it.")


class HeartbeatMessage(WireModel):
    """The connection is alive although nothing has happened. Does not count: ``seq`` is that of the message before."""

    kind: Literal["heartbeat"] = "heartbeat"
    seq: int


EventMessage = SnapshotMessage | StepMessage | NoticeMessage | PicturesMessage | PlanMessage

ServerMessage = Annotated[
    HelloMessage | SnapshotMessage | StepMessage | NoticeMessage | PicturesMessage | PlanMessage | HeartbeatMessage,
    Field(discriminator="kind"),
]

SERVER_MESSAGE: TypeAdapter[ServerMessage] = TypeAdapter(ServerMessage)
