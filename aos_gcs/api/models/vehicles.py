"""Wire models of vehicles, with their links and cameras."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import PositionModel, VertexModel, WireModel
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import FlightMode, LandedState


class LinkModel(WireModel):
    """Quality of a vehicle's link; its packet loss and age are in VehicleModel."""

    address: str = Field(description="Address in use.")
    living_addresses: int = Field(description="Number of addresses, on all links together, at which it is heard.")
    round_trip_ms: float | None
    clock_offset_ms: float | None = Field(description="The vehicle's clock minus ours.")
    clock_drift_ppm: float | None = Field(description="Rate at which the vehicle's clock gains on ours.")


class ComponentModel(WireModel):
    """Component of a vehicle beside its autopilot."""

    component_id: int
    name: str = Field(description="MAVLink's name of it, in words; empty if it has none.")
    age_s: float | None = Field(description="Age of its last message.")


class VehicleCameraModel(WireModel):
    """Frames of a vehicle's camera in this mission."""

    frames: int = Field(description="Number of usable frames.")
    failures: int = Field(description="Number of steps without its frame.")
    last_step: int | None
    footprint: list[VertexModel] = Field(
        description="Part of the focal plane that its latest frame shows; empty before the first one."
    )
    failure: str | None = Field(description="Reason why its frame is missing in the latest step.")
    source: str = Field(description="Source of frames, as the driver calls it; empty if unknown.")
    refused: int = Field(description="Number of frames with an implausible pose or time.")
    late: int = Field(description="Number of frames that arrived after the deadline.")
    torn: int = Field(description="Number of frames that were incomplete at the deadline.")


class VehicleModel(WireModel):
    """One vehicle in the mission. Everything but its id is ``null`` until the vehicle has reported it."""

    vehicle_id: int
    autopilot: str
    mode: FlightMode
    mode_name: str = Field(description="The autopilot's own name of its mode.")
    task: Task
    takes_part: bool = Field(
        description="Whether it flies the mission; a vehicle that does not is armed only to join, or for the relay."
    )
    landed: LandedState
    armed: bool | None
    ready_to_arm: bool | None
    position: PositionModel | None
    position_age_s: float | None
    altitude_amsl_m: float | None
    height_above_home_m: float | None
    height_above_ground_m: float | None = Field(
        description="Above the highest ground about it, by the elevation model; null without one."
    )
    ground_speed_mps: float | None
    climb_rate_mps: float | None
    heading_deg: float | None = Field(description="Clockwise from true north, [0, 360).")
    home: PositionModel | None
    battery_percent: float | None
    battery_voltage_v: float | None
    gps_fix: int | None = Field(description="MAVLink's GPS_FIX_TYPE; 3 and above is a 3D fix.")
    satellites: int | None
    link_age_s: float | None = Field(description="Seconds since its autopilot's last message; null if never heard.")
    components: list[ComponentModel] = Field(description="Other components that have been heard, such as cameras.")
    packet_loss_percent: float | None
    layer_height_m: float | None
    waypoint: PositionModel | None = Field(description="Latest waypoint sent to it.")
    refusal: str | None = Field(description="Reason why its last planned waypoint was shortened or held.")
    text: str = Field(description="Latest status text of severity warning or worse.")
    link: LinkModel | None
    camera: VehicleCameraModel | None
    leaves_in_s: float | None = Field(
        description="Seconds until it is to leave for home by its battery; null while unknown, or to the end."
    )
    relay_ready: bool | None = Field(
        description="Whether it is confirmed to take off once for the relay; null where there is none, and in the air."
    )
