"""``aos-gcs lab recordings``: detection and decision on recorded flights whose persons are known."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import ConfigurationError


def recordings(
    *,
    folders: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR",
            help="Folders with images/, poses.json, persons.json and, unless given, a terrain.",
        ),
    ],
    fov: Annotated[
        float | None,
        typer.Option(metavar="DEG", help="Full horizontal field of view, unless the poses file describes the camera."),
    ] = None,
    dem: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Terrain: .obj, .obj.gz or GeoTIFF (default: in the folder)."),
    ] = None,
    dem_offset: Annotated[float, typer.Option(metavar="DZ", help="Shift of the terrain along z, metres.")] = 0.0,
    plane_z: Annotated[
        float | None,
        typer.Option(metavar="Z", help="Height of a plane instead of a terrain, world of the poses."),
    ] = None,
    window: Annotated[int, typer.Option(help="Frames of a window.")] = 30,
    stride: Annotated[int, typer.Option(help="Frames from the start of a window to that of the next one.")] = 30,
    first: Annotated[int, typer.Option(help="Index of the first frame, such as that after the climb.")] = 0,
    detectors: Annotated[
        str, typer.Option(help="Detectors separated by commas: rx, local_rx, thermal.")
    ] = "rx,local_rx,thermal",
    false_alarms_per_ha: Annotated[
        float, typer.Option(metavar="RATE", help="Anomalies that chance may make per hectare.")
    ] = 0.25,
    resolution: Annotated[float, typer.Option(metavar="M", help="Edge of a cell of the map.")] = 0.1,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as one JSON object.")] = False,
    document: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Markdown file to write or renew, such as docs/recordings.md.")
    ] = None,
) -> None:
    """Judge recorded thermal flights as missions judge their frames, and report recall, false alarms and errors.

    Windows of frames move over each flight; every frame counts as one of a vehicle of its own. persons.json holds the
    places of all persons in the world of the poses. See docs/recordings.md.
    """
    from aos_gcs.cli.output import progress  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.imaging.model import Detector  # noqa: PLC0415
    from aos_gcs.lab.recordings.recording import FocalSurfaceOptions, open_recording  # noqa: PLC0415
    from aos_gcs.lab.recordings.report import as_data, as_markdown, recordings_frame, write_document  # noqa: PLC0415
    from aos_gcs.lab.recordings.study import WindowSettings, study_recording  # noqa: PLC0415

    settings = WindowSettings(window, stride, first, false_alarms_per_ha, resolution)
    chosen = [name.strip() for name in detectors.split(",")]
    unknown = [name for name in chosen if name not in list(Detector)]
    if unknown:
        raise ConfigurationError(f"--detectors must be among {', '.join(Detector)}, got {unknown[0]!r}.")
    if plane_z is not None and (dem is not None or dem_offset != 0.0):
        raise ConfigurationError("--plane-z excludes --dem and --dem-offset: focus on a plane or on a terrain.")
    if not all(math.isfinite(value) for value in (dem_offset, plane_z or 0.0)):
        raise ConfigurationError(f"--dem-offset and --plane-z must be finite, got {dem_offset} and {plane_z}.")
    if fov is not None and not 1.0 <= fov <= 170.0:
        raise ConfigurationError(f"--fov must lie within 1 and 170 degrees, got {fov:g}.")
    ground = FocalSurfaceOptions(dem, dem_offset, plane_z)
    fov_rad = None if fov is None else math.radians(fov)
    # A document that cannot be renewed is refused before the work.
    frame = None if document is None else recordings_frame(document)
    opened = [open_recording(folder, fov_rad, ground) for folder in folders]
    results = []
    with progress("Windows", len(chosen) * sum(len(settings.starts(one)) for one in opened)) as advance:
        for recording in opened:
            results += study_recording(recording, [Detector(name) for name in chosen], settings, advance)
    if document is not None and frame is not None:
        write_document(document, frame, settings, results)
    typer.echo(json.dumps(as_data(results)) if as_json else as_markdown(results), nl=as_json)
