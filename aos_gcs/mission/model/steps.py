"""Steps of the search, their focal plane and their pictures."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.model.phase import Phase


class FocusSource(StrEnum):
    """Source of the focal height."""

    CONFIGURED = "configured"
    AUTOFOCUS = "autofocus"
    OPERATOR = "operator"


@dataclass(frozen=True, slots=True)
class FocusSnapshot:
    """The focal plane in use."""

    height_m: float
    """Height above the origin."""
    source: FocusSource
    sigma_m: float | None
    """Standard deviation of what autofocus has found; None for other sources."""


@dataclass(frozen=True, slots=True)
class StepRecord:
    """One step: what was seen, what was decided."""

    step: int
    elapsed_s: float
    phase: Phase
    visibility_m2: float
    threshold_m2: float
    branch: str
    evolutionary_factor: float | None
    evolutionary_state: str | None
    c_s_m: float | None
    c_c_m: float | None
    leader_id: int | None
    target_enu_m: EnuPoint | None
    """This step's own measurement, when the target is in view."""
    fitness: dict[int, float]
    """f per vehicle that delivered a frame."""
    missing: dict[int, str]
    """Vehicles that the step went on without, with the reason."""
    waypoints: tuple[WaypointRecord, ...]
    imaging_ms: float
    work_ms: float
    """Time from the last frame received to the last goto handed to the link, real milliseconds."""
    loop_lag_p99_ms: float
    """99th percentile of the event loop's lag since the previous step, real milliseconds."""
    visibility_present_m2: float | None = None
    """The part of ``visibility_m2`` that this step's own frames show; None in older records."""
    focal_height_m: float | None = None
    """Height of the plane on which this step's frames were integrated."""


class PictureKind(StrEnum):
    """The rasters that are shown live."""

    INTEGRAL = "integral"
    """Colour (or grey) integral."""
    THERMAL = "thermal"
    ANOMALY = "anomaly"
    """Number of frames that mark each cell."""
    COVERAGE = "coverage"
    """Number of frames of the whole mission that show each place of the search area."""
    VISIBILITY = "visibility"
    """Greatest share of the ground that these can have seen through a canopy of the configured density."""
    VIEWS = "views"
    """Number of independent views of each place that was searched, in this sortie and those before it."""
    DETECTION = "detection"
    """Probability that a standing person there would have been marked by them, under the configured canopy."""
    FLOOR = "floor"
    """Mean colour of each place that was searched, or its mean temperature where no frame has colours."""
    PRIOR = "prior"
    """Probability before the search that the person is at a place of the search area, as the configured file has it."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A north-up raster on the focal plane, ready to show."""

    kind: PictureKind
    step: int
    png: bytes = field(repr=False)
    """RGBA; transparent where nothing covers."""
    west_m: float
    south_m: float
    east_m: float
    north_m: float
