"""Evidence on a body that a swarm has seen: the few numbers that the decision rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.persons.form import APART_M, Form, form_sums
from aos_gcs.imaging.persons.warm_bodies import WarmView

SHARP_VEHICLES = 2
"""Vehicles whose frames tell contrasts without those of others that were in flight."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """A body as the frames of one or several steps show it."""

    views: int
    """Frames that show it."""
    vehicles: int
    """Vehicles that took them; those of a single vehicle count by place, see :func:`vantage_points`."""
    area_m2: float
    """Largest area that one frame shows of it, on the focal plane; a lower bound of its size."""
    extent_m: float
    """Largest distance of two warm pixels in one frame, along an axis of the grid; a lower bound of its length."""
    contrast_median_k: float
    """Median of its pixels, above the background: clothes, fur, stone."""
    contrast_peak_k: float
    """99 % quantile of its pixels: bare skin, if a frame shows any."""
    frames: int = 0
    """Frames that look at its place, whether they show it or not; 0 where nobody has counted them."""
    swarm: int = 0
    """Vehicles that took these."""
    radiometric: bool = True
    """Whether the frames tell temperatures; without them contrasts are in standard deviations of the surroundings."""
    concentration: float = 0.0
    """Density of pixels that stand out at the place, as a multiple of that around it; without temperatures only."""
    is_smeared: bool = False
    """Whether its contrasts are those that cameras see in flight: at most what they are."""
    form: Form | None = None
    """Size and pattern of warmth of the body; None where too few frames show enough of it."""
    background_c: float | None = None
    """Temperature of forest and ground about it, in degrees Celsius; None where it is not known."""
    in_sun: bool = False
    """Whether the sun warms things in spots where most of the frames that show it were taken."""


NO_TEMPERATURES = Evidence(0, 0, 0.0, 0.0, 0.0, 0.0, radiometric=False)
"""Evidence of an anomaly in frames that neither tell temperatures nor have a band in which a spot may stand out."""


def gather_evidence(body: Sequence[WarmView], among: Sequence[WarmView] = (), plane_height_m: float = 0.0) -> Evidence:
    """Return what the views of one warm body, at least one, tell about it.

    Contrasts are those of cameras that hovered, where two vehicles did.

    Args:
        body: the parts of the views that show it.
        among: all views of the same steps, those that do not show it as well.
        plane_height_m: ENU height of the focal plane.
    """
    sharp = [view for view in body if not view.is_smeared]
    is_sharp = len(sharp) == len(body) or vantage_points(sharp, among) >= SHARP_VEHICLES
    contrast_k = np.concatenate([view.contrast_k for view in (sharp if is_sharp else body)])
    median_k, peak_k = np.quantile(contrast_k, [0.5, 0.99])
    middle_enu_m = np.concatenate([view.points_enu_m for view in body]).mean(axis=0)
    looking = looking_at(middle_enu_m, among, plane_height_m)
    return Evidence(
        views=len(body),
        vehicles=vantage_points(body, among),
        area_m2=max(view.area_m2 for view in body),
        extent_m=max(float(np.ptp(view.points_enu_m, axis=0).max()) for view in body),
        contrast_median_k=float(median_k),
        contrast_peak_k=float(peak_k),
        frames=len(looking),
        swarm=vantage_points(looking, among),
        is_smeared=not is_sharp,
        form=form_sums(body, plane_height_m).form(),
        background_c=_background_c(body),
        in_sun=2 * sum(view.in_sun for view in body) > len(body),
    )


def _background_c(body: Sequence[WarmView]) -> float | None:
    known_c = [view.background_c for view in body if view.background_c is not None]
    return float(np.median(known_c)) if known_c else None


def vantage_points(views: Sequence[WarmView], among: Sequence[WarmView]) -> int:
    """Return how many vehicles took some views.

    Where a single vehicle took all there are, its places stand for vehicles, as far as they are ``APART_M`` apart: they
    see the ground through other gaps, and a defect of the camera moves with it.

    Args:
        views: the views that are counted.
        among: all views of the same steps.
    """
    if len({view.vehicle_id for view in among}) != 1:
        return len({view.vehicle_id for view in views})
    places_enu_m: list[NDArray[np.float64]] = []
    for view in views:
        place_enu_m = view.pose.position_enu_m
        if all(np.linalg.norm(place_enu_m - other_enu_m) >= APART_M for other_enu_m in places_enu_m):
            places_enu_m.append(place_enu_m)
    return len(places_enu_m)


def nothing_warm(place_enu_m: NDArray[np.float64], among: Sequence[WarmView], plane_height_m: float) -> Evidence:
    """Return the evidence of a place, shape (2,), at which no frame shows anything warm."""
    looking = looking_at(place_enu_m, among, plane_height_m)
    return Evidence(0, 0, 0.0, 0.0, 0.0, 0.0, frames=len(looking), swarm=vantage_points(looking, among))


def looking_at(
    place_enu_m: NDArray[np.float64], views: Sequence[WarmView], plane_height_m: float
) -> tuple[WarmView, ...]:
    """Return the views whose frames hold a place, shape (2,), on the focal plane."""
    point_enu_m = np.array([[*place_enu_m, plane_height_m]])
    return tuple(view for view in views if _holds(view, point_enu_m))


def _holds(view: WarmView, point_enu_m: NDArray[np.float64]) -> bool:
    u, v = project_points(point_enu_m, view.camera, view.pose)[0]
    return bool(-0.5 <= u <= view.camera.width_px - 0.5 and -0.5 <= v <= view.camera.height_px - 0.5)
