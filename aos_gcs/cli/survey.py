"""``aos-gcs survey``: the dashboard on a folder of photographs or a recorded flight."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aos_gcs.cli import autofocus_options, result_options, surface_options, survey_options
from aos_gcs.cli.run import CODE_FILE_HELP, run_until_terminated
from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.model import Detector
from aos_gcs.input_values import printable, require_folder
from aos_gcs.surveys.images import SUFFIXES
from aos_gcs.surveys.significance import DEFAULT_FALSE_ALARMS_PER_HA

if TYPE_CHECKING:
    from aos_gcs.examination.examiner import Examination
    from aos_gcs.mission.model.snapshot import MissionSnapshot
    from aos_gcs.surveys.projected import ProjectedSystem
    from aos_gcs.surveys.window_anomalies import Detection

PANEL = "Survey"


def survey(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder with the images, or the results of an earlier survey.")
    ],
    *,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for the results; one that holds them already is shown without computing again.",
            show_default="the folder's name with -survey, beside it",
            rich_help_panel=PANEL,
        ),
    ] = None,
    crs: Annotated[
        str | None,
        typer.Option(
            metavar="EPSG:CODE",
            help="Projected coordinate system of the poses (easting, northing, altitude), unless --origin is given; "
            "findings of --json have eastings and northings in it.",
            rich_help_panel=survey_options.PANEL,
        ),
    ] = None,
    poses: survey_options.Poses = None,
    fov: survey_options.Fov = None,
    camera: survey_options.Camera = None,
    calibration: survey_options.CalibrationFile = None,
    lens: survey_options.Lens = None,
    fisheye: survey_options.Fisheye = None,
    origin: survey_options.Origin = None,
    convention: survey_options.Convention = None,
    frames: survey_options.FrameRange = None,
    ground: survey_options.Ground = None,
    sensor: survey_options.SensorName = None,
    degrees: survey_options.Degrees = None,
    dji_sdk: survey_options.DjiSdk = None,
    plane_z: autofocus_options.PlaneZ = None,
    dem: surface_options.Dem = None,
    dem_offset: surface_options.DemOffset = None,
    detector: result_options.DetectorName = Detector.LOCAL_RX,
    min_score: result_options.MinScore = None,
    false_alarms_per_ha: result_options.FalseAlarmsPerHa = DEFAULT_FALSE_ALARMS_PER_HA,
    headless: Annotated[
        bool, typer.Option("--headless", help="Examine without the dashboard, and exit.", rich_help_panel=PANEL)
    ] = False,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="With --headless: print the findings as one JSON object.", rich_help_panel=PANEL),
    ] = False,
    host: Annotated[str, typer.Option(help="Network address on which the dashboard listens.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port of the dashboard.", min=0, max=65535)] = 8080,
    operator_code_file: Annotated[Path | None, typer.Option(help=CODE_FILE_HELP, dir_okay=False)] = None,
) -> None:
    """Look for persons in photographs or a recorded flight, and show the findings on the dashboard.

    Frames that overlap are examined together: places on which more of them agree than chance explains are judged as in
    missions. Findings appear while the rest is examined. Operators judge them, and their decisions are kept with the
    results. Ctrl-C ends it; started again, it goes on where it was.
    """
    from aos_gcs.config.file import dashboard_of  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.imaging.step.settings import ImagingSettings  # noqa: PLC0415
    from aos_gcs.runtime.survey import SurveyFolder, is_survey, run_survey  # noqa: PLC0415
    from aos_gcs.store.recorder import FOLDER_NAME  # noqa: PLC0415
    from aos_gcs.surveys.window_anomalies import Detection  # noqa: PLC0415

    if as_json and not headless:
        raise ConfigurationError("--json requires --headless.")
    if headless and operator_code_file is not None:
        raise ConfigurationError("--headless shows no dashboard: leave --operator-code-file out.")
    config = None if headless else dashboard_of(host, port, operator_code_file)
    detection = Detection(detector, min_score, false_alarms_per_ha)
    system = _system(crs)
    recording = _Recording(
        folder=folder,
        poses=poses,
        optics=survey_options.CameraOptions(fov, camera, lens, fisheye, calibration),
        origin=origin,
        convention=convention,
        frames=frames,
        ground=ground,
        sensor=sensor,
        degrees=degrees,
        dji_sdk=dji_sdk,
        plane_z=plane_z,
        dem=dem,
        dem_offset=dem_offset,
        system=system,
        detection=detection,
    )
    require_folder(folder, f"The image folder {folder}")
    if is_survey(folder):
        results = SurveyFolder(folder, None, None)
    else:
        chosen = out or folder.resolve().with_name(_folder_name(folder))
        if not re.fullmatch(FOLDER_NAME, chosen.name):
            raise ConfigurationError(f"--out {chosen}: name the folder by letters, digits, - and _, without spaces.")
        results = SurveyFolder(chosen, recording.inputs(chosen), recording.examination)
    imaging = ImagingSettings(detector=detector, rx_min_score=min_score)
    snapshot = run_until_terminated(run_survey(results, config, imaging))
    if as_json:
        typer.echo(json.dumps(_as_data(snapshot, results.folder, system)))
    else:
        typer.echo(f"{snapshot.message} Results in {results.folder}.")


@dataclass(frozen=True, slots=True)
class _Recording:
    """A recording as the options tell it."""

    folder: Path
    poses: Path | None
    optics: survey_options.CameraOptions
    origin: str | None
    convention: str | None
    frames: str | None
    ground: float | None
    sensor: Any
    degrees: str | None
    dji_sdk: Path | None
    plane_z: float | None
    dem: Path | None
    dem_offset: float | None
    system: ProjectedSystem | None
    detection: Detection

    def inputs(self, results: Path) -> dict[str, object]:
        """Return what the result depends on, to be compared with an earlier examination's.

        Args:
            results: folder of the results: its pictures are none of the recording, also if it lies in its folder.
        """
        optics = self.optics
        inside = results.resolve()
        files = (self.poses, self.dem, optics.camera, optics.calibration)
        options = (
            *(optics.fov_deg, optics.lens, optics.fisheye, self.origin, self.convention, self.frames, self.ground),
            *(self.sensor, self.degrees, self.dji_sdk, self.plane_z, self.dem_offset, self.system and self.system.name),
            *(self.detection.detector, self.detection.min_score, self.detection.false_alarms_per_ha),
        )
        return {
            "source": printable(str(self.folder.resolve())),
            "images": _digest(
                sorted(
                    path
                    for path in self.folder.rglob("*")
                    if path.suffix.lower() in SUFFIXES and path.is_file() and inside not in path.resolve().parents
                )
            ),
            "files": _digest([path for path in files if path is not None and path.is_file()]),
            "options": [None if value is None else str(value) for value in options],
        }

    def examination(self) -> Examination:
        """Read the recording; what is worth knowing of it is printed on standard error."""
        from aos_gcs.cli.terrain_heights import with_terrain_checked  # noqa: PLC0415 - heavy, only for this command
        from aos_gcs.examination.prepare import prepared  # noqa: PLC0415
        from aos_gcs.surveys.projected import placed  # noqa: PLC0415

        if self.system is not None and self.dem is not None and self.origin is None and _is_mesh(self.dem):
            raise ConfigurationError("--crs and a mesh as --dem exclude each other: give the terrain as a GeoTIFF.")
        plane_z = 0.0 if self.poses is None and self.plane_z is None and self.dem is None else self.plane_z
        focus = surface_options.focus_options(
            plane_z=plane_z,
            autofocus=None,
            focus_region=None,
            focus_tilt=False,
            tilt=None,
            dem=self.dem,
            offset_m=self.dem_offset,
            stack=None,
        )
        opened = survey_options.open_survey(
            self.folder,
            poses=self.poses,
            optics=self.optics,
            origin=self.origin,
            convention=self.convention,
            frames=self.frames,
            ground_amsl_m=self.ground,
            sensor=self.sensor,
            degrees=self.degrees,
            dji_sdk=self.dji_sdk,
            skip_broken=True,
            on_terrain=self.dem is not None,
        )
        if self.system is not None and opened.origin is None:
            opened = placed(opened, self.system)
        if self.system is not None and opened.origin is not None:
            remark = self.system.remark(opened.origin)
            if remark is not None:
                typer.echo(remark, err=True)
        terrain = focus.terrain(opened)
        opened = with_terrain_checked(opened, terrain, self.dem, self.dem_offset)
        terrain_name = "" if self.dem is None else printable(self.dem.name)
        return prepared(opened, focus.surface(opened, terrain, None, skip_broken=True), self.detection, terrain_name)


def _system(name: str | None) -> ProjectedSystem | None:
    if name is None:
        return None
    from aos_gcs.surveys.projected import ProjectedSystem  # noqa: PLC0415 - needs an extra

    return ProjectedSystem.of(name)


def _is_mesh(path: Path) -> bool:
    from aos_gcs.imaging.surfaces.dem_files import is_geotiff  # noqa: PLC0415 - heavy, only for this command

    return not is_geotiff(path)


def _folder_name(folder: Path) -> str:
    """Return the name of the folder for the results of an image folder."""
    return re.sub(r"[^\w.-]+", "-", folder.resolve().name).strip("-.") + "-survey"


def _digest(paths: list[Path]) -> str:
    """Return a text that changes with the names, sizes and times of files."""
    digest = blake2b(digest_size=16)
    for path in paths:
        status = path.stat()
        digest.update(os.fsencode(path.resolve()) + f"|{status.st_size}|{status.st_mtime_ns}\n".encode())
    return digest.hexdigest()


def _as_data(snapshot: MissionSnapshot, folder: Path, system: ProjectedSystem | None) -> dict[str, object]:
    """Return the findings as data for JSON."""
    from aos_gcs.geometry.geodesy import LocalFrame  # noqa: PLC0415 - heavy, only for this command

    findings = []
    for finding in snapshot.findings:
        if snapshot.origin is None:
            break
        place = LocalFrame(snapshot.origin).to_geodetic(finding.position_enu_m)
        east_north_m = None if system is None else system.east_north_m(place.latitude_deg, place.longitude_deg)
        findings.append(
            {
                "finding_id": finding.finding_id,
                "status": finding.status.value,
                "kind": finding.kind.value,
                "person_confidence": finding.person_confidence,
                "latitude_deg": place.latitude_deg,
                "longitude_deg": place.longitude_deg,
                "sigma_m": finding.sigma_m,
                "significance": None if finding.significance is None else round(finding.significance, 2),
                "frames": finding.sightings,
                "found_at_s": round(finding.found_at_s, 2),
                "reasons": list(finding.reasons),
            }
            | ({} if east_north_m is None else {"east_m": east_north_m[0], "north_m": east_north_m[1]})
        )
    return {
        "folder": printable(str(folder)),
        "result": snapshot.outcome.value,
        "message": snapshot.message,
        "windows": snapshot.step,
        "first_finding_s": min((one["found_at_s"] for one in findings), default=None),  # type: ignore[type-var]
        "elapsed_s": round(snapshot.elapsed_s, 2),
        "findings": findings,
    }
