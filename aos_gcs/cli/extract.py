"""``aos-gcs extract``: frames and poses of a recorded video."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cli.output import progress
from aos_gcs.errors import ConfigurationError
from aos_gcs.input_values import finite_numbers
from aos_gcs.surveys.video.subtitles import Attitude

PANEL = "Frames"


def extract(
    video: Annotated[Path, typer.Argument(help="Recorded video (MP4, MOV or MKV).", show_default=False)],
    *,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="New folder for the images and their poses.json.")],
    subtitles: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.SRT",
            help="Telemetry of the video. Without it, the file of its name beside it, or its own subtitle track.",
        ),
    ] = None,
    spacing: Annotated[
        float | None,
        typer.Option(
            metavar="M", help="Distance between two frames, metres.", show_default="1.0", rich_help_panel=PANEL
        ),
    ] = None,
    every: Annotated[
        float | None,
        typer.Option(metavar="S", help="Time between two frames, instead of their distance.", rich_help_panel=PANEL),
    ] = None,
    start: Annotated[
        float, typer.Option("--from", metavar="S", help="Start time in the video, seconds.", rich_help_panel=PANEL)
    ] = 0.0,
    end: Annotated[
        float | None,
        typer.Option("--to", metavar="S", help="End time in the video, seconds.", rich_help_panel=PANEL),
    ] = None,
    ground: Annotated[
        float | None,
        typer.Option(
            metavar="ALT",
            help="Altitude of the ground in the altitude reference of the video: z = 0. Without it, z = 0 is the place "
            "of takeoff.",
        ),
    ] = None,
    attitude: Annotated[
        str | None,
        typer.Option(
            metavar="YAW,PITCH[,ROLL]",
            help="Attitude of the camera, degrees, for videos without it, or in place of theirs. YAW may be 'course', "
            "the direction of flight; PITCH -90 is down.",
        ),
    ] = None,
) -> None:
    """Extract frames of a video with positions in its subtitles, for integrate, survey and calibrate.

    Poses are interpolated between the samples of the telemetry. The world is x east, y north, z up from the ground.
    """
    from aos_gcs.surveys.video.extraction import Selection, read_telemetry  # noqa: PLC0415 - keeps the help fast
    from aos_gcs.surveys.video.extraction import extract as write_frames  # noqa: PLC0415
    from aos_gcs.surveys.video.subtitles import MAX_ALTITUDE_M  # noqa: PLC0415
    from aos_gcs.surveys.video.track import FlightTrack  # noqa: PLC0415

    if spacing is not None and every is not None:
        raise ConfigurationError("--spacing and --every exclude each other: frames have one or the other.")
    for name, value in (("--spacing", spacing), ("--every", every)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise ConfigurationError(f"{name} must be a positive number, got {value:g}.")
    if not 0.0 <= start < (math.inf if end is None else end):
        raise ConfigurationError(f"--from and --to must name a part of the video, got {start:g} to {end}.")
    if ground is not None and not abs(ground) <= MAX_ALTITUDE_M:
        raise ConfigurationError(
            f"--ground must be an altitude between {-MAX_ALTITUDE_M:g} and {MAX_ALTITUDE_M:g} m, got {ground:g}."
        )
    track = FlightTrack(
        read_telemetry(video, subtitles),
        ground_amsl_m=ground,
        attitude=None if attitude is None else _attitude(attitude),
    )
    selection = Selection(1.0 if spacing is None else spacing, every, start, math.inf if end is None else end)
    last_s = min(track.end_s, selection.to_s)
    done = 0
    with progress("Extracting frames, seconds of video", max(1, math.ceil(last_s - start))) as advance:

        def at(time_s: float) -> None:
            nonlocal done
            passed = min(math.floor(time_s - start), math.ceil(last_s - start))
            advance(max(0, passed - done))
            done = max(done, passed)

        result = write_frames(video, track, out, selection, at)
    if track.jumps:
        typer.echo(f"{track.jumps} positions of the telemetry are left out: no aircraft gets there in time", err=True)
    for count, reason in (
        (result.without_telemetry, "have no telemetry near their time"),
        (result.other_zoom, "were taken with another digital zoom than the first"),
    ):
        if count:
            typer.echo(f"{count} frames {reason} and are left out", err=True)
    if result.is_cut_off:
        typer.echo("The video ends in the middle of a frame: it was cut off. What was read before is kept.", err=True)
    origin = track.origin
    typer.echo(
        f"{len(result.names)} frames with poses in {out}; z = 0 at {origin.altitude_amsl_m:.1f} m, origin "
        f"{origin.latitude_deg:.7f}, {origin.longitude_deg:.7f}"
    )


def _attitude(text: str) -> Attitude:
    """Return the attitude that replaces the gimbal's."""
    yaw, _, angles = text.partition(",")
    numbers = finite_numbers(angles)
    yaw_deg = [math.nan] if yaw.strip() == "course" else finite_numbers(yaw)
    is_turn = all(abs(angle) <= 360.0 for angle in numbers) and not any(abs(angle) > 360.0 for angle in yaw_deg)
    if len(numbers) not in (1, 2) or len(yaw_deg) != 1 or not is_turn:
        raise ConfigurationError(
            f"--attitude needs YAW,PITCH[,ROLL] in degrees, YAW a number or 'course', got {text!r}."
        )
    return Attitude(None if math.isnan(yaw_deg[0]) else yaw_deg[0], *numbers)
