"""A small rendered video of a flight, with the subtitles that DJI's enterprise aircraft write."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import intersect_plane

ORIGIN = GeodeticPosition(47.5, 14.25, 600.0)
RATE_HZ, SPEED_MPS, HEIGHT_M, FOV_DEG = 10, 2.0, 20.0, 50.0
WIDTH, HEIGHT = 96, 64
SUBTITLE_HEADER = b"""[Script Info]
ScriptType: v4.00+

[V4+ Styles]
Format: Name, Fontname, Fontsize
Style: Default,Arial,16

[Events]
Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text
\0"""
"""Header without which FFmpeg opens no subtitle track for writing."""
POSITIONS_HZ = 5
"""Rate of positions; cues come with every frame and repeat them."""


def grey_at(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(120.0 + 60.0 * np.sin(0.9 * points_m[:, 0]) * np.cos(0.7 * points_m[:, 1]))


def true_pose(time_s: float) -> Pose:
    """Pose of a camera that flies north-east, looks down, and turns."""
    along_m = SPEED_MPS * time_s / math.sqrt(2.0)
    return nadir_pose([along_m, along_m, HEIGHT_M], math.radians(yaw_deg(time_s)))


def yaw_deg(time_s: float) -> float:
    """Heading that passes from 180° to -180°."""
    return (170.0 + 4.0 * time_s + 180.0) % 360.0 - 180.0


def cue(number: int, start_s: float, values: str) -> str:
    """One cue of a subtitle file, as long as a frame."""
    return f"{number}\n{_clock(start_s)} --> {_clock(start_s + 1.0 / RATE_HZ)}\n{values}\n\n"


def telemetry(time_s: float, *, gimbal: bool = True, zoom: float = 1.0) -> str:
    """Values of a cue; positions come less often, to a millionth of a degree."""
    at_s = math.floor(time_s * POSITIONS_HZ + 1e-9) / POSITIONS_HZ
    place = LocalFrame(ORIGIN).to_geodetic(true_pose(at_s).position_enu_m)
    height_m = place.altitude_amsl_m - ORIGIN.altitude_amsl_m
    angles = f" [gb_yaw: {yaw_deg(time_s):.1f} gb_pitch: -90.0 gb_roll: 0.0]" if gimbal else ""
    return (
        f'<font size="28">FrameCnt: 7, DiffTime: 100ms\n2026-05-01 10:00:00.123\n[iso: 100] [shutter: 1/8000.0] '
        f"[focal_len: 40.00] [dzoom_ratio: {zoom:.2f}], [latitude: {place.latitude_deg:.6f}] "
        f"[longitude: {place.longitude_deg:.6f}] [rel_alt: {height_m:.3f} abs_alt: {place.altitude_amsl_m:.3f}]"
        f"{angles} </font>"
    )


def write_video(path: Path, av: Any, seconds: float, *, colour: bool = False, subtitles: bool = False) -> None:
    """Write what the camera sees; with subtitles as a track of their own, if wanted."""
    camera = CameraModel.from_fov(WIDTH, HEIGHT, math.radians(FOV_DEG))
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    pixels = np.stack((u.ravel(), v.ravel()), axis=1).astype(np.float64)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=RATE_HZ, options={"crf": "1"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        track = container.add_stream("mov_text") if subtitles else None
        if track is not None:
            track.codec_context.subtitle_header = SUBTITLE_HEADER
        for index in range(round(seconds * RATE_HZ)):
            grey = grey_at(intersect_plane(pixels, camera, true_pose(index / RATE_HZ), 0.0)).reshape(HEIGHT, WIDTH)
            image = np.repeat(np.round(grey).astype(np.uint8)[..., np.newaxis], 3, axis=2)
            if colour:
                image[..., 2] //= 2
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
            if track is not None:
                text = telemetry(index / RATE_HZ).encode()
                packet = av.Packet(len(text).to_bytes(2, "big") + text)
                packet.stream, packet.time_base = track, Fraction(1, RATE_HZ)
                packet.pts = packet.dts = index
                packet.duration = 1
                container.mux(packet)
        container.mux(stream.encode(None))


def write_subtitles(path: Path, seconds: float, **options: Any) -> None:
    count = round(seconds * RATE_HZ)
    path.write_text(
        "".join(cue(index + 1, index / RATE_HZ, telemetry(index / RATE_HZ, **options)) for index in range(count))
    )


def _clock(time_s: float) -> str:
    thousandths = round(time_s * 1000.0)
    minutes, milliseconds = divmod(thousandths, 60_000)
    return f"00:{minutes:02d}:{milliseconds // 1000:02d},{milliseconds % 1000:03d}"
