"""``aos-gcs integrate``: integral images of recorded flights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import typer
from numpy.typing import NDArray

from aos_gcs.cli import autofocus_options, result_options, surface_options, survey_options, work_options
from aos_gcs.cli.result_options import ResultOptions
from aos_gcs.cli.surface_options import check_raster_options, describe_map, focus_options, virtual_camera
from aos_gcs.cli.survey_options import CameraOptions, open_survey, report_skipped
from aos_gcs.cli.terrain_heights import with_terrain_checked
from aos_gcs.cli.work_options import DEFAULT_MAX_MEMORY_MB, WorkOptions
from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.georeference import Georeference, LocalGeoreference, ProjectedGeoreference
from aos_gcs.exports.rasters import MapPlace
from aos_gcs.exports.thumbnails import write_thumbnails
from aos_gcs.imaging.model import Detector, MapRaster
from aos_gcs.imaging.surfaces.dem_files import is_geotiff, read_dem_crs
from aos_gcs.imaging.surfaces.ground import choose_raster, covered_part
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.input_values import printable
from aos_gcs.surveys.anomalies import significant_blobs
from aos_gcs.surveys.integration import Work
from aos_gcs.surveys.levels import pixel_size_m
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.poses_file import Z_DOWN
from aos_gcs.surveys.rasters import SurveyRasters
from aos_gcs.surveys.seen_ground import share_without_height
from aos_gcs.surveys.significance import DEFAULT_FALSE_ALARMS_PER_HA, significance
from aos_gcs.surveys.tiles import RasterTile, ViewTile, map_tiles


def integrate(
    image_folder: survey_options.ImageFolder,
    *,
    out: result_options.Out,
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
    skip_broken: survey_options.SkipBroken = False,
    plane_z: autofocus_options.PlaneZ = None,
    tilt: surface_options.Tilt = None,
    autofocus: autofocus_options.AutofocusRange = None,
    focus_region: autofocus_options.FocusOn = None,
    focus_tilt: autofocus_options.FocusTilt = False,
    focus_stack: autofocus_options.FocusStack = None,
    dem: surface_options.Dem = None,
    dem_offset: surface_options.DemOffset = None,
    view: surface_options.View = None,
    size: surface_options.Size = None,
    ortho: surface_options.Ortho = None,
    exact: work_options.Exact = False,
    median: work_options.Median = False,
    trim: work_options.Trim = None,
    count: result_options.Count = None,
    png: result_options.Png = None,
    anomaly: result_options.Anomaly = None,
    blobs: result_options.Blobs = None,
    detector: result_options.DetectorName = Detector.LOCAL_RX,
    min_score: result_options.MinScore = None,
    false_alarms_per_ha: result_options.FalseAlarmsPerHa = DEFAULT_FALSE_ALARMS_PER_HA,
    thumbnails: result_options.Thumbnails = None,
    max_memory: work_options.MaxMemory = DEFAULT_MAX_MEMORY_MB,
    jobs: work_options.Jobs = None,
    scheduler: work_options.Scheduler = None,
) -> None:
    """See through foliage: average recorded images on a focal surface, as one virtual camera sees it, or as a map.

    Every image is projected to the surface, given in the poses' own world, whatever its axes are; what lies on the
    surface stays sharp, and what lies before it blurs away. The virtual camera has the field of view of the images.

    Without --poses, the images are photographs with positions in their metadata: x east, y north, z up from the ground.
    """
    check_raster_options(ortho, view, size)
    results = ResultOptions(
        out,
        count,
        png,
        tuple(anomaly or ()),
        blobs,
        detector,
        min_score,
        false_alarms_per_ha,
        thumbnails,
        ortho is not None,
    )
    options = WorkOptions(median, trim, max_memory, jobs, scheduler)
    options.check_map(ortho)
    if poses is None and plane_z is None and autofocus is None and dem is None:
        plane_z = 0.0
    focus = focus_options(
        plane_z=plane_z,
        autofocus=autofocus,
        focus_region=focus_region,
        focus_tilt=focus_tilt,
        tilt=tilt,
        dem=dem,
        offset_m=dem_offset,
        stack=focus_stack,
    )
    with options.begun(on_terrain=dem is not None) as options:
        survey = open_survey(
            image_folder,
            poses=poses,
            optics=CameraOptions(fov, camera, lens, fisheye, calibration),
            origin=origin,
            convention=convention,
            frames=frames,
            ground_amsl_m=ground,
            sensor=sensor,
            degrees=degrees,
            dji_sdk=dji_sdk,
            skip_broken=skip_broken,
            on_terrain=dem is not None,
        )
        inputs = (path for path in (poses, dem, camera, calibration) if path is not None)
        results.check_inputs((*(image.path for image in survey.images), *inputs))
        georeference = _georeference(survey, dem)
        results.check_georeference(georeference)
        virtual = virtual_camera(survey, view, size) if ortho is None else None
        terrain = focus.terrain(survey)
        survey = with_terrain_checked(survey, terrain, dem, dem_offset)
        surface = focus.surface(survey, terrain, virtual, skip_broken=skip_broken)
        work = Work(
            images=survey.images,
            bands=survey.bands,
            surface=surface,
            exact=exact,
            trim=options.share_left_out,
            detector=results.wanted_detector,
            min_score=min_score,
            skip_broken=skip_broken,
            max_bytes=max_memory * 1_000_000,
        )
        if virtual is not None:
            view_of_all = ViewTile(tuple(range(len(survey.images))), *virtual)
            shape = virtual[0].height_px, virtual[0].width_px
            rasters = _integrate(options, work, [view_of_all], shape, out)
            results.write(rasters, survey.bands, None, _significances(rasters, pixel_size_m(*virtual, surface)))
        else:
            _integrate_map(options, work, ortho or math.nan, georeference, results)
        _report_ground_without_height(survey, surface, dem)


def _report_ground_without_height(survey: Survey, surface: FocalSurface, dem: Path | None) -> None:
    """Print how much of what the images show is in no result, as its height is not known, on standard error."""
    if dem is None or not isinstance(surface, Terrain):
        return
    percent = 100.0 * share_without_height(survey.images, surface)
    if percent >= 0.5:
        typer.echo(printable(f"{percent:.0f} % of the photographed ground has no height in {dem.name}"), err=True)


def _integrate_map(
    options: WorkOptions,
    work: Work,
    resolution_m: float,
    georeference: Georeference | None,
    results: ResultOptions,
) -> None:
    raster = choose_raster([(image.camera, image.pose) for image in work.images], work.surface, resolution_m)
    results.check_map(raster)
    crs = _crs(georeference, raster, work.surface)
    tiles = map_tiles(raster, work.images, work.surface)
    rasters = _integrate(options, work, tiles, (raster.rows, raster.columns), results.out)
    raster, rasters = _covered(raster, rasters)
    typer.echo(describe_map(raster), err=True)
    place = MapPlace(raster, crs)
    significances = _significances(rasters, raster.resolution_m)
    results.write(rasters, work.bands, place, significances)
    if rasters.anomalies is None or significances is None:
        return
    rate = results.false_alarms_per_ha
    blobs = significant_blobs(
        rasters.anomalies, significances, rasters.coverage, raster, work.surface, false_alarms_per_ha=rate
    )
    typer.echo(f"anomalies: {len(blobs)}, where chance makes {rate:g} per hectare", err=True)
    pictures: list[Path] = []
    if results.thumbnails is not None:
        pictures = write_thumbnails(
            results.thumbnails,
            blobs,
            integral=rasters.integral,
            bands=work.bands,
            significances=significances,
            raster=raster,
        )
    results.write_blobs(blobs, georeference, pictures)


def _significances(rasters: SurveyRasters, cell_m: float) -> NDArray[np.float32] | None:
    """Return the significance of every cell; None without a detector."""
    return None if rasters.anomalies is None else significance(rasters.anomalies, rasters.coverage, cell_m)


def _integrate(
    options: WorkOptions, work: Work, tiles: Sequence[RasterTile], shape: tuple[int, int], out: Path
) -> SurveyRasters:
    """Integrate tiles; the number of images without a part in them is printed on standard error."""
    rasters = options.integrate(work, tiles, shape, out.absolute().parent)
    report_skipped(len(work.images), [(work.images[index].path.name, text) for index, text in rasters.broken.items()])
    unused = [index for index in range(len(work.images)) if index not in rasters.used | rasters.broken.keys()]
    if not rasters.used:
        raise ConfigurationError(
            "No image sees any of the focal surface in this view: check its height, and that the surface is given in "
            "the world of the poses."
        )
    if unused:
        first = work.images[unused[0]].path.name
        text = f"{len(unused)} of {len(work.images)} images do not see the focal surface; the first is {first}"
        typer.echo(printable(text), err=True)
    return rasters


def _covered(raster: MapRaster, rasters: SurveyRasters) -> tuple[MapRaster, SurveyRasters]:
    """Return the smallest map with all covered cells."""
    raster, window = covered_part(raster, rasters.coverage)
    anomalies = rasters.anomalies
    return raster, replace(
        rasters,
        integral=rasters.integral[window],
        coverage=rasters.coverage[window],
        anomalies=None if anomalies is None else anomalies.part(window),
    )


def _georeference(survey: Survey, dem: Path | None) -> Georeference | None:
    """Return where the world of a survey lies: about its origin, or in the coordinates of its terrain."""
    if survey.origin is not None:
        return LocalGeoreference(survey.origin)
    wkt = read_dem_crs(dem) if dem is not None and is_geotiff(dem) else None
    return None if wkt is None else ProjectedGeoreference(wkt)


def _crs(georeference: Georeference | None, raster: MapRaster, surface: FocalSurface) -> str | None:
    """Return the coordinate system of a map.

    Raises:
        ConfigurationError: if the world's z points down, so that it cannot be east-north-up.
    """
    if georeference is None:
        return None
    if raster.rows_along_y:
        raise ConfigurationError(Z_DOWN)
    x_m, y_m = raster.to_plane[:2] @ ((raster.columns - 1) / 2, (raster.rows - 1) / 2, 1.0)
    height_m = float(surface.z_m(x_m, y_m))
    if math.isnan(height_m) and isinstance(surface, Terrain):
        height_m = float(np.nanmedian(surface.heights_m))
    return georeference.crs(height_m)
