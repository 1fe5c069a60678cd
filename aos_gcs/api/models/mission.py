"""Wire models of the mission as a whole and of operators' actions."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.models.base import GeodeticModel, ScanLegModel, VertexModel, WireModel
from aos_gcs.api.models.control import ControlModel
from aos_gcs.api.models.findings import FindingModel, LeftPlaceModel, TargetModel
from aos_gcs.api.models.notices import AcknowledgementModel
from aos_gcs.api.models.preflight import PreflightCheckModel
from aos_gcs.api.models.proposals import ProposalModel
from aos_gcs.api.models.replay import ReplayModel
from aos_gcs.api.models.sharing import ChannelModel
from aos_gcs.api.models.vehicles import VehicleModel
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.steps import FocusSource


class FocusModel(WireModel):
    """The focal plane in use."""

    height_m: float = Field(description="Height above the origin.")
    source: FocusSource
    sigma_m: float | None = Field(description="Standard deviation of the result of autofocus.")


class DetectionModel(WireModel):
    """Mean probability, per cent, that a person of each posture in the search area would have been marked by now."""

    standing: float
    sitting: float
    lying: float


class SegmentModel(WireModel):
    """Figures of a segment after all flights on the map of searched ground."""

    name: str
    hectares: float
    seen_percent: float = Field(description="Share that was seen from at least one direction.")
    detection_percent: float | None = Field(description="Of a standing person; null where the forest is not described.")
    probability_percent: float | None = Field(description="Prior probability of the segment; null without a prior.")
    success_percent: float | None = Field(
        description="Probability that the person is there and would have been marked by now; null without a prior."
    )


class GroundModel(WireModel):
    """Searched ground, by the map of it: this sortie and those before it."""

    frames: int
    left_out: int = Field(description="Frames of this mission that are not on the map.")
    seen_percent: float = Field(description="Share of the search area that was seen from at least one direction.")
    mean_views: float = Field(description="Mean number of independent views over the search area.")
    detection_percent: DetectionModel | None = Field(description="Null where the forest is not described.")
    soon_percent: float | None = Field(
        description="The same for a standing person after ten more minutes of flight where they gain most; null where "
        "that is not known."
    )
    success_percent: float | None = Field(
        description="Probability that the person is in the area and would have been marked; null without a prior."
    )
    segments: list[SegmentModel] = Field(description="Segments that the configuration names.")


class MissionModel(WireModel):
    """The whole mission at one moment."""

    mission_id: str
    strategy: str
    phase: Phase
    suspension: Suspension
    outcome: Outcome
    message: str
    elapsed_s: float
    started_utc_s: float | None = Field(
        description="Start in seconds since the Unix epoch, so that mission times can be told as clock times; null "
        "before the start and in surveys."
    )
    step: int
    origin: GeodeticModel | None
    area: list[VertexModel]
    fence: list[VertexModel]
    no_go: list[list[VertexModel]]
    legs: list[ScanLegModel] = Field(description="Legs of the scan; empty before they are planned.")
    leg: int = Field(description="Index of the leg being flown.")
    covered_percent: float | None = Field(
        description="Share of the search area that has been in a frame at least once."
    )
    ground: GroundModel | None = Field(description="What has been searched; null before the first figures.")
    scan_left_s: float | None = Field(
        description="Time that the rest of the legs takes at the pace so far; null before that is known."
    )
    vehicles: list[VehicleModel]
    planned_vehicles: int = Field(description="Number of vehicles that fly by the plan.")
    preflight: list[PreflightCheckModel]
    target: TargetModel | None = Field(description="Target in view, or else the one that was seen last.")
    targets: list[TargetModel] = Field(description="All confirmed targets, and the target.")
    left_for_later: list[LeftPlaceModel] = Field(
        description="Places in view that the swarm has flown past, to be looked at behind the last leg."
    )
    min_separation_m: float | None
    focus: FocusModel | None
    findings: list[FindingModel] = Field(description="Oldest first.")
    acknowledgements: list[AcknowledgementModel] = Field(
        description="Latest acknowledgements, by the number of their notice: the same for all operators."
    )
    command_count: int = Field(description="Number of the latest operator's command that was carried out.")
    sharing: list[ChannelModel] = Field(description="Systems that data is shared with live; empty without any.")
    proposals: list[ProposalModel] = Field(
        description="Marks and drawings that others propose for the plan, oldest first."
    )
    control: ControlModel | None = Field(
        description="Who of several operators commands; null where nobody signs in or nothing can be commanded."
    )
    replay: ReplayModel | None = Field(description="Replay that is shown; null for a live mission.")
    allowed_actions: list[Action] = Field(description="Actions worth offering now; a request can still be refused.")


SystemId = Annotated[int, Field(strict=True, ge=1, le=255)]


class ActionRequest(WireModel):
    """An operator's action for the vehicles named, or for the whole mission when ``vehicle_ids`` is null."""

    action: Action
    vehicle_ids: Annotated[list[SystemId], Field(min_length=1, max_length=255)] | None = None
    focal_height_m: Annotated[float, Field(strict=True, allow_inf_nan=False)] | None = Field(
        None, description="For the action focus: metres above the origin, or null for autofocus."
    )
    request_id: str | None = Field(
        None,
        min_length=8,
        max_length=64,
        description="Name of this request, which nobody else uses: what arrives again under it, here or on the event "
        "stream, gets the same answer and is not carried out again.",
    )


class ActionResultModel(WireModel):
    """Result of an action for one vehicle."""

    vehicle_id: int
    accepted: bool
    text: str


class ActionResponse(WireModel):
    """Results of an action, vehicle by vehicle."""

    action: Action
    results: list[ActionResultModel]
