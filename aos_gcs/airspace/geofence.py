"""The mission's limits as the geofence that its autopilot keeps."""

from __future__ import annotations

import numpy as np

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.polygon import Polygon
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.ports import Geofence, LatLon


def vehicle_fence(limits: SafetyLimits, frame: LocalFrame, home_up_m: float) -> Geofence:
    """Return geofence, no-go zones and ceiling for a vehicle whose home lies ``home_up_m`` above the origin.

    The margin that waypoints keep from the geofence is left to the vehicle: autopilots act on a breach, not before it.
    """
    return Geofence(
        inclusion_deg=_to_degrees(limits.fence_enu_m, frame),
        exclusions_deg=tuple(_to_degrees(zone, frame) for zone in limits.no_go_enu_m),
        ceiling_above_home_m=round(limits.ceiling_m - home_up_m, 1),
    )


def _to_degrees(polygon: Polygon, frame: LocalFrame) -> tuple[LatLon, ...]:
    places = [frame.to_geodetic(np.array([east_m, north_m, 0.0])) for east_m, north_m in polygon]
    return tuple((round(place.latitude_deg, 7), round(place.longitude_deg, 7)) for place in places)
