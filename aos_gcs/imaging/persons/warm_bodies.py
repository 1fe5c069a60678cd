"""Warm bodies in single frames: the pixels that are clearly warmer than the rest of the frame.

Anomaly detection marks what is rare, warm or not, and at most a fixed share of a frame. To tell a person from what else
is rare, this looks at all warm pixels. Temperatures are differences from the frame's own median, in which the offset of
an uncooled camera cancels. Colour takes no part: clothes may have any.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import intersect_plane
from aos_gcs.imaging.connected import connected
from aos_gcs.imaging.model import BlobView, Frame
from aos_gcs.imaging.persons.restoration import restored

MIN_CONTRAST_K = 4.0
"""Contrast above the frame's median: canopy and ground differ by less even in spots of sun, persons by 10 K and more on
a cool day."""
_SUNLIT_SHARE = 3.0
"""Contrast of a warm pixel over that of the frame's warmest tenth, at least: on warm days leaves and ground in the sun
are 4 K above the median here and there, and would join all there is to one body."""
_SUNLIT_K = 6.0
"""Contrast from which that does not matter: a clearing in the sun hides nobody who stands beside it."""
_IN_SUN_K = 2.3
"""Difference of a frame's warmest and coldest tenth from which the sun warms leaves and ground: 1.0 to 1.8 K in
simulated forests without sun, 2.8 to 4.1 K with it."""
_COLOURS, _DARK = ("red", "green", "blue"), 25.0
"""Bands of daylight, and their median level of 255 below which the sun is down."""
LINK_M = 1.5
"""Largest distance at which warm spots belong to one body: views of one person lie 0.9 m apart where positions are
known to 0.5 m and attitudes to 1 degree."""
MAX_PIXELS = 20_000
"""Largest number of warm pixels that a view keeps. A person has some hundreds; a sunlit clearing has a hundred
thousand, of which every second or third row and column says as much."""

LAG_S = 0.01
"""Time constant of an uncooled sensor: what a camera sees in flight is smeared over the way that it flies meanwhile."""
SMEAR_PX = 0.25
"""Smear, in pixels, from which contrasts between leaves are lower than those of a camera that hovers."""

_BACKGROUND_STRIDE = 4
"""Distance between the pixels that the frame's median is computed from."""
_COLDEST_C, _HOTTEST_C = -50.0, 50.0
"""Temperatures of forests and ground in which people are searched for."""
_CELL_M = 0.25
"""Points within such a cell are linked as one."""


@dataclass(frozen=True, slots=True, eq=False)
class WarmView:
    """Warm pixels of one frame; arrays have one row per pixel."""

    vehicle_id: int
    points_enu_m: NDArray[np.float64]
    """Points of the pixels on the focal plane, shape (k, 2)."""
    contrast_k: NDArray[np.float64]
    """Contrast above the frame's median, shape (k,); without temperatures see ``radiometric``."""
    pixel_area_m2: float
    """Area of one pixel on the focal plane, at nadir; with more than ``MAX_PIXELS``, of those that each stands for."""
    camera: CameraModel
    pose: Pose
    radiometric: bool = True
    """False: contrasts are in standard deviations of each pixel's surroundings."""
    time_sigma_s: float | None = None
    """Standard deviation of the frame's time of exposure; None where it is not known."""
    speed_mps: float = 0.0
    """Speed of the camera at exposure; 0 where it hovers."""
    out_of_focus: bool = False
    """Whether the camera's optics were: small spots are cooler than what they show, also sharpened."""
    background_c: float | None = None
    """The frame's median, in degrees Celsius, as well as the camera knows them; None where it is none of a forest, as
    of a camera whose scale is wrong, and without temperatures."""
    in_sun: bool = False
    """Whether the sun warms leaves and ground here and there, by this frame or by those of the same day, and so, in
    spots, what wears clothes or fur."""

    @property
    def area_m2(self) -> float:
        """Area of the pixels together."""
        return len(self.points_enu_m) * self.pixel_area_m2

    @property
    def is_smeared(self) -> bool:
        """Whether the camera flew so fast that the contrast of small spots is lost in part."""
        return self.speed_mps * LAG_S > SMEAR_PX * math.sqrt(self.pixel_area_m2)

    def part(self, chosen: NDArray[np.bool | np.intp]) -> WarmView:
        """Return the view with some of its pixels only: ``chosen`` is a mask of shape (k,), or their rows."""
        return replace(self, points_enu_m=self.points_enu_m[chosen], contrast_k=self.contrast_k[chosen])

    def on_plane(self, height_m: float, plane_height_m: float) -> WarmView:
        """Return the view on the plane of another height, empty where that is not below the camera.

        Args:
            height_m: ENU height of the plane that its points lie on.
            plane_height_m: that of the other one.
        """
        up_m = float(self.pose.position_enu_m[2])
        if plane_height_m >= up_m:
            return self.part(np.zeros(0, dtype=np.intp))
        stretch = (up_m - plane_height_m) / (up_m - height_m)
        below_m = self.pose.position_enu_m[:2]
        return replace(
            self,
            points_enu_m=below_m + stretch * (self.points_enu_m - below_m),
            pixel_area_m2=stretch**2 * self.pixel_area_m2,
        )

    def as_blob_view(self) -> BlobView:
        """Return what geolocation needs of it."""
        centre_enu_m = self.points_enu_m.mean(axis=0)
        camera = self.camera.ideal()
        return BlobView(self.vehicle_id, centre_enu_m, camera, self.pose, self.time_sigma_s, self.speed_mps)


