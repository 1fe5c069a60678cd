"""A vehicle by script: it flies, obeys and refuses without an autopilot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition, LocalFrame
from aos_gcs.mission.model.actions import Action, ActionResult
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import CameraSnapshot, Task, VehicleSnapshot
from aos_gcs.mission.phases import BEFORE_START
from aos_gcs.ports import FlightMode, LandedState, LinkQuality, VehicleState

TARGET_ENU_M = (18.0, 72.0, 0.0)
ORIGIN = GeodeticPosition(48.3358, 14.3263, 262.0)
GROUND_UP_M = -4.0
"""Height of the ground by the elevation model, above the origin: the launch site stands on a platform."""
SPEED_MPS = 5.0
REFUSING_ID = 4
"""Refuses to return and to land, to show a failure."""
SILENT_ID = 7
"""Was never heard."""
_TASK_AND_MODE = {
    Action.HOLD: (Task.HELD, FlightMode.HOLD),
    Action.RETURN: (Task.RETURNING, FlightMode.RETURN),
    Action.LAND: (Task.LANDING, FlightMode.LAND),
    Action.RESUME: (Task.SWARM, FlightMode.GUIDED),
    Action.START: (Task.SWARM, FlightMode.TAKEOFF),
    Action.PAUSE: (Task.SWARM, FlightMode.GUIDED),
    Action.ABORT: (Task.RETURNING, FlightMode.RETURN),
}


@dataclass
class ScriptedVehicle:
    """One vehicle of a scripted mission, by what it does."""

    vehicle_id: int
    home_enu_m: EnuPoint
    position_enu_m: EnuPoint
    layer_height_m: float
    waypoint_enu_m: EnuPoint | None = None
    heading_rad: float = 0.0
    speed_mps: float = 0.0
    task: Task = Task.IDLE
    mode: FlightMode = FlightMode.GUIDED
    refusal: str | None = None
    battery: float = 0.97
    camera: CameraSnapshot = field(default_factory=CameraSnapshot)

    def act(self, action: Action) -> ActionResult:
        """Obey an operator, or refuse."""
        if self.vehicle_id == SILENT_ID:
            return ActionResult(self.vehicle_id, accepted=False, text="has not been heard yet")
        if self.vehicle_id == REFUSING_ID and action in {Action.RETURN, Action.LAND}:
            return ActionResult(self.vehicle_id, accepted=False, text="refused by the autopilot: mode change failed")
        self.task, self.mode = _TASK_AND_MODE[action]
        return ActionResult(self.vehicle_id, accepted=True, text=f"{self.task}, mode {self.mode}")

    def move(self, phase: Phase, duration_s: float) -> None:
        """Fly on towards the goal of the present task."""
        goals: dict[Task, EnuPoint | None] = {
            Task.SWARM: self.waypoint_enu_m or (*self.home_enu_m[:2], self.layer_height_m),
            Task.RETURNING: (*self.home_enu_m[:2], self.layer_height_m),
            Task.LANDING: (*self.position_enu_m[:2], 0.0),
        }
        goal = goals.get(self.task)
        if phase is Phase.ARM or goal is None or self.vehicle_id == SILENT_ID:
            self.speed_mps = 0.0
            return
        here = np.array(self.position_enu_m)
        way = np.array(goal) - here
        distance_m = float(np.linalg.norm(way))
        travelled_m = min(distance_m, SPEED_MPS * duration_s)
        if distance_m > 1e-6:
            east_m, north_m, up_m = here + way * (travelled_m / distance_m)
            self.position_enu_m = (float(east_m), float(north_m), float(up_m))
        if float(np.linalg.norm(way[:2])) > 0.05:
            self.heading_rad = math.atan2(way[0], way[1]) % (2 * math.pi)
        self.speed_mps = travelled_m / duration_s
        self.battery = max(0.05, self.battery - 0.0006 * duration_s * self.vehicle_id)

    def plan(self, index: int, number: int, *, in_view: bool) -> WaypointRecord:
        """Take the waypoint of a step."""
        if in_view:
            angle = 2.4 * index + 0.35 * number
            radius_m = max(6.0, 24.0 - number)
            east_m = TARGET_ENU_M[0] + radius_m * math.cos(angle)
            north_m = TARGET_ENU_M[1] + radius_m * math.sin(angle)
        else:
            east_m, north_m = -42.0 + 12.0 * index, -15.0 + 8.0 * number
        requested = (east_m, north_m, self.layer_height_m)
        if self.vehicle_id == 2 and number % 5 == 0:
            self.refusal = "held: vehicle 3 would come closer than 5.0 m"
            return WaypointRecord(self.vehicle_id, requested, None, WaypointVerdict.HELD, self.refusal)
        self.refusal = None
        self.waypoint_enu_m = requested
        return WaypointRecord(self.vehicle_id, requested, requested, WaypointVerdict.SENT, "")

    def expose(self, step: int) -> None:
        """Look straight down."""
        east_m, north_m, up_m = self.position_enu_m
        half_m = 0.5 * up_m
        corners = ((-half_m, half_m), (half_m, half_m), (half_m, -half_m), (-half_m, -half_m))
        self.camera = CameraSnapshot(step, 0, step, tuple((east_m + dx_m, north_m + dy_m) for dx_m, dy_m in corners))

    def snapshot(self, phase: Phase, elapsed_s: float, *, is_chosen: bool) -> VehicleSnapshot:
        """Return what is known of the vehicle."""
        if self.vehicle_id == SILENT_ID:
            state = VehicleState(SILENT_ID)
            return VehicleSnapshot(state, Task.IDLE, None, None, None, None, None, takes_part=is_chosen)
        position = LocalFrame(ORIGIN).to_geodetic(self.position_enu_m)
        flying = self.position_enu_m[2] > 0.5
        state = VehicleState(
            vehicle_id=self.vehicle_id,
            autopilot="arducopter" if self.vehicle_id % 2 else "px4",
            mode=self.mode,
            mode_name=self.mode.upper(),
            armed=phase not in BEFORE_START | {Phase.DONE},
            landed=LandedState.IN_AIR if flying else LandedState.ON_GROUND,
            ready_to_arm=True,
            position=position,
            position_at_s=elapsed_s,
            height_above_home_m=self.position_enu_m[2],
            velocity_enu_mps=(
                self.speed_mps * math.sin(self.heading_rad),
                self.speed_mps * math.cos(self.heading_rad),
                0.0,
            ),
            heading_rad=self.heading_rad,
            home=LocalFrame(ORIGIN).to_geodetic(self.home_enu_m),
            battery_fraction=self.battery,
            battery_voltage_v=14.0 + 2.6 * self.battery,
            gps_fix=3 if self.vehicle_id != 5 else 6,
            satellites=14 + self.vehicle_id % 4,
            heard_at_s=elapsed_s,
            packet_loss_fraction=0.004 * self.vehicle_id,
            link=LinkQuality(f"udp://10.0.0.{self.vehicle_id}:14550", 2, 0.02 * self.vehicle_id, 0.004, 2e-6),
            text="EKF variance" if self.vehicle_id == 6 else "",
        )
        link_age_s = 7.5 if self.vehicle_id == 6 else 0.2
        return VehicleSnapshot(
            state,
            self.task,
            self.layer_height_m,
            self.position_enu_m,
            link_age_s,
            self.waypoint_enu_m,
            self.refusal,
            self.camera,
            is_chosen,
            height_above_ground_m=self.position_enu_m[2] - GROUND_UP_M,
        )
