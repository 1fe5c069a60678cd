"""Ground that may not be known although the model has heights there: warnings to operators."""

from __future__ import annotations

import math

import numpy as np

from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.elevation.suspects import ZERO_STEP_M, SuspectedHoles, zeros_at_a_step
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.planning.terrain.ground import FINE_CELL_M


def suspected_holes(ground: GroundRaster, frame: LocalFrame, cell_m: float) -> str | None:
    """Return the warning of ground that ends at exactly 0 m at a step; None where there is none.

    Args:
        ground: ground below a plan, above the origin of the frame.
        frame: local frame.
        cell_m: edge of the elevation model's cells, which the raster may divide.
    """
    # As the raster is made of heights above sea level, which it has to equal.
    zero = float(np.float32(0.0) - np.float32(frame.origin.altitude_amsl_m))
    steps = zeros_at_a_step(ground.lowest_m, zero, math.ceil(cell_m / FINE_CELL_M) + 1)
    if not steps.any():
        return None
    east_m, north_m = ground.to_enu.at(np.argwhere(steps)[:1].astype(np.float64) + 0.5)[0]
    place = frame.to_geodetic((float(east_m), float(north_m), 0.0))
    share = float((ground.lowest_m == zero).mean())
    where = f"at {place.latitude_deg:.5f}, {place.longitude_deg:.5f} among others"
    return _warning(f"{share:.1%} of the ground about this plan is", where)


def holes_warning(suspected: SuspectedHoles) -> str:
    """Return the warning of a model with cells that may have no height."""
    latitude_deg, longitude_deg = suspected.first_deg
    return _warning(f"{suspected.count:,} cells are", f"one at {latitude_deg:.6f}, {longitude_deg:.6f}")


def _warning(which: str, where: str) -> str:
    return (
        f"The elevation model may have holes that are written as 0: {which} exactly 0 m, beside ground that is more "
        f"than {ZERO_STEP_M:g} m away from it, {where}. If data is missing there, declare it (gdal_edit -a_nodata 0); "
        "if a cliff falls to the sea there, the heights are right."
    )