def warm_view(frame: Frame, plane_height_m: float = 0.0) -> WarmView:
    """Return the warm pixels of a frame, possibly none.

    Args:
        frame: frame with a band ``thermal`` in degrees Celsius.
        plane_height_m: ENU height of the focal plane. Pixels that do not look at it are left out.

    Raises:
        ImagingError: if the frame has no thermal band.
    """
    if "thermal" not in frame.bands:
        raise ImagingError(f"Warm bodies need a band 'thermal', but the frame has {', '.join(frame.bands)}.")
    thermal = restored(frame.image[..., frame.bands.index("thermal")])
    samples_c = thermal.image[::_BACKGROUND_STRIDE, ::_BACKGROUND_STRIDE]
    # As Python's numbers: with NumPy's, the difference below would have twice the bytes.
    background_c, sunlit_c = map(float, np.nanquantile(samples_c, [0.5, 0.9]))
    min_contrast_k = min(max(MIN_CONTRAST_K, _SUNLIT_SHARE * (sunlit_c - background_c)), _SUNLIT_K)
    view = view_above(frame, thermal.image - background_c, min_contrast_k, plane_height_m)
    is_known = _COLDEST_C <= background_c <= _HOTTEST_C
    return replace(
        view,
        out_of_focus=thermal.out_of_focus,
        background_c=background_c if is_known else None,
        in_sun=_is_in_sun(frame) and not _is_dark(frame),
    )


def _is_in_sun(frame: Frame) -> bool:
    """Return whether some of the ground is so much warmer than other, by blocks of pixels, which have less noise."""
    thermal_c = frame.image[..., frame.bands.index("thermal")]
    blocks_c = cv2.resize(thermal_c, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    coldest_c, warmest_c = np.nanquantile(blocks_c[::2, ::2], [0.1, 0.9])
    return bool(warmest_c - coldest_c >= _IN_SUN_K)


def _is_dark(frame: Frame) -> bool:
    """Return whether the frame's colours are those of a night, when clearings differ from crowns without any sun."""
    colours = [band for band, name in enumerate(frame.bands) if name in _COLOURS]
    if not colours:
        return False
    samples = frame.image[::_BACKGROUND_STRIDE, ::_BACKGROUND_STRIDE, colours]
    return float(np.nanmedian(samples)) < _DARK


def view_above(
    frame: Frame,
    contrast: NDArray[np.floating],
    min_contrast: float,
    plane_height_m: float,
    *,
    radiometric: bool = True,
) -> WarmView:
    """Return the pixels of a frame from a contrast on, on the focal plane.

    Args:
        frame: the frame.
        contrast: contrast of each pixel, shape (H, W); NaN counts as none.
        min_contrast: smallest contrast that counts.
        plane_height_m: ENU height of the focal plane. Pixels that do not look at it are left out.
        radiometric: see :class:`WarmView`.
    """
    stride = _stride(contrast >= min_contrast)
    rows, columns = stride * np.stack(np.nonzero(contrast[::stride, ::stride] >= min_contrast))
    points_enu_m = intersect_plane(np.column_stack((columns, rows)), frame.camera, frame.pose, plane_height_m)[:, :2]
    depth_m = float(frame.pose.position_enu_m[2]) - plane_height_m
    view = WarmView(
        vehicle_id=frame.vehicle_id,
        points_enu_m=points_enu_m,
        contrast_k=contrast[rows, columns].astype(np.float64),
        pixel_area_m2=stride**2 * depth_m**2 / (frame.camera.fx_px * frame.camera.fy_px),
        camera=frame.camera,
        pose=frame.pose,
        radiometric=radiometric,
        time_sigma_s=frame.time_sigma_s,
        speed_mps=frame.speed_mps,
    )
    return view.part(~np.isnan(points_enu_m[:, 0]))


def warm_bodies(views: Sequence[WarmView]) -> tuple[tuple[WarmView, ...], ...]:
    """Return the views of each warm body: pixels that lie near one another on the focal plane, whatever the frame.

    Args:
        views: views of one step or several.

    Returns:
        Per body the parts of the views that show it; the body with the most pixels first.
    """
    if not views:
        return ()
    points_enu_m = np.concatenate([view.points_enu_m for view in views])
    body_of_point = _linked(points_enu_m)
    sizes = np.bincount(body_of_point)
    rank_of_body = np.argsort(np.argsort(-sizes, kind="stable"), kind="stable")
    bodies: list[list[WarmView]] = [[] for _ in sizes]
    first = 0
    for view in views:
        end = first + len(view.points_enu_m)
        for rank, rows in _grouped(rank_of_body[body_of_point[first:end]]):
            bodies[rank].append(view.part(rows))
        first = end
    return tuple(tuple(parts) for parts in bodies)


def _stride(warm: NDArray[np.bool]) -> int:
    """Return the distance between the rows, and the columns, whose warm pixels are few enough."""
    stride = max(1, math.isqrt(np.count_nonzero(warm) // MAX_PIXELS))
    while np.count_nonzero(warm[::stride, ::stride]) > MAX_PIXELS:
        stride += 1
    return stride


def _grouped(labels: NDArray[np.intp]) -> list[tuple[int, NDArray[np.intp]]]:
    """Return each label in use with the rows that have it, in their order."""
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.diff(labels[order], prepend=-1))
    return [(int(labels[rows[0]]), rows) for rows in np.split(order, starts)[1:]]


def _linked(points_m: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the number of the group that each point belongs to, shape (n,)."""
    if not len(points_m):
        return np.empty(0, np.intp)
    (east, column), (north, row) = (
        np.unique(np.floor(along_m / _CELL_M), return_inverse=True) for along_m in points_m.T
    )
    # One integer per cell: rows of numbers are compared under the interpreter's lock, which stops every other thread.
    keys, cell_of_point = np.unique(column * len(north) + row, return_inverse=True)
    rows, columns = north[keys % len(north)], east[keys // len(north)]
    return connected(rows, columns, LINK_M / _CELL_M)[cell_of_point]
