"""Messages of the WebSocket ``/api/events``, a union discriminated by ``kind``; clients send ``HoldMessage`` only.

A client receives ``hello`` first: the whole state. Then come *events* (``step``, ``notice``, ``pictures``, ``plan``),
which are never repeated, and the *state*, of which only changes are sent.

``seq`` counts events from 1 and is the same for all clients; every other message carries the number of the event
before it. A step of more than one says that events were lost to the client's own slowness, or while it was away: it
fetches them with ``GET /api/events?after=SEQ``. State is never lost: slow clients get fewer and larger changes.

An answer of the service does not prove that the mission is alive. Every message about the state therefore has the age
of the mission's own last sign of life: ``mission_age_s``.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter

from aos_gcs.api.models.base import ErrorModel, WireModel
from aos_gcs.api.models.mission import ActionResponse, MissionModel
from aos_gcs.api.models.notices import NoticeModel
from aos_gcs.api.models.preflight import PreflightCheckModel
from aos_gcs.api.models.service import CapabilitiesModel
from aos_gcs.api.models.steps import PictureModel, StepFiguresModel, StepModel

SCHEMA_VERSION = 5
"""Raised when a client written for the earlier number would misread a message."""
SEEN = "State that this message shows: a command that was given by it carries this text in its header X-Seen."
MISSION_AGE = "Seconds since the mission's last sign of life; 0 in a replay, where time may stand still."


class HelloMessage(WireModel):
    """All that a client has to know to follow the messages after it. Comes again when a replay has jumped."""

    kind: Literal["hello"] = "hello"
    seq: int
    schema_version: int
    mission_age_s: float = Field(description=MISSION_AGE)
    seen: str = Field(description=SEEN)
    capabilities: CapabilitiesModel
    mission: MissionModel
    steps: list[StepFiguresModel] = Field(description="Figures of all steps so far, oldest first.")
    latest_step: StepModel | None = Field(description="The latest of them as a whole; null before the first one.")
    notices: list[NoticeModel]
    pictures: list[PictureModel]


class SnapshotMessage(WireModel):
    """The whole mission now, for a client that has missed too many changes."""

    kind: Literal["snapshot"] = "snapshot"
    seq: int
    mission_age_s: float = Field(description=MISSION_AGE)
    seen: str = Field(description=SEEN)
    utc_s: float
    mission: MissionModel


class ChangesMessage(WireModel):
    """Changes in the mission since the previous message; fields that are not named are unchanged."""

    kind: Literal["changes"] = "changes"
    seq: int
    mission_age_s: float = Field(description=MISSION_AGE)
    seen: str = Field(description=SEEN)
    utc_s: float
    mission: dict[str, Any] = Field(
        description="Fields of MissionModel with their new values; vehicles never, preflight only where checks have "
        "come or gone."
    )
    vehicles: list[dict[str, Any]] = Field(
        description="For each vehicle that has changed: vehicle_id, and the fields of VehicleModel with new values. "
        "An id that was not there before is a new vehicle with all of its fields."
    )
    preflight: list[PreflightCheckModel] = Field(
        description="Checks that have changed, to be replaced by vehicle_id and name, after the fields of mission."
    )


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
    """Another plan was applied; ``GET /api/plan`` returns it."""

    kind: Literal["plan"] = "plan"
    seq: int
    utc_s: float
    operator: str = Field(description="Operator who applied it.")


class HeartbeatMessage(WireModel):
    """The connection is alive although nothing has changed; ``mission_age_s`` tells whether the mission is."""

    kind: Literal["heartbeat"] = "heartbeat"
    seq: int
    mission_age_s: float = Field(description=MISSION_AGE)
    seen: str = Field(description=SEEN)


class AnswerMessage(WireModel):
    """The answer to a request on this connection; only the client that has sent it gets it."""

    kind: Literal["answer"] = "answer"
    request_id: str
    status: int = Field(description="As the status of an answer over HTTP.")
    response: ActionResponse | None = Field(description="Null where it was refused.")
    error: ErrorModel | None = Field(description="Reason of a refusal.")


class HoldMessage(WireModel):
    """Sent by clients: hold all vehicles. Operators send it beside ``POST /api/mission/actions``, by the same name.

    Browsers open few connections to one host, and requests wait for them; this one is open already.
    """

    kind: Literal["hold"]
    request_id: str = Field(min_length=8, max_length=64)


EventMessage = StepMessage | NoticeMessage | PicturesMessage | PlanMessage

ServerMessage = Annotated[
    HelloMessage
    | SnapshotMessage
    | ChangesMessage
    | StepMessage
    | NoticeMessage
    | PicturesMessage
    | PlanMessage
    | AnswerMessage
    | HeartbeatMessage,
    Field(discriminator="kind"),
]

SERVER_MESSAGE: TypeAdapter[ServerMessage] = TypeAdapter(ServerMessage)


class MissedEventsModel(WireModel):
    """The events after a number, or where these are no longer kept the whole state instead."""

    mission_id: str = Field(description="Mission that the numbers belong to.")
    seq: int = Field(description="Number of the latest event.")
    events: list[Annotated[EventMessage, Field(discriminator="kind")]]
    hello: HelloMessage | None = Field(description="Null where events are complete.")
