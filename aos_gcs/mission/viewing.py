"""Views of a step beyond its pictures: other focal planes, and single frames."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

from aos_gcs.errors import AosError
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.groundmap.detection import Posture
from aos_gcs.mission.model.operation import SortieRecord


class ViewerBusyError(AosError):
    """Others wait for pictures already; ask again when one's own has come."""


class ViewKind(StrEnum):
    """Content of an integral."""

    INTEGRAL = "integral"
    """Colour, or grey."""
    THERMAL = "thermal"
    ANOMALY = "anomaly"
    """Number of frames that mark each cell."""
    COVERAGE = "coverage"
    """Number of frames that see each cell."""


class PictureFormat(StrEnum):
    """File format of a picture."""

    PNG = "png"
    """Exact, transparent where nothing covers."""
    JPEG = "jpg"
    """A draft for a plane that moves: a fifth of the size and soon encoded; black where nothing covers."""


class GroundFile(StrEnum):
    """File of the searched ground, by its suffix."""

    RASTER = "tif"
    """Views and probabilities of detection, a cloud-optimised GeoTIFF."""
    GAPS = "geojson"
    """Polygons of the search area with a low probability of detection."""


class FrameKind(StrEnum):
    """Part of a frame that is shown."""

    COLOUR = "colour"
    """Or grey."""
    THERMAL = "thermal"


@dataclass(frozen=True, slots=True)
class ViewedFrame:
    """A frame that a step has."""

    vehicle_id: int
    utc_s: float
    position_enu_m: EnuPoint
    """Position of the camera."""
    width_px: int
    height_px: int
    kinds: tuple[FrameKind, ...]
    name: str = ""
    """Name of the picture's file in a survey; empty in missions."""


@dataclass(frozen=True, slots=True)
class ViewedStep:
    """Viewable content of a step."""

    step: int
    focal_height_m: float
    """Height of the plane that the mission has used."""
    min_height_m: float
    """Lowest plane that can be looked at."""
    max_height_m: float
    kinds: tuple[ViewKind, ...]
    frames: tuple[ViewedFrame, ...]


@dataclass(frozen=True, slots=True)
class ViewWindow:
    """A square of a focal plane."""

    east_m: float
    """East coordinate of its middle."""
    north_m: float
    half_width_m: float
    nearest_only: bool = False
    """Whether of colour and thermal only the frame is shown whose camera is the nearest to its middle."""


@dataclass(frozen=True, slots=True)
class View:
    """A north-up raster of one focal plane."""

    height_m: float
    visibility_m2: float
    """Visibility of the largest blob on this plane; 0 for a part of it."""
    data: bytes = field(repr=False)
    """A file of the format that was asked for."""
    west_m: float
    south_m: float
    east_m: float
    north_m: float


@dataclass(frozen=True, slots=True)
class FocusFound:
    """The height at which the frames agree best."""

    height_m: float
    sigma_m: float
    """Standard deviation; infinite when nothing was found."""
    found: bool
    reason: str
    """Why nothing was found; empty otherwise."""


class ViewControl(Protocol):
    """Views for the API. All work is done in threads, one request after the other."""

    async def describe(self, step: int) -> ViewedStep:
        """Return what can be seen of a recorded step.

        Raises:
            InputDataError: its frames are not there, or damaged.
        """
        ...

    async def view(
        self,
        step: int,
        kind: ViewKind,
        height_m: float | None,
        window: ViewWindow | None = None,
        picture_format: PictureFormat = PictureFormat.PNG,
    ) -> View:
        """Return the integral of a step's frames on the plane of this height, None: the mission's own.

        Only the part within the window, if one is given.

        Raises:
            ConfigurationError: the height is out of range, the frames have no such band, or none looks at the window.
            InputDataError: the frames are not there, or damaged.
            ViewerBusyError: too many others wait.
        """
        ...

    async def frame(self, step: int, vehicle_id: int, kind: FrameKind, width_px: int | None) -> bytes:
        """Return a vehicle's frame of a step as a PNG, reduced to a width if it is wider.

        Raises:
            ConfigurationError: there is no such frame, or it has no such band.
            InputDataError: it is damaged.
            ViewerBusyError: too many others wait.
        """
        ...

    async def ground_file(self, kind: GroundFile, posture: Posture, below: float) -> bytes:
        """Return a file of the searched ground; gaps are where detection in a posture is less likely than ``below``.

        Raises:
            ConfigurationError: a library is not installed, the forest is not described, or ``below`` is out of range.
            InputDataError: there is no map of it, or it is damaged.
            ViewerBusyError: too many others wait.
        """
        ...

    async def autofocus(self, step: int, centre_enu_m: tuple[float, float], half_width_m: float) -> FocusFound:
        """Look for the height at which the frames agree best on a square.

        Raises:
            ConfigurationError: the square cannot be used.
            InputDataError: the frames are not there, or damaged.
            ViewerBusyError: too many others wait.
        """
        ...


class OperationView(Protocol):
    """The sorties of the operation that the shown mission belongs to."""

    async def sorties(self) -> tuple[SortieRecord, ...]:
        """Return them in the order of their numbers.

        Raises:
            InputDataError: the record of the shown mission is damaged.
        """
        ...

    async def viewer(self, mission_id: str) -> ViewControl | None:
        """Return the views of the recorded frames of a sortie; None if the operation has no such sortie."""
        ...


class SortieChoice(Protocol):
    """Choice of the sortie that a replay shows."""

    async def show(self, mission_id: str) -> bool:
        """Show another sortie of the operation to all clients, and return whether there is one of that name.

        Raises:
            InputDataError: its record cannot be shown; the replay stays where it is.
        """
        ...
