"""Recordings of photographs with positions in their metadata."""

from __future__ import annotations

import filecmp
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aos_gcs.cameras.intrinsics import Intrinsics
from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import SEA_LEVEL, AmslM, home_below_m
from aos_gcs.geometry.poses import Pose
from aos_gcs.geotags.photo import Geotag, read_geotag
from aos_gcs.geotags.sensors import Sensor
from aos_gcs.input_values import require_folder
from aos_gcs.surveys.apart import far_apart
from aos_gcs.surveys.images import THERMAL, check_image
from aos_gcs.surveys.kinds import usual_kind
from aos_gcs.surveys.model import Survey, SurveyImage, frames_of
from aos_gcs.surveys.radiometric.reading import read_thermal_camera
from aos_gcs.surveys.radiometric.settings import TemperatureSettings
from aos_gcs.surveys.takeoffs import TakeoffSite, group_takeoffs

_ALIKE_FOV = 1.3
"""Ratio of fields of view up to which photographs are of one camera."""

_MOST_BESIDE_DEG, _LEAST_TURNED_DEG = 5.0, 45.0
"""Yaw of a gimbal that follows its aircraft, beside that; from the latter on it is turned on purpose."""

_JPEG_SUFFIXES, _TIFF_SUFFIXES = frozenset({".jpg", ".jpeg"}), frozenset({".tif", ".tiff"})


@dataclass(frozen=True, slots=True, eq=False)
class _Photo:
    path: Path
    tag: Geotag
    camera: CameraModel
    height_m: float
    """Height above the ground, or above the place of takeoff."""
    takeoff_amsl_m: AmslM | None
    """Altitude of the place of takeoff, in the altitude reference of this photograph; None where it is not told."""


class _OtherSensorError(InputDataError):
    """A photograph was taken by another sensor than the one that was chosen."""


def read_photos(
    folder: Path,
    *,
    ground_amsl_m: float | None = None,
    optics: float | Intrinsics | None = None,
    lens: LensDistortion | None = None,
    sensor: Sensor | None = None,
    frames: slice = slice(None),
    temperatures: TemperatureSettings | None = None,
    on_terrain: bool = False,
) -> Survey:
    """Read the geotags of all JPEG files of a folder and of the folders in it, or where it has none of its TIFF files.

    The world is east-north-up about the first photograph's place, with z = 0 on the ground. Where several flights have
    taken off at different altitudes, that is the place of takeoff of most photographs, and each flight counts from its
    own.

    Args:
        folder: folder of the photographs, read in the order of their names.
        ground_amsl_m: altitude of the ground, to be compared with the photographs' absolute altitudes. None: the ground
            is where the flight began, and the photographs' relative altitudes are heights above it.
        optics: horizontal field of view, or intrinsics; they replace the focal lengths in the photographs' metadata.
        lens: lens of all photographs; replaces that of the intrinsics.
        sensor: leaves out the pictures of other sensors; needed where a folder has those of several. None: models of
            cameras, sizes of pictures (in either orientation) and fields of view must agree as well.
        frames: photographs that are looked at, in the order of their names, those of a folder together.
        temperatures: settings under which temperatures are read from radiometric photographs; None: pictures are read.
        on_terrain: whether a terrain takes the place of the plane z = 0, so that several takeoffs need no remedy.

    Raises:
        InputDataError: if there is no photograph, none can be used, or several cameras have taken them; the text names
            the reason.
        ConfigurationError: if pillow or defusedxml is not installed, or DJI's Thermal SDK is not usable.
    """
    require_folder(folder, f"The image folder {folder}")
    paths = _photographs_in(folder)
    if not paths:
        raise InputDataError(
            f"The folder {folder} has no photographs (.jpg, .jpeg, .tif, .tiff); for other images give their --poses."
        )
    paths = frames_of(paths, frames, f"photographs in {folder}")
    photos: list[_Photo] = []
    left_out: dict[str, str] = {}
    not_chosen: list[str] = []
    by_size: dict[int, list[Path]] = {}
    for path in paths:
        name = path.relative_to(folder).as_posix()
        try:
            photo = _read(path, ground_amsl_m, optics, lens, temperatures, sensor=sensor)
            _refuse_copy(path, by_size.setdefault(path.stat().st_size, []))
        except InputDataError as error:
            left_out[name] = str(error)
            not_chosen += [name] if isinstance(error, _OtherSensorError) else []
            continue
        photos.append(photo)
        by_size[path.stat().st_size].append(path)
    if not photos:
        name, reason = next(iter(left_out.items()))
        remedy = "; images without tags need --poses" if Path(name).suffix.lower() in _TIFF_SUFFIXES else ""
        raise InputDataError(f"None of the {len(paths)} photographs in {folder} can be used; {name}: {reason}{remedy}")
    if sensor is None:
        _refuse_mixed(photos, folder)
    photos = _together(photos, left_out, folder)
    kind = None
    if temperatures is None:
        usual = usual_kind([photo.path for photo in photos], None, f"photographs in {folder}", same_size=False)
        kind = usual.kind
        left_out |= {path.relative_to(folder).as_posix(): reason for path, reason in usual.odd.items()}
        photos = [photo for photo in photos if photo.path not in usual.odd]
    takeoffs = group_takeoffs([photo.takeoff_amsl_m for photo in photos])
    photos = _with_shared_takeoffs(photos, takeoffs)
    # Without any altitude the map's scale suffers, by a millionth per six metres, and terrain lies at a wrong height.
    takeoff_amsl_m = takeoffs[0].altitude_amsl_m if takeoffs else SEA_LEVEL
    ground = takeoff_amsl_m if ground_amsl_m is None else AmslM(ground_amsl_m)
    world = LocalFrame(GeodeticPosition(photos[0].tag.latitude_deg, photos[0].tag.longitude_deg, ground))
    dtype = None if kind is None else kind.dtype
    images = tuple(
        replace(_placed(photo, world, ground_amsl_m), dtype=dtype, temperatures=temperatures) for photo in photos
    )
    warnings = () if ground_amsl_m is not None else _takeoff_warnings(photos, takeoffs, folder, on_terrain=on_terrain)
    return Survey(
        images,
        THERMAL if kind is None else kind.bands,
        world.origin,
        left_out,
        remarks=_remarks(photos),
        warnings=warnings,
        takeoffs=takeoffs,
        not_chosen=frozenset(not_chosen),
    )


