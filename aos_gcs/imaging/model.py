"""Data types of imaging: frames, rasters, blobs and the analysis of a step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose

Pixels: TypeAlias = NDArray[np.integer[Any] | np.floating[Any]]
"""Pixel values of any real type."""

MAX_SIGHTINGS = 16
"""Blobs of one step that are passed on; a swarm follows fewer."""


class Viewpoint(Protocol):
    """A frame as far as its image does not matter: which camera took it, and from where."""

    @property
    def vehicle_id(self) -> int:
        """Vehicle that took it."""

    @property
    def bands(self) -> tuple[str, ...]:
        """One name per channel of its image."""

    @property
    def pose(self) -> Pose:
        """Pose of its camera at exposure."""

    @property
    def camera(self) -> CameraModel:
        """Camera that took it."""

    @property
    def time_sigma_s(self) -> float | None:
        """Standard deviation of the time of the pose; None where it is not known."""

    @property
    def speed_mps(self) -> float:
        """Speed of its camera at exposure; 0 where that hovers."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One image with the pose of its camera at exposure."""

    vehicle_id: int
    image: NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]
    """Shape (H, W, C)."""
    bands: tuple[str, ...]
    """One name per channel: ``red, green, blue, grey, thermal``."""
    pose: Pose
    camera: CameraModel
    time_sigma_s: float | None = None
    """Standard deviation of the time of the pose; None where it is not known."""
    speed_mps: float = 0.0
    """Speed of the camera at exposure; 0 where it hovers."""


@dataclass(frozen=True, slots=True)
class FocalGrid:
    """North-up raster on the horizontal focal plane: row 0 is the northern edge, column 0 the western one."""

    west_m: float
    """East coordinate of the outer edge of column 0."""
    north_m: float
    """North coordinate of the outer edge of row 0."""
    resolution_m: float
    rows: int
    columns: int
    height_m: float
    """ENU height of the plane."""


@dataclass(frozen=True, slots=True)
class MapRaster:
    """Map of the ground in any Cartesian world: columns follow +x, rows +y or -y."""

    x_m: float
    """x coordinate of the outer edge of column 0."""
    y_m: float
    """y coordinate of the outer edge of row 0."""
    resolution_m: float
    rows: int
    columns: int
    rows_along_y: bool
    """Rows follow +y; False: -y, north-up where y points north."""

    @property
    def to_plane(self) -> NDArray[np.float64]:
        """Affine map, shape (3, 3), from cells (column, row, 1), centres at integers, to (x, y, 1) in metres."""
        r = self.resolution_m
        down = r if self.rows_along_y else -r
        return np.array([[r, 0.0, self.x_m + r / 2], [0.0, down, self.y_m + down / 2], [0.0, 0.0, 1.0]])


class Detector(StrEnum):
    """Method of anomaly detection."""

    RX = "rx"
    """Distance of all bands to the frame's own mean and covariance."""
    LOCAL_RX = "local_rx"
    """Distance of all bands to the surroundings of each pixel: for scenes whose background changes within a frame."""
    THERMAL = "thermal"
    """Warmer than the background in the thermal band alone."""


class AnomalySource(StrEnum):
    """Images that the detector is applied to."""

    MASKS = "masks"
    """Each frame; their masks are integrated, so that one clear view of the target is enough."""
    INTEGRAL = "integral"
    """The integral image; a frame marks every anomalous cell that it covers."""


class SurfaceKind(StrEnum):
    """Surface that a mission's focal plane follows."""

    TERRAIN = "terrain"
    """The ground of the mission's elevation model, where it has one: each step's plane is as high as it is there."""
    LEVEL = "level"
    """The level surface through the origin."""


class IntervalCapture(StrEnum):
    """Trigger of the frames that are taken in flight."""

    AUTO = "auto"
    """The camera itself where it can, otherwise each frame is requested."""
    OFF = "off"
    """Each frame is requested."""


class LeaderCriterion(StrEnum):
    """Measure of a vehicle's share in the visibility (spec, section 2)."""

    CONTRIBUTION = "contribution"
    """Area of the vehicle's own mask inside the largest blob of the integral, m²."""
    INTEGRAL = "integral"
    """Area of the largest blob in the virtual view of the vehicle's camera, pixels."""


