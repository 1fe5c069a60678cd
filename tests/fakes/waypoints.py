"""Waypoints that vehicles ask for."""

import numpy as np

from aos_gcs.airspace.traffic import WaypointRequest


def request(
    vehicle_id: int,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    *,
    link_age_s: float | None = 0.2,
    position_age_s: float | None = 0.2,
    battery_fraction: float | None = 0.8,
    home: tuple[float, float, float] | None = None,
) -> WaypointRequest:
    return WaypointRequest(
        vehicle_id=vehicle_id,
        position_enu_m=np.array(start),
        requested_enu_m=np.array(end),
        link_age_s=link_age_s,
        position_age_s=position_age_s,
        battery_fraction=battery_fraction,
        home_enu_m=None if home is None else np.array(home),
    )
