"""A recorded mission as a folder for ADIAT: geotagged frames and integrals, and the findings as areas of interest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import AosError, InputDataError
from aos_gcs.exports.adiat import FILE_NAME, AdiatImage, InterestArea, adiat_document
from aos_gcs.exports.files import folder_whole
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geotags.writing import PhotoTag, tagged_jpeg
from aos_gcs.handover.contents import read_handover
from aos_gcs.handover.model import Handover, ReportedFinding
from aos_gcs.handover.texts import STATUSES, error_text, kind_text, shortened
from aos_gcs.imaging.pictures import shade_integral, shade_thermal
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.viewing import FrameKind, PictureFormat, View, ViewedStep, ViewKind, ViewWindow
from aos_gcs.runtime.recorded.step_views import ViewSource, describe_step, view_step
from aos_gcs.runtime.recorded.viewer import view_source
from aos_gcs.store.frame_entry import FrameEntry
from aos_gcs.store.reader import MissionReader

FRAMES: Final = "frames"
INTEGRALS: Final = "integrals"
FINDINGS: Final = "findings"
HALF_WIDTH_M: Final = 6.0
"""Half the width of the ground that the picture of a finding shows."""
_SIGMAS: Final = 2.4477
"""Standard deviations of the ellipse that holds the truth with a probability of 95 %."""
_LEAST_RADIUS_M: Final = 0.5
"""Smallest radius of an area, about half a person."""
_INTEGRAL_KINDS: Final = (ViewKind.THERMAL, ViewKind.INTEGRAL)
"""Kinds of integrals; the first one of a finding that there is has the area of interest."""


@dataclass(frozen=True, slots=True)
class AdiatCounts:
    """Numbers of what was written."""

    frames: int
    integrals: int
    findings: int


def write_adiat(folder: Path, out: Path) -> AdiatCounts:
    """Write the folder for ADIAT of a mission folder.

    Args:
        folder: mission folder, also of a mission that is in flight.
        out: folder that is made; it may exist if it is empty.

    Raises:
        ConfigurationError: it cannot be written, or pillow is not installed.
        InputDataError: the record is damaged, or its place on the earth is not known.
    """
    load_extra("PIL", "geo", "Writing photographs")
    with MissionReader(folder) as reader:
        handover, source = read_handover(reader), view_source(reader)
        frame = handover.frame
        if frame is None:
            raise InputDataError(f"{folder} does not say where on the earth it was flown; it cannot be geotagged")
        with folder_whole(out) as temporary:
            for name in (FRAMES, INTEGRALS, FINDINGS):
                (temporary / name).mkdir()
            return _Writer(temporary, reader, handover, source, frame).write()


@dataclass(frozen=True, slots=True)
class _Label:
    """What the tag of an integral says beside its place."""

    model: str
    utc_s: float
    sigma_m: float | None = None


class _Writer:
    """Writes the files into a folder."""

    def __init__(
        self, out: Path, reader: MissionReader, handover: Handover, source: ViewSource, frame: LocalFrame
    ) -> None:
        self._out = out
        self._reader = reader
        self._handover = handover
        self._source = source
        self._frame = frame

    def write(self) -> AdiatCounts:
        """Write all and return what there is."""
        steps = [(record.step, record.focal_height_m) for record in self._reader.steps()]
        of_step: dict[int, list[str]] = {}
        for step, height_m in steps:
            focal_m = self._source.settings.plane_height_m if height_m is None else height_m
            of_step[step] = [name for entry in self._reader.frames(step) for name in self._frame_files(entry, focal_m)]
        integrals = sum(self._integral_files(step) for step, _ in steps)
        images = [image for reported in self._handover.findings for image in self._finding_images(reported)]
        images += [AdiatImage(name) for step in self._shown_steps() for name in of_step.get(step, [])]
        (self._out / FILE_NAME).write_text(adiat_document(images), encoding="utf-8")
        frames = sum(map(len, of_step.values()))
        return AdiatCounts(frames, integrals, sum(len(image.areas) for image in images))

    def _shown_steps(self) -> Sequence[int]:
        """Return the steps whose frames show findings of this sortie."""
        own = [one.finding for one in self._handover.findings if not one.finding.found_in]
        return sorted({finding.step for finding in own})

    def _frame_files(self, entry: FrameEntry, focal_m: float) -> Iterator[str]:
        """Write a frame, in colour and in thermal, and yield the paths."""
        capture = entry.load()
        height_m = float(self._frame.to_enu(capture.position)[2]) - focal_m
        image = capture.image.astype(np.float32)
        for kind in FrameKind:
            if kind is FrameKind.THERMAL:
                if "thermal" not in capture.bands:
                    continue
                rgba = shade_thermal(image[..., capture.bands.index("thermal")])
            elif capture.bands == ("thermal",):
                continue
            else:
                rgba = shade_integral(image, capture.bands)
            tag = PhotoTag(
                position=capture.position,
                height_above_ground_m=height_m,
                R_cam2enu=capture.R_cam2enu,
                focal_px=capture.camera.fx_px,
                model=f"Frame, {kind.value}",
                utc_s=capture.utc_s,
            )
            stem = f"{entry.step:05d}_{capture.vehicle_id:03d}_{capture.image_index:05d}_{kind.value}.jpg"
            yield self._save(f"{FRAMES}/{stem}", np.ascontiguousarray(rgba[..., :3]), tag)

    def _integral_files(self, step: int) -> int:
        """Write the integrals of a step as far as there are any, and return their number."""
        count = 0
        for kind in _INTEGRAL_KINDS:
            try:
                shown = describe_step(self._source, step)
                view = view_step(self._source, step, kind, None, window=None, picture_format=PictureFormat.PNG)
            except AosError:
                # A step without frames that can be analysed has no integral.
                continue
            name = f"{INTEGRALS}/{step:05d}_{kind.value}.jpg"
            self._save_view(name, view, shown, _Label(f"Integral, {kind.value}", _middle_utc_s(shown)))
            count += 1
        return count

    def _finding_images(self, reported: ReportedFinding) -> Iterator[AdiatImage]:
        """Write the pictures of a finding; the first has the area of interest.

        Programs that do not know the camera take the place of a picture for that of its areas, so that each finding has
        a picture of its own with the finding in its middle.
        """
        finding = reported.finding
        areas: tuple[InterestArea, ...] | None = None
        for kind in _INTEGRAL_KINDS:
            try:
                view, shown = self._finding_view(finding, kind)
            except AosError:
                continue
            name = f"{FINDINGS}/{finding.finding_id:03d}_{kind.value}.jpg"
            utc_s = reported.seen_utc_s or _middle_utc_s(shown)
            self._save_view(name, view, shown, _Label(f"Finding, {kind.value}", utc_s, finding.sigma_m))
            areas = (self._area(finding, view),) if areas is None else ()
            yield AdiatImage(name, areas, is_hidden=finding.status is FindingStatus.REJECTED)
        if areas is None:
            yield self._blank(reported)

    def _finding_view(self, finding: Finding, kind: ViewKind) -> tuple[View, ViewedStep]:
        source = self._source.of_sortie(finding.found_in)
        east_m, north_m, up_m = finding.position_enu_m
        height_m = None if finding.track_id is None else up_m
        window = ViewWindow(east_m, north_m, HALF_WIDTH_M)
        view = view_step(source, finding.step, kind, height_m, window=window, picture_format=PictureFormat.PNG)
        return view, describe_step(source, finding.step)

    def _blank(self, reported: ReportedFinding) -> AdiatImage:
        """Write a grey picture for a finding that no frame shows: its place must not be lost."""
        finding, edge = reported.finding, 400
        name = f"{FINDINGS}/{finding.finding_id:03d}_no_picture.jpg"
        view = _square(finding, edge)
        utc_s = reported.found_utc_s or self._handover.start_utc_s
        label = _Label("Finding, no picture", utc_s, finding.sigma_m)
        tag = self._nadir_tag(view, edge, 2.0 * HALF_WIDTH_M, label)
        self._save(name, np.full((edge, edge, 3), 128, dtype=np.uint8), tag)
        return AdiatImage(name, (self._area(finding, view),), is_hidden=finding.status is FindingStatus.REJECTED)

    def _area(self, finding: Finding, view: View) -> InterestArea:
        width_px = _decoded(view).shape[1]
        pixels_per_m = width_px / (view.east_m - view.west_m)
        ellipse = finding.ellipse
        radii_m = (finding.sigma_m or 0.0,) * 2 if ellipse is None else (ellipse.semi_major_m, ellipse.semi_minor_m)
        major_m, minor_m = (min(max(_LEAST_RADIUS_M, _SIGMAS * radius_m), HALF_WIDTH_M) for radius_m in radii_m)
        east_m, north_m, _ = finding.position_enu_m
        return InterestArea(
            centre_px=((east_m - view.west_m) * pixels_per_m - 0.5, (view.north_m - north_m) * pixels_per_m - 0.5),
            semi_major_px=major_m * pixels_per_m,
            semi_minor_px=minor_m * pixels_per_m,
            heading_rad=0.0 if ellipse is None else ellipse.heading_rad,
            comment=_comment(finding),
            confidence=finding.person_confidence,
            is_flagged=finding.status is FindingStatus.CONFIRMED,
            is_by_hand=finding.track_id is None,
        )

    def _save_view(self, name: str, view: View, shown: ViewedStep, label: _Label) -> None:
        rgba = _decoded(view)
        mean_height_m = sum(frame.position_enu_m[2] for frame in shown.frames) / len(shown.frames) - view.height_m
        tag = self._nadir_tag(view, rgba.shape[1], max(1.0, mean_height_m), label)
        rgb = np.where(rgba[..., 3:] > 0, rgba[..., :3], np.uint8(0)).astype(np.uint8)
        self._save(name, rgb, tag)

    def _nadir_tag(self, view: View, width_px: int, height_m: float, label: _Label) -> PhotoTag:
        """Return the tag of a camera right above the middle of a raster that sees it as it is, north up."""
        middle_m = ((view.west_m + view.east_m) / 2.0, (view.south_m + view.north_m) / 2.0)
        above: GeodeticPosition = self._frame.to_geodetic((*middle_m, view.height_m + height_m))
        return PhotoTag(
            position=above,
            height_above_ground_m=height_m,
            R_cam2enu=nadir_pose((0.0, 0.0, 0.0)).R_cam2enu,
            focal_px=height_m * width_px / (view.east_m - view.west_m),
            model=label.model,
            utc_s=label.utc_s,
            position_sigma_m=label.sigma_m,
        )

    def _save(self, name: str, rgb: NDArray[np.uint8], tag: PhotoTag) -> str:
        (self._out / name).write_bytes(tagged_jpeg(rgb, tag))
        return name


def _square(finding: Finding, edge: int) -> View:
    """Return the ground about a finding that no frame shows."""
    east_m, north_m, up_m = finding.position_enu_m
    bounds = (east_m - HALF_WIDTH_M, north_m - HALF_WIDTH_M, east_m + HALF_WIDTH_M, north_m + HALF_WIDTH_M)
    _, png = cv2.imencode(".png", np.zeros((edge, edge, 4), dtype=np.uint8))
    return View(up_m, 0.0, png.tobytes(), *bounds)


def _decoded(view: View) -> NDArray[np.uint8]:
    """Return a picture as RGBA, shape (rows, columns, 4)."""
    bgra = cv2.imdecode(np.frombuffer(view.data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    return np.asarray(cv2.cvtColor(np.asarray(bgra), cv2.COLOR_BGRA2RGBA), dtype=np.uint8)


def _middle_utc_s(shown: ViewedStep) -> float:
    times_s = [frame.utc_s for frame in shown.frames]
    return (min(times_s) + max(times_s)) / 2.0


def _comment(finding: Finding) -> str:
    """Return what is known of a finding, for people."""
    decided = f"{STATUSES[finding.status]}{f' by {finding.decided_by}' if finding.decided_by else ''}"
    parts = [f"Finding {finding.finding_id}: {kind_text(finding)}", decided, f"error {error_text(finding)} (1 sd)"]
    parts += [*finding.reasons, f"assigned to {finding.assignee}" if finding.assignee else "", finding.comment]
    return shortened("; ".join(part for part in parts if part), 2000)