@dataclass(frozen=True, slots=True)
class Blob:
    """The largest connected anomaly of an integral."""

    area_m2: float
    centroid_enu_m: tuple[float, float, float]
    """Weighted by the number of frames that mark each cell; on the focal plane."""
    max_count: int
    """The largest number of frames that agree on one cell, or where several have to agree, beside it."""


@dataclass(frozen=True, slots=True, eq=False)
class BlobView:
    """Part of a blob that one frame marks."""

    vehicle_id: int
    point_enu_m: NDArray[np.float64]
    """Centre of the cells that it marks, shape (2,), on the focal plane."""
    camera: CameraModel
    """Ideal camera, without distortion."""
    pose: Pose
    time_sigma_s: float | None = None
    """Standard deviation of the frame's time of exposure; None where it is not known."""
    speed_mps: float = 0.0
    """Speed of the camera at exposure; 0 where it hovers."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A blob, and the views that it is made of."""

    blob: Blob
    views: tuple[BlobView, ...]
    """Views of the step's own frames; at least one."""
    settled: bool = False
    """Whether the blob lies at a place that has been looked at: nothing leads a swarm there again."""
    suspected: bool = False
    """Whether the blob lies at a place where something warm may be a person."""


@dataclass(frozen=True, slots=True)
class KnownPlaces:
    """What is known of the ground before a step's frames are judged: horizontal places, east and north."""

    settled_enu_m: tuple[tuple[float, float], ...] = ()
    """Places that have been looked at: a blob there leads nobody, but is still among the sightings."""
    suspected_enu_m: tuple[tuple[float, float], ...] = ()
    """Places of warm bodies that may be persons: blobs around one are one blob, and lead however small they are."""


NOTHING_KNOWN = KnownPlaces()


@dataclass(frozen=True, slots=True, eq=False)
class VehicleMasks:
    """Masks of the vehicles' frames around the largest blob, on one window of the focal grid."""

    marked: NDArray[np.bool_]
    """Shape (n, rows, columns), in the order of ``StepAnalysis.vehicle_ids``; row 0 is the northern edge."""
    west_m: float
    """East coordinate of the outer edge of column 0."""
    north_m: float
    """North coordinate of the outer edge of row 0."""
    resolution_m: float
    """Edge of a cell."""


@dataclass(frozen=True, slots=True, eq=False)
class KeptView:
    """Part of the target that a frame of an earlier step has marked."""

    vehicle_id: int
    pose: Pose
    """Pose of its camera."""
    marked: NDArray[np.bool_]
    """Cells of a north-up raster of its own, shape (rows, columns)."""
    west_m: float
    """East coordinate of the outer edge of column 0."""
    north_m: float
    """North coordinate of the outer edge of row 0."""
    resolution_m: float
    height_m: float
    """ENU height of the focal plane that the raster lies on."""


@dataclass(frozen=True, slots=True, eq=False)
class StepAnalysis:
    """Result of the analysis of one step's frames."""

    grid: FocalGrid
    coverage: NDArray[np.uint16]
    """Number of frames that cover each cell, shape (rows, columns)."""
    anomaly_count: NDArray[np.uint16]
    """Number of frames that mark each cell, shape (rows, columns); those of the history count."""
    blob: Blob | None
    """The first of the sightings that is not at a settled place; None when no frame of the step marks a cell of one."""
    vehicle_ids: tuple[int, ...]
    """Vehicles of the frames that took part."""
    fitness: NDArray[np.float64]
    """f(x_i, I(t)) per vehicle of ``vehicle_ids``, in the unit of the leader criterion."""
    leader_id: int | None
    """argmax of ``fitness``; ties go to the view whose blob is nearest to its image centre."""
    masks: VehicleMasks | None = None
    """Masks around the largest blob; None when there is none."""
    sightings: tuple[Sighting, ...] = ()
    """All blobs, at most ``MAX_SIGHTINGS``: those at suspected places, then the largest first; settled ones last."""
    skipped: Mapping[int, str] = field(default_factory=dict)
    """Reason why a frame took no part, by vehicle."""
    present_m2: float = 0.0
    """Area of the largest blob that the step's own frames mark, without the history."""
    history: tuple[KeptView, ...] = ()
    """Views for the next step to keep."""
    mark_digests: Mapping[int, str] = field(default_factory=dict)
    """Digest of the cells that each vehicle's frame marks, by vehicle: equal for equal marks."""

    @property
    def visibility_m2(self) -> float:
        """Area of the largest blob on the focal plane."""
        return 0.0 if self.blob is None else self.blob.area_m2
