"""Camera settings of each vehicle: the tables ``camera`` and ``cameras.ID`` of a driver's options."""

from __future__ import annotations

import logging
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from string import Formatter
from types import MappingProxyType
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from aos_drivers.frames.poses.mount import CameraMount, Carrier
from aos_drivers.option_table import OptionTable
from aos_gcs.cameras.calibration import Calibration, read_calibration, warning
from aos_gcs.errors import CaptureError, ConfigurationError, InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.camera import CameraModel

_log = logging.getLogger(__name__)


class SourceKind(StrEnum):
    """Kind of source of the frames."""

    COMPONENT = "component"
    """A MAVLink camera component that names a URL."""
    REPORTED = "reported"
    """Exposures reported by the autopilot (CAMERA_FEEDBACK, CAMERA_IMAGE_CAPTURED), with files from elsewhere."""
    PHOTOS = "photos"
    """Geotagged photographs."""
    VIDEO = "video"
    """A stream, RTSP or RTP."""


@dataclass(frozen=True, slots=True)
class ImagePlace:
    """Location of the image files: either a folder or a web server."""

    folder: str | None = None
    """Path of the folder; may contain ``{vehicle_id}``."""
    url: str | None = None
    """Address; may contain ``{vehicle_id}``, ``{host}`` (the vehicle's) and ``{index}``; without it, of a listing."""
    file_name: str | None = None
    """Pattern of the file's name, such as ``DSC{index:05d}.JPG``; None: files are matched by time."""

    @property
    def has_index(self) -> bool:
        """Whether the address itself names the image."""
        return self.url is not None and "{index" in self.url

    def folder_of(self, vehicle_id: int) -> Path | None:
        """Return the folder of one vehicle."""
        return None if self.folder is None else Path(self.folder.format(vehicle_id=vehicle_id)).expanduser()

    def url_of(self, vehicle_id: int, host: str, index: int = 0) -> str:
        """Return the address on one vehicle's host, an IPv6 one in brackets.

        Raises:
            CaptureError: the vehicle has no host, as on a serial link, and the address needs it.
        """
        if not host and "{host}" in (self.url or ""):
            raise CaptureError(f"vehicle {vehicle_id} has no network address: write the host of its images into url")
        host = f"[{host}]" if ":" in host else host
        return (self.url or "").format(vehicle_id=vehicle_id, host=host, index=index)


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """Settings for the frames of one vehicle."""

    source: SourceKind = SourceKind.COMPONENT
    place: ImagePlace = field(default_factory=ImagePlace)
    """Location of the images, or of the stream."""
    is_triggered: bool = True
    """Whether each frame is commanded; otherwise the camera fires automatically, and the next frame is used."""
    index_offset: int = 0
    """Number in the name of a file minus the index that the autopilot reports."""
    match_tolerance_s: float = 1.0
    """Largest difference between the time of a file and that of its exposure."""
    fov_rad: float | None = None
    """Full horizontal field of view; None: as reported by the camera."""
    calibration: Calibration | None = None
    """Intrinsics, boresight and clock of the camera; they replace the field of view."""
    mount: CameraMount = field(default_factory=CameraMount)
    max_pose_age_s: float = 0.5
    """Largest time between a frame and the nearest report of the vehicle's motion."""
    max_pose_offset_m: float = 50.0
    """Largest distance between the position of a frame and those that the vehicle reports."""
    pose_hz: float = 10.0
    """Requested rate of attitudes and positions, where poses are interpolated."""
    latency_s: float = 0.2
    """Delay from exposure to arrival, for streams without times."""
    latency_sigma_s: float = 0.1

    @property
    def needs_motion(self) -> bool:
        """Whether poses are interpolated from the motion that the vehicle reports."""
        return self.source in (SourceKind.REPORTED, SourceKind.VIDEO)

    @property
    def clock_offset_s(self) -> float:
        """Addition to the times of images that makes them times of the vehicle's motion."""
        return 0.0 if self.calibration is None else self.calibration.clock_offset_s

    def check_lens(self, reported_fov_rad: float | None = None) -> None:
        """Refuse a camera without a known lens, before its image is fetched.

        Raises:
            CaptureError: neither calibration, option nor camera tell the field of view.
        """
        if self.calibration is None and not (self.fov_rad or reported_fov_rad):
            raise CaptureError("the camera does not report its lens: set the option camera.fov_deg")

    def camera(self, width_px: int, height_px: int, reported_fov_rad: float | None = None) -> CameraModel:
        """Return the camera of images of a size; ``reported_fov_rad`` is the field of view that it reports itself.

        Raises:
            CaptureError: its lens is not known, or is that of images of another shape.
        """
        if self.calibration is not None:
            try:
                return self.calibration.intrinsics.camera(width_px, height_px)
            except InputDataError as error:
                raise CaptureError(str(error)) from error
        self.check_lens(reported_fov_rad)
        return CameraModel.from_fov(width_px, height_px, self.fov_rad or reported_fov_rad or 0.0)

    def calibrated(self, R_cam2enu: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the camera's orientation, shape (3, 3), for the one that vehicle and mount report."""
        return R_cam2enu if self.calibration is None else R_cam2enu @ self.calibration.R_calibrated2recorded


@dataclass(frozen=True, slots=True)
class CameraPlan:
    """The settings of all vehicles."""

    default: CameraSettings = field(default_factory=CameraSettings)
    by_vehicle: Mapping[int, CameraSettings] = field(default_factory=lambda: MappingProxyType({}))

    def of(self, vehicle_id: int) -> CameraSettings:
        """Return the settings of one vehicle."""
        return self.by_vehicle.get(vehicle_id, self.default)


_PLACE = ("source", "folder", "url", "file_name")
_OPTICS = ("fov_deg", "calibration")
_FIELDS = (
    *_PLACE,
    "trigger",
    "index_offset",
    "match_tolerance_s",
    "fov_deg",
    "calibration",
    "carrier",
    "mount_deg",
    "lever_arm_m",
    "max_pose_age_s",
    "max_pose_offset_m",
    "pose_hz",
    "latency_s",
    "latency_sigma_s",
)
Choice = TypeVar("Choice", bound=StrEnum)
_STREAM_SCHEMES = ("rtsp://", "rtsps://", "rtp://", "udp://", "tcp://")


def parse_cameras(options: OptionTable) -> CameraPlan:
    """Return the cameras of a driver's options: ``camera`` for all vehicles, ``cameras.ID`` for what differs in one.

    Raises:
        ConfigurationError: an option is unknown, out of range, or does not fit the source; or a library for the
            source is not installed.
    """
    common, tables = options.mapping("camera"), options.table("cameras")
    by_vehicle = {}
    for name, own in options.mapping("cameras").items():
        if not name.isdecimal() or not 1 <= int(name) <= 255 or not isinstance(own, Mapping):
            raise ConfigurationError(f"{tables.place}.{name} must be a table named by a system id, such as cameras.3")
        # Another source or place is a new one: nothing of the common one fits it.
        inherited = {key: common[key] for key in common if own.keys().isdisjoint(_PLACE) or key not in _PLACE}
        if not own.keys().isdisjoint(_OPTICS):
            inherited = {key: value for key, value in inherited.items() if key not in _OPTICS}
        by_vehicle[int(name)] = _parse_camera(OptionTable({**inherited, **own}, f"{tables.place}.{name}"))
    plan = CameraPlan(_parse_camera(options.table("camera")), MappingProxyType(by_vehicle))
    for settings in (plan.default, *by_vehicle.values()):
        _check_libraries(settings.source)
    return plan


def _check_libraries(source: SourceKind) -> None:
    """Name a library that is missing before anything is opened, rather than at the first frame."""
    if source is SourceKind.PHOTOS:
        load_extra("PIL.Image", "geo", "Reading geotagged photographs")
    elif source is SourceKind.VIDEO:
        load_extra("av", "video", "Receiving video")


def _parse_camera(table: OptionTable) -> CameraSettings:
    table.refuse_unknown(_FIELDS)
    source = _choice(table, "source", SourceKind, SourceKind.COMPONENT)
    defaults = CameraSettings()
    fov_deg = table.optional_number("fov_deg", 1.0, 179.0)
    calibration = _parse_calibration(table)
    return CameraSettings(
        source=source,
        place=_parse_place(table, source),
        is_triggered=table.flag("trigger", default=True),
        index_offset=table.integer("index_offset", 0),
        match_tolerance_s=table.number("match_tolerance_s", defaults.match_tolerance_s, 0.01, 60.0),
        fov_rad=None if fov_deg is None else math.radians(fov_deg),
        calibration=calibration,
        mount=_parse_mount(table),
        max_pose_age_s=table.number("max_pose_age_s", defaults.max_pose_age_s, 0.01, 10.0),
        max_pose_offset_m=table.number("max_pose_offset_m", defaults.max_pose_offset_m, 1.0, 10_000.0),
        pose_hz=table.number("pose_hz", defaults.pose_hz, 1.0, 50.0),
        latency_s=table.number("latency_s", defaults.latency_s, 0.0, 10.0),
        latency_sigma_s=table.number("latency_sigma_s", defaults.latency_sigma_s, 0.0, 10.0),
    )


def _parse_calibration(table: OptionTable) -> Calibration | None:
    path = table.text("calibration")
    if path is None:
        return None
    if "fov_deg" in table:
        raise ConfigurationError(f"{table.place}: calibration and fov_deg exclude each other: it contains the camera")
    file = Path(path).expanduser()
    try:
        calibration = read_calibration(file)
    except InputDataError as error:
        raise ConfigurationError(f"{table.place}.calibration: {error}") from error
    doubtful = warning(calibration, file)
    if doubtful is not None:
        _log.warning("%s.calibration: %s", table.place, doubtful)
    return calibration


def _parse_place(table: OptionTable, source: SourceKind) -> ImagePlace:
    place = ImagePlace(table.text("folder"), table.text("url"), table.text("file_name"))
    if source is SourceKind.COMPONENT:
        for name in _PLACE[1:]:
            if name in table:
                raise ConfigurationError(
                    f"{table.place}.{name} has no meaning for a camera that names its images itself: "
                    f'set {table.place}.source to "reported", "photos" or "video"'
                )
        return place
    if source is SourceKind.VIDEO:
        if place.folder is not None or place.url is None or not _is_stream(place.url):
            raise ConfigurationError(f"{table.place}.url must be a stream ({', '.join(_STREAM_SCHEMES)} or FILE.sdp)")
    elif (place.folder is None) == (place.url is None):
        raise ConfigurationError(f"{table.place} needs one of folder and url, where the images appear")
    elif place.url is not None and not place.url.startswith(("http://", "https://")):
        raise table.error("url", "an address of http or https")
    elif source is SourceKind.PHOTOS and place.has_index:
        raise table.error("url", "that of a listing: the index of a photograph is not known")
    _check_template(table, "folder", place.folder, ["vehicle_id"])
    _check_template(table, "url", place.url, ["vehicle_id", "host", "index"])
    _check_template(table, "file_name", place.file_name, ["index"])
    if place.file_name is not None and "{index" not in place.file_name:
        raise table.error("file_name", "a name with {index} in it, such as DSC{index:05d}.JPG")
    return place


def _is_stream(url: str) -> bool:
    return url.startswith(_STREAM_SCHEMES) or url.endswith(".sdp")


def _check_template(table: OptionTable, name: str, template: str | None, known: Collection[str]) -> None:
    """Refuse all but plain fields of the known names, with at most a width of three digits."""
    try:
        fields = [part[1:] for part in Formatter().parse(template or "") if part[1] is not None]
    except ValueError:
        fields = [("", "", "")]
    if any(field not in known or conversion or len(width or "") > 4 for field, width, conversion in fields):
        wanted = ", ".join(f"{{{value}}}" for value in known)
        raise ConfigurationError(f"{table.place}.{name}: {template!r} cannot be filled in: use {wanted}")


def _parse_mount(table: OptionTable) -> CameraMount:
    carrier = _choice(table, "carrier", Carrier, Carrier.BODY)
    # A gimbal that reports its attitude reports that of the camera.
    default_deg = (0.0, 0.0, 0.0) if carrier is Carrier.GIMBAL else (0.0, -90.0, 0.0)
    yaw_deg, pitch_deg, roll_deg = table.triple("mount_deg", default_deg, 360.0)
    angles_rad = (math.radians(yaw_deg), math.radians(pitch_deg), math.radians(roll_deg))
    return CameraMount(carrier, angles_rad, table.triple("lever_arm_m", (0.0, 0.0, 0.0), 10.0))


def _choice(table: OptionTable, name: str, kind: type[Choice], default: Choice) -> Choice:
    text = table.text(name)
    if text is None:
        return default
    try:
        return kind(text)
    except ValueError as error:
        raise table.error(name, f"one of {', '.join(kind)}") from error