def _with_shared_takeoffs(photos: Sequence[_Photo], takeoffs: Sequence[TakeoffSite]) -> list[_Photo]:
    """Return photographs with the altitudes of their takeoffs."""
    altitudes_m = {index: takeoff.altitude_amsl_m for takeoff in takeoffs for index in takeoff.photographs}
    return [replace(photo, takeoff_amsl_m=altitudes_m.get(index)) for index, photo in enumerate(photos)]


def _photographs_in(folder: Path) -> list[Path]:
    """Return the photographs of a folder and its folders; hidden ones hold thumbnails and what was deleted.

    TIFF files beside JPEG files are maps, or temperatures that were made of the same pictures.
    """
    files = sorted(
        path
        for path in folder.rglob("*")
        if path.suffix.lower() in _JPEG_SUFFIXES | _TIFF_SUFFIXES
        and path.is_file()
        and not any(part.startswith(".") for part in path.relative_to(folder).parts)
    )
    return [path for path in files if path.suffix.lower() in _JPEG_SUFFIXES] or files


def _remarks(photos: Sequence[_Photo]) -> tuple[str, ...]:
    """Return what is worth knowing of the photographs: how well they are placed, and what may have turned them."""
    remarks = []
    sigmas_m = np.array([photo.tag.position_sigma_m for photo in photos if photo.tag.position_sigma_m is not None])
    if len(sigmas_m):
        across_m, up_m = np.median(sigmas_m[:, :2]), np.median(sigmas_m[:, 2])
        remarks.append(
            f"RTK positions of {len(sigmas_m)} of {len(photos)} photographs: median standard deviation "
            f"{across_m:.3f} m horizontally, {up_m:.3f} m vertically"
        )
    floating = [photo.path.name for photo in photos if photo.tag.has_rtk_fix is False]
    if floating:
        remarks.append(
            f"{len(floating)} of {len(photos)} photographs were taken without a fixed RTK solution; the first is "
            f"{floating[0]}"
        )
    turned = [photo.path.name for photo in photos if photo.tag.is_turned]
    if turned:
        remarks.append(f"{len(turned)} photographs are turned by their Orientation tag; the first is {turned[0]}")
    besides_rad = [photo.tag.yaw_beside_aircraft_rad for photo in photos]
    told_deg = np.degrees([beside_rad for beside_rad in besides_rad if beside_rad is not None])
    beside_deg = float(np.median(told_deg)) if len(told_deg) else 0.0
    if _MOST_BESIDE_DEG < abs(beside_deg) < _LEAST_TURNED_DEG:
        remarks.append(
            f"the gimbal's yaw is {beside_deg:+.0f}° from the aircraft's in the median: one that looks straight down "
            "may tell it wrong, which calibrate --out finds"
        )
    programs = _groups(photos, lambda photo: photo.tag.software or "")
    usual = max(programs, key=lambda name: len(programs[name]))
    edited = [photo for photo in photos if photo.tag.software not in {None, usual}]
    if edited:
        remarks.append(
            f"{len(edited)} of {len(photos)} photographs were saved by other software than the rest, such as "
            f"{edited[0].path.name} by {edited[0].tag.software}: where it has turned pictures, take the camera's own"
        )
    return tuple(remarks)


