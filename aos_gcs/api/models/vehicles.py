"""Wire models of vehicles, with their links and cameras."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import PositionModel, VertexModel, WireModel
from aos_gcs.mission.model import Task
from aos_gcs.ports import FlightMode, LandedState


class LinkModel(WireModel):
    """How well a vehicle is reached; its packet loss and age stand in VehicleModel."""

    address: str = Field(description="Where it is spoken to now.")
    living_addresses: int = Field(description="At how many addresses, on all links together, it is being heard.")
    round_trip_ms: float | None
    clock_offset_ms: float | None = Field(description="The vehicle's clock minus ours.")
    clock_drift_ppm: float | None = Field(description="What the vehicle's clock gains on ours.")


class VehicleCameraModel(WireModel):
    """What a vehicle's camera has delivered in this mission."""

    frames: int = Field(description="That could be used.")
    failures: int = Field(description="Steps that went on without its frame.")
    last_step: int | None
    footprint: list[VertexModel] = Field(
        description="What its latest frame shows of the focal plane; empty before the first one."
    )
    failure: str | None = Field(description="Why its frame is missing in the latest step.")
    source: str = Field(description="How frames come, in the driver's own word; empty if not known.")
    refused: int = Field(description="That came with a pose or a time that cannot be trusted.")
    late: int = Field(description="That were not there by the deadline.")
    torn: int = Field(description="That were not whole by the deadline.")


class VehicleModel(WireModel):
    """One vehicle in the mission. Everything but its id is ``null`` until the vehicle has reported it."""

    vehicle_id: int
    autopilot: str
    mode: FlightMode
    mode_name: str = Field(description="The autopilot's own word for its mode.")
    task: Task
    landed: LandedState
    armed: bool | None
    ready_to_arm: bool | None
    position: PositionModel | None
    position_age_s: float | None
    altitude_amsl_m: float | None
    height_above_home_m: float | None
    ground_speed_mps: float | None
    climb_rate_mps: float | None
    heading_deg: float | None = Field(description="Clockwise from true north, [0, 360).")
    home: PositionModel | None
    battery_percent: float | None
    battery_voltage_v: float | None
    gps_fix: int | None = Field(description="MAVLink's GPS_FIX_TYPE; 3 and above is a 3D fix.")
    satellites: int | None
    link_age_s: float | None = Field(description="Seconds since its last message; null if never heard.")
    packet_loss_percent: float | None
    layer_height_m: float | None
    waypoint: PositionModel | None = Field(description="Where it was last sent.")
    refusal: str | None = Field(description="Why its last planned waypoint was shortened or held.")
    text: str = Field(description="Its latest status text of severity warning or worse.")
    link: LinkModel | None
    camera: VehicleCameraModel | None
