"""Radiometric JPEG files as FLIR's cameras write them."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

ZERO_CELSIUS_K = 273.15

CAMERA: dict[str, float] = {
    "emissivity": 0.95,
    "distance_m": 30.0,
    "reflected_k": 278.15,
    "air_k": 285.15,
    "window_k": 293.15,
    "window_transmission": 1.0,
    "humidity": 0.6,
    "R1": 17096.453,
    "B": 1428.0,
    "F": 1.0,
    "alpha1": 0.006569,
    "alpha2": 0.01262,
    "beta1": -0.002276,
    "beta2": -0.00667,
    "X": 1.9,
    "fov_deg": 45.0,
    "O": -342,
    "R2": 0.046952728,
}
"""Constants of a camera, and what it was set to."""

PLACES = {
    "emissivity": 0x20, "distance_m": 0x24, "reflected_k": 0x28, "air_k": 0x2C, "window_k": 0x30,
    "window_transmission": 0x34, "humidity": 0x3C, "R1": 0x58, "B": 0x5C, "F": 0x60, "alpha1": 0x70, "alpha2": 0x74,
    "beta1": 0x78, "beta2": 0x7C, "X": 0x80, "fov_deg": 0x1B4, "O": 0x308, "R2": 0x30C,
}  # fmt: skip


def signal(kelvin: NDArray[np.float64] | float, camera: dict[str, float]) -> NDArray[np.float64]:
    """Return the counts that a black body gives."""
    return np.asarray(camera["R1"] / (camera["R2"] * (np.exp(camera["B"] / kelvin) - camera["F"])) - camera["O"])


def counts_of(celsius: NDArray[np.float64], camera: dict[str, float]) -> NDArray[np.float64]:
    """Return what the sensor counts of objects of these temperatures."""
    air_c = camera["air_k"] - ZERO_CELSIUS_K
    saturation = math.exp(1.5587 + 0.06939 * air_c - 0.00027816 * air_c**2 + 0.00000068455 * air_c**3)
    root_water, root_m = math.sqrt(camera["humidity"] * saturation), math.sqrt(camera["distance_m"])
    air = camera["X"] * math.exp(-root_m * (camera["alpha1"] + camera["beta1"] * root_water))
    air += (1 - camera["X"]) * math.exp(-root_m * (camera["alpha2"] + camera["beta2"] * root_water))
    leaving = camera["emissivity"] * signal(celsius + ZERO_CELSIUS_K, camera)
    leaving = leaving + (1 - camera["emissivity"]) * signal(camera["reflected_k"], camera)
    arriving = air * leaving + (1 - air) * signal(camera["air_k"], camera)
    window = camera["window_transmission"]
    return np.asarray(window * arriving + (1 - window) * signal(camera["window_k"], camera))


def container(
    counts: NDArray[np.uint16],
    camera: dict[str, float],
    *,
    order: str = "<",
    as_png: bool = False,
    swapped: bool = True,
) -> bytes:
    """Return an FFF container; its directory is big-endian, its records are in an order."""
    height, width = counts.shape
    payload = counts.astype(f"{order}u2").tobytes()
    if as_png:
        payload = cv2.imencode(".png", counts.byteswap() if swapped else counts)[1].tobytes()
    raw = struct.pack(f"{order}3H", 2, width, height).ljust(0x20, b"\0") + payload
    info = bytearray(0x400)
    struct.pack_into(f"{order}3H", info, 0, 2, width, height)
    for name, at in PLACES.items():
        struct.pack_into(f"{order}{'i' if name == 'O' else 'f'}", info, at, camera[name])
    start = 0x40 + 2 * 0x20
    header = struct.pack(">4s16s3I", b"FFF\0", b"CAMCTRL", 101, 0x40, 2).ljust(0x40, b"\0")
    entries = struct.pack(">2H4I", 1, 2, 100, 1, start, len(raw)).ljust(0x20, b"\0")
    entries += struct.pack(">2H4I", 0x20, 1, 100, 2, start + len(raw), len(info)).ljust(0x20, b"\0")
    return header + entries + raw + bytes(info)


def insert(path: Path, data: bytes) -> None:
    """Put a container into a JPEG file, in segments behind its start."""
    content = path.read_bytes()
    parts = [data[at : at + 60_000] for at in range(0, len(data), 60_000)]
    segments = b""
    for number, part in enumerate(parts):
        body = b"FLIR\0\x01" + bytes((number, len(parts) - 1)) + part
        segments += b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body
    path.write_bytes(content[:2] + segments + content[2:])


def make_radiometric(path: Path, celsius: NDArray[np.float64], **changes: Any) -> None:
    """Give a photograph temperatures; ``changes`` are of the camera."""
    camera = CAMERA | changes
    insert(path, container(np.round(counts_of(celsius, camera)).astype(np.uint16), camera))