def _takeoff_warnings(
    photos: Sequence[_Photo], takeoffs: Sequence[TakeoffSite], folder: Path, *, on_terrain: bool
) -> tuple[str, ...]:
    """Return what makes heights doubtful: several takeoffs, and altitudes that no flight has."""

    def name(index: int) -> str:
        return photos[index].path.relative_to(folder).as_posix()

    warnings = []
    if len(takeoffs) > 1:
        low, high = (end(takeoffs, key=lambda one: one.altitude_amsl_m) for end in (min, max))
        apart_m = high.altitude_amsl_m - low.altitude_amsl_m
        count, up_to = ("two", "") if len(takeoffs) == 2 else (len(takeoffs), "up to ")
        remedy = "give --ground or --dem, or one folder for each flight"
        if on_terrain:
            remedy = (
                "each counts from its own. If they began at one place, their altitudes err: one folder for each flight"
            )
        warnings.append(
            f"photographs of {count} takeoffs, {up_to}{apart_m:.0f} m apart in height, such as "
            f"{name(low.photographs[0])} and {name(high.photographs[0])}: {remedy}"
        )
    strays = sorted(index for takeoff in takeoffs for index in takeoff.strays)
    if strays:
        warnings.append(
            f"{len(strays)} of {len(photos)} photographs have an absolute altitude that does not fit those beside "
            f"them, and count from the same takeoff as these; the first is {name(strays[0])}"
        )
    return tuple(warnings)


def _radiometric_camera(
    path: Path, tag: Geotag, optics: float | Intrinsics | None, settings: TemperatureSettings
) -> CameraModel:
    """Return the camera of the temperatures of a photograph, which may have another size than its picture.

    Raises:
        InputDataError: if it has no temperatures.
    """
    thermal = read_thermal_camera(path.read_bytes(), settings)
    width_px, height_px = thermal.width_px, thermal.height_px
    if isinstance(optics, Intrinsics):
        return optics.camera(width_px, height_px)
    fov_rad = optics or thermal.horizontal_fov_rad
    if fov_rad is None:
        told = _camera_of_tags(tag)
        size_px = told.width_px, told.height_px
        intrinsics = Intrinsics(told.fx_px, told.fy_px, told.cx_px, told.cy_px, size_px, told.distortion, "its picture")
        return intrinsics.camera(width_px, height_px)
    return CameraModel.from_fov(width_px, height_px, fov_rad)


def _camera_of_tags(tag: Geotag) -> CameraModel:
    try:
        return tag.camera()
    except InputDataError as error:
        raise InputDataError(f"{error}: give the field of view (--fov) or a camera file (--camera)") from error


def _read(
    path: Path,
    ground_amsl_m: float | None,
    optics: float | Intrinsics | None,
    lens: LensDistortion | None,
    temperatures: TemperatureSettings | None,
    *,
    sensor: Sensor | None,
) -> _Photo:
    check_image(path)
    tag = read_geotag(path)
    _refuse_other_sensor(tag.sensor, sensor)
    if temperatures is not None:
        camera = _radiometric_camera(path, tag, optics, temperatures)
    elif isinstance(optics, Intrinsics):
        camera = optics.camera(tag.width_px, tag.height_px)
    else:
        camera = _camera_of_tags(tag) if optics is None else tag.camera(optics)
    camera = replace(camera, distortion=lens or camera.distortion)
    takeoff_amsl_m: AmslM | None = None
    if tag.altitude_amsl_m is not None and tag.relative_altitude_m is not None:
        takeoff_amsl_m = home_below_m(tag.altitude_amsl_m, tag.relative_altitude_m)
    if ground_amsl_m is not None:
        if tag.altitude_amsl_m is None:
            raise InputDataError("it has neither AbsoluteAltitude nor GPSAltitude")
        return _Photo(path, tag, camera, tag.altitude_amsl_m - ground_amsl_m, takeoff_amsl_m)
    if tag.relative_altitude_m is None:
        raise InputDataError("it has no RelativeAltitude; give the altitude of the ground (--ground)")
    return _Photo(path, tag, camera, tag.relative_altitude_m, takeoff_amsl_m)


