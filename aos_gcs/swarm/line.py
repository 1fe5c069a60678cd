"""The default scanning pattern: a line of drones across the scanning direction.

Source: AOS-APSO paper, algorithm PSO update for AOS drone swarms, line 4, and section Projection-based default line
positions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def unit_vector(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``direction``, shape (2,), scaled to length 1.

    Raises:
        ValueError: it has no length, or is not finite.
    """
    length = float(np.linalg.norm(direction))
    if np.shape(direction) != (2,) or not np.isfinite(length) or length == 0.0:
        raise ValueError(f"a direction needs shape (2,) and a finite length above 0, but was {direction!r}")
    return np.asarray(direction, dtype=np.float64) / length


def line_axis(scan_direction_enu: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return w/|w| with w perpendicular to SD, shape (2,): a quarter turn to the left of the scanning direction."""
    east, north = unit_vector(scan_direction_enu)
    return np.array([-north, east])


def line_places(
    centre_enu_m: NDArray[np.float64], scan_direction_enu: NDArray[np.float64], n: int, spacing_m: float
) -> NDArray[np.float64]:
    """Return n places c4 apart on the line across SD, centred on ``centre_enu_m``, shape (n, 2), along the line's axis.

    The paper's l_i counts from the origin; counted from the swarm's centre of gravity the line moves with the swarm.
    """
    along_m = spacing_m * (np.arange(n) - (n - 1) / 2.0)
    return np.asarray(centre_enu_m) + along_m[:, None] * line_axis(scan_direction_enu)


def line_by_index(
    positions_enu_m: NDArray[np.float64], scan_direction_enu: NDArray[np.float64], spacing_m: float
) -> NDArray[np.float64]:
    """Return each drone's place on the line about the swarm's centre of gravity, in the order of the rows.

    Args:
        positions_enu_m: shape (n, 2), metres.
        scan_direction_enu: shape (2,).
        spacing_m: c4, metres.

    Returns:
        Places, shape (n, 2), metres.
    """
    centre_m = positions_enu_m.mean(axis=0)
    return line_places(centre_m, scan_direction_enu, len(positions_enu_m), spacing_m)


def line_by_projection(
    positions_enu_m: NDArray[np.float64], scan_direction_enu: NDArray[np.float64], spacing_m: float
) -> NDArray[np.float64]:
    """Return each drone's place on the line about the swarm's centre of gravity, in the order of their projections.

    The sum of squared distances is minimal. Drones that start and arrive together keep their order along the line at
    all times and never meet; their ways, as drawn, may still cross. Equal projections keep the order of the rows.
    Arguments and result as in :func:`line_by_index`.
    """
    return in_projection_order(positions_enu_m, line_by_index(positions_enu_m, scan_direction_enu, spacing_m))


def in_projection_order(positions_enu_m: NDArray[np.float64], places_enu_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the places of a straight line, shape (n, 2), reordered so that row i is the one for drone i."""
    projections_m = positions_enu_m @ (places_enu_m[-1] - places_enu_m[0])
    rank = np.argsort(np.argsort(projections_m, kind="stable"), kind="stable")
    return places_enu_m[rank]
