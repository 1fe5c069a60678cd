"""Conversion of the relief about a mission to the wire."""

from __future__ import annotations

import numpy as np

from aos_gcs.airspace.terrain import Polynomials
from aos_gcs.api.convert.places import vertices
from aos_gcs.api.models import relief as wire
from aos_gcs.api.models.base import VertexModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.planning.terrain.ground import EnuBounds
from aos_gcs.planning.terrain.relief import Contours

_NODES = 8
"""Places along each axis to which the mapping to degrees is fitted: exact to a centimetre, and fast for many points."""
_DIGITS = 6
"""Decimals of a degree: a decimetre."""


def corners(bounds: EnuBounds, origin: GeodeticPosition) -> list[VertexModel]:
    """Convert the corners of a rectangle, clockwise from the north-western one."""
    west_m, south_m, east_m, north_m = bounds.west_m, bounds.south_m, bounds.east_m, bounds.north_m
    return vertices([(west_m, north_m), (east_m, north_m), (east_m, south_m), (west_m, south_m)], origin)


def contours(lines: Contours, bounds: EnuBounds, origin: GeodeticPosition) -> wire.ContoursModel:
    """Convert contour lines within a rectangle."""
    frame, nodes_m = LocalFrame(origin), bounds.nodes(_NODES)
    places = [frame.to_geodetic((*node_m, 0.0)) for node_m in nodes_m]
    to_degrees = Polynomials.fitted(nodes_m, np.array([(one.latitude_deg, one.longitude_deg) for one in places]))
    converted = []
    for line in lines.lines:
        degrees = to_degrees.at(line.points_enu_m).round(_DIGITS)
        converted.append(
            wire.ContourModel(
                altitude_amsl_m=line.altitude_amsl_m,
                latitude_deg=degrees[:, 0].tolist(),
                longitude_deg=degrees[:, 1].tolist(),
            )
        )
    return wire.ContoursModel(interval_m=lines.interval_m, spacing_m=lines.spacing_m, lines=converted)