def _refuse_other_sensor(sensor: Sensor | None, wanted: Sensor | None) -> None:
    if wanted is not None and sensor is not wanted:
        taken_by = "does not name its sensor" if sensor is None else f"was taken by the sensor {sensor}"
        raise _OtherSensorError(f"it {taken_by}")


def _refuse_mixed(photos: Sequence[_Photo], folder: Path) -> None:
    """Refuse photographs of several sensors: thermal and colour pictures, or wide and narrow ones, have no average."""
    sensors = _groups(photos, lambda photo: photo.tag.sensor or "an unknown sensor")
    if len(sensors) > 1:
        raise InputDataError(
            f"The folder {folder} has photographs of several sensors ({_listed(sensors)}): choose one with --sensor "
            "thermal, wide or zoom."
        )
    sensor = photos[0].tag.sensor
    remedy = "Put those of one camera into a folder" + (f", or use all with --sensor {sensor}." if sensor else ".")
    models = _groups([photo for photo in photos if photo.tag.model], lambda photo: f"the model {photo.tag.model}")
    sizes = _groups(photos, lambda photo: "{1} x {0} pixels".format(*sorted(_size(photo))))
    for groups in (models, sizes):
        if len(groups) > 1:
            raise InputDataError(
                f"The folder {folder} has photographs of different cameras ({_listed(groups)}). {remedy}"
            )
    fovs = sorted(photos, key=lambda photo: photo.camera.horizontal_fov_rad)
    narrow, wide = fovs[0], fovs[-1]
    if wide.camera.horizontal_fov_rad > _ALIKE_FOV * narrow.camera.horizontal_fov_rad:
        narrow_deg, wide_deg = (math.degrees(photo.camera.horizontal_fov_rad) for photo in (narrow, wide))
        raise InputDataError(
            f"The folder {folder} has photographs of different cameras: {narrow.path.name} has a field of view of "
            f"{narrow_deg:.0f}°, {wide.path.name} of {wide_deg:.0f}°. {remedy}"
        )


def _size(photo: _Photo) -> tuple[int, int]:
    return photo.camera.width_px, photo.camera.height_px


def _groups(photos: Sequence[_Photo], kind_of: Callable[[_Photo], str]) -> dict[str, list[_Photo]]:
    """Return photographs by what they are of, in the order in which the kinds appear."""
    groups: dict[str, list[_Photo]] = {}
    for photo in photos:
        groups.setdefault(kind_of(photo), []).append(photo)
    return groups


def _listed(groups: Mapping[str, Sequence[_Photo]]) -> str:
    return "; ".join(f"{len(members)} of {kind}, such as {members[0].path.name}" for kind, members in groups.items())


def _together(photos: Sequence[_Photo], left_out: dict[str, str], folder: Path) -> list[_Photo]:
    """Return photographs without those that lie far from the others."""
    places = [GeodeticPosition(photo.tag.latitude_deg, photo.tag.longitude_deg, SEA_LEVEL) for photo in photos]
    world = LocalFrame(places[0])
    far = far_apart([world.to_enu(place) for place in places])
    if len(far) == len(photos):
        raise InputDataError(f"The photographs in {folder} lie far from each other: put those of one flight into it.")
    left_out.update({photos[index].path.relative_to(folder).as_posix(): f"it {text}" for index, text in far.items()})
    return [photo for index, photo in enumerate(photos) if index not in far]


def _refuse_copy(path: Path, others: Sequence[Path]) -> None:
    """Refuse a photograph that is one of others of its size: what it shows would count as if two had seen it."""
    for other in others:
        if filecmp.cmp(path, other, shallow=False):
            raise InputDataError(f"it is a copy of {other.name}")


def _placed(photo: _Photo, world: LocalFrame, ground_amsl_m: float | None) -> SurveyImage:
    below_amsl_m = photo.takeoff_amsl_m if ground_amsl_m is None else ground_amsl_m
    altitude_m = AmslM((world.origin.altitude_amsl_m if below_amsl_m is None else below_amsl_m) + photo.height_m)
    position = GeodeticPosition(photo.tag.latitude_deg, photo.tag.longitude_deg, altitude_m)
    return SurveyImage(
        photo.path,
        Pose(world.to_enu(position), photo.tag.R_cam2enu),
        photo.camera,
        taken_at_s=photo.tag.utc_s,
        position_sigma_m=photo.tag.position_sigma_m,
        relative_altitude_m=photo.tag.relative_altitude_m,
    )
