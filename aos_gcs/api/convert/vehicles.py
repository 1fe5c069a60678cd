"""Conversion of vehicles, to as many decimals as carry meaning."""

from __future__ import annotations

import math
from typing import Final

from aos_gcs.api.convert.places import percent, place_model, position, rounded, vertices
from aos_gcs.api.convert.reuse import Reused
from aos_gcs.api.models.base import PositionModel
from aos_gcs.api.models.vehicles import ComponentModel, LinkModel, VehicleCameraModel, VehicleModel
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition, LocalFrame
from aos_gcs.mission.model.vehicles import CameraSnapshot, VehicleSnapshot
from aos_gcs.ports import CameraState, LinkQuality

AGE_STEP_S: Final = 0.5
"""Resolution of ages: a finer one would change with every snapshot, often as a vehicle's only field."""


class VehicleConverter:
    """Converts the snapshots of one vehicle; keeps what has not changed.

    Args:
        origin: origin of the mission's frame; None while it is unknown.
    """

    def __init__(self, origin: GeodeticPosition | None) -> None:
        self._origin = origin
        self._home = Reused(self._convert_home)
        self._waypoint = Reused(self._convert_waypoint)
        self._link = Reused(_link)
        self._camera = Reused(self._convert_camera)

    def convert(self, vehicle: VehicleSnapshot) -> VehicleModel:
        """Convert one snapshot."""
        state = vehicle.telemetry
        heard = state.heard_at_s is not None
        velocity_enu_mps = state.velocity_enu_mps
        return VehicleModel(
            vehicle_id=state.vehicle_id,
            autopilot=state.autopilot,
            mode=state.mode,
            mode_name=state.mode_name,
            task=vehicle.task,
            takes_part=vehicle.takes_part,
            landed=state.landed,
            armed=state.armed if heard else None,
            ready_to_arm=state.ready_to_arm,
            position=_position(vehicle),
            position_age_s=_age_of(vehicle, state.position_at_s),
            altitude_amsl_m=rounded(state.position.altitude_amsl_m, 2) if state.position else None,
            height_above_home_m=rounded(state.height_above_home_m, 2),
            height_above_ground_m=rounded(vehicle.height_above_ground_m, 2),
            ground_speed_mps=rounded(math.hypot(*velocity_enu_mps[:2]), 1) if velocity_enu_mps else None,
            climb_rate_mps=rounded(velocity_enu_mps[2], 1) if velocity_enu_mps else None,
            heading_deg=round(math.degrees(state.heading_rad), 1) % 360.0 if state.heading_rad is not None else None,
            home=self._home(state.home) if state.home else None,
            battery_percent=percent(state.battery_fraction),
            battery_voltage_v=rounded(state.battery_voltage_v, 2),
            gps_fix=state.gps_fix,
            satellites=state.satellites,
            link_age_s=_age_s(vehicle.link_age_s),
            components=[
                ComponentModel(component_id=each.component_id, name=each.name, age_s=_age_of(vehicle, each.heard_at_s))
                for each in state.components
            ],
            packet_loss_percent=percent(state.packet_loss_fraction),
            layer_height_m=vehicle.layer_height_m,
            waypoint=self._waypoint(vehicle.waypoint_enu_m) if vehicle.waypoint_enu_m is not None else None,
            refusal=vehicle.refusal,
            text=state.text,
            link=self._link(state.link) if state.link else None,
            camera=self._camera((vehicle.camera, state.camera or CameraState())) if vehicle.camera else None,
            leaves_in_s=rounded(vehicle.leaves_in_s, 0) if math.isfinite(vehicle.leaves_in_s or 0.0) else None,
            relay_ready=vehicle.is_ready,
        )

    def _convert_home(self, home: GeodeticPosition) -> PositionModel | None:
        if self._origin is None:
            return None
        east_m, north_m, up_m = LocalFrame(self._origin).to_enu(home)
        return position((float(east_m), float(north_m), float(up_m)), self._origin)

    def _convert_waypoint(self, point_enu_m: EnuPoint) -> PositionModel:
        return position(point_enu_m, self._origin)

    def _convert_camera(self, both: tuple[CameraSnapshot, CameraState]) -> VehicleCameraModel:
        camera, reported = both
        return VehicleCameraModel(
            frames=camera.frames,
            failures=camera.failures,
            last_step=camera.last_step,
            footprint=vertices(camera.footprint_enu_m, self._origin),
            failure=camera.failure,
            source=reported.source,
            refused=reported.refused,
            late=reported.late,
            torn=reported.torn,
        )


def _position(vehicle: VehicleSnapshot) -> PositionModel | None:
    """Join the ENU position with the reported degrees, which need no conversion."""
    if vehicle.position_enu_m is None:
        return None
    return place_model(vehicle.position_enu_m, vehicle.telemetry.position)


def _age_of(vehicle: VehicleSnapshot, at_s: float | None) -> float | None:
    """Return the age at the time of the snapshot of something that came from the vehicle at ``at_s``."""
    heard_at_s = vehicle.telemetry.heard_at_s
    if vehicle.link_age_s is None or heard_at_s is None or at_s is None:
        return None
    return _age_s(max(0.0, vehicle.link_age_s + heard_at_s - at_s))


def _age_s(age_s: float | None) -> float | None:
    return None if age_s is None else AGE_STEP_S * round(age_s / AGE_STEP_S)


def _link(link: LinkQuality) -> LinkModel:
    return LinkModel(
        address=link.address,
        living_addresses=link.living_addresses,
        round_trip_ms=_scaled(link.round_trip_s, 1e3),
        clock_offset_ms=_scaled(link.clock_offset_s, 1e3),
        clock_drift_ppm=_scaled(link.clock_drift, 1e6),
    )


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else rounded(factor * value, 1)
