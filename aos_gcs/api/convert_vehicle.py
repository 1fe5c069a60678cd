"""From the mission's vehicles to wire models, to as many decimals as mean something."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

from aos_gcs.api import models as wire
from aos_gcs.api.places import optional_position, percent, place_model, position, rounded, vertices
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition, LocalFrame
from aos_gcs.mission import model
from aos_gcs.ports import CameraState, LinkQuality

AGE_STEP_S: Final = 0.5
"""Of ages on the wire: that of a living link would otherwise change with every snapshot, often as the only field."""
_VEHICLES_KEPT: Final = 1024
"""What a vehicle tells comes again with every snapshot, and most of it hardly changes."""


def vehicle(vehicle: model.VehicleSnapshot, origin: GeodeticPosition | None) -> wire.VehicleModel:
    """Convert one vehicle."""
    state = vehicle.telemetry
    heard = state.heard_at_s is not None
    velocity_enu_mps = state.velocity_enu_mps
    position_age_s = None
    if vehicle.link_age_s is not None and state.heard_at_s is not None and state.position_at_s is not None:
        position_age_s = vehicle.link_age_s + state.heard_at_s - state.position_at_s
    return wire.VehicleModel(
        vehicle_id=state.vehicle_id,
        autopilot=state.autopilot,
        mode=state.mode,
        mode_name=state.mode_name,
        task=vehicle.task,
        landed=state.landed,
        armed=state.armed if heard else None,
        ready_to_arm=state.ready_to_arm,
        position=_position(vehicle),
        position_age_s=_age_s(position_age_s),
        altitude_amsl_m=rounded(state.position.altitude_amsl_m, 2) if state.position else None,
        height_above_home_m=rounded(state.height_above_home_m, 2),
        ground_speed_mps=rounded(math.hypot(*velocity_enu_mps[:2]), 1) if velocity_enu_mps else None,
        climb_rate_mps=rounded(velocity_enu_mps[2], 1) if velocity_enu_mps else None,
        heading_deg=round(math.degrees(state.heading_rad), 1) % 360.0 if state.heading_rad is not None else None,
        home=position(_to_enu(origin, state.home), origin) if origin and state.home else None,
        battery_percent=percent(state.battery_fraction),
        battery_voltage_v=rounded(state.battery_voltage_v, 2),
        gps_fix=state.gps_fix,
        satellites=state.satellites,
        link_age_s=_age_s(vehicle.link_age_s),
        packet_loss_percent=percent(state.packet_loss_fraction),
        layer_height_m=vehicle.layer_height_m,
        waypoint=optional_position(vehicle.waypoint_enu_m, origin),
        refusal=vehicle.refusal,
        text=state.text,
        link=_link(state.link) if state.link else None,
        camera=_camera(vehicle.camera, state.camera or CameraState(), origin) if vehicle.camera else None,
    )


def _position(vehicle: model.VehicleSnapshot) -> wire.PositionModel | None:
    """Join the ENU position with the reported degrees, which need no conversion."""
    if vehicle.position_enu_m is None:
        return None
    return place_model(vehicle.position_enu_m, vehicle.telemetry.position)


def _age_s(age_s: float | None) -> float | None:
    return None if age_s is None else AGE_STEP_S * round(age_s / AGE_STEP_S)


@lru_cache(maxsize=_VEHICLES_KEPT)
def _link(link: LinkQuality) -> wire.LinkModel:
    return wire.LinkModel(
        address=link.address,
        living_addresses=link.living_addresses,
        round_trip_ms=_scaled(link.round_trip_s, 1e3),
        clock_offset_ms=_scaled(link.clock_offset_s, 1e3),
        clock_drift_ppm=_scaled(link.clock_drift, 1e6),
    )


@lru_cache(maxsize=_VEHICLES_KEPT)
def _camera(camera: model.CameraSnapshot, reported: CameraState, origin: GeodeticPosition | None) -> wire.CameraModel:
    return wire.CameraModel(
        frames=camera.frames,
        failures=camera.failures,
        last_step=camera.last_step,
        footprint=vertices(camera.footprint_enu_m, origin),
        failure=camera.failure,
        source=reported.source,
        refused=reported.refused,
        late=reported.late,
        torn=reported.torn,
    )


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else rounded(factor * value, 1)


@lru_cache(maxsize=_VEHICLES_KEPT)
def _to_enu(origin: GeodeticPosition, position: GeodeticPosition) -> EnuPoint:
    east_m, north_m, up_m = LocalFrame(origin).to_enu(position)
    return float(east_m), float(north_m), float(up_m)
