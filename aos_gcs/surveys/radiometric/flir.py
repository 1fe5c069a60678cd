"""Temperatures of FLIR's radiometric JPEG files.

The file carries, beside its picture, what the sensor counted, and the camera's constants for the law of Planck. What
reaches the sensor comes from the object, from what it reflects, from the air, and from a window before the lens:
``signal = t_w (t (e S(object) + (1 - e) S(reflected)) + (1 - t) S(air)) + (1 - t_w) S(window)``, with the signal of a
black body ``S(T) = R1 / (R2 (exp(B / T) - F)) - O``.

Sources: FLIR, *User's manual ThermaCAM*, chapter "Thermographic measurement techniques" (the sum of signals) and
*Toolkit IC2 Dig16 Developers Guide* (constants, transmission of the air); the layout of the FFF container as documented
with ExifTool.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.image_headers import PNG_START
from aos_gcs.surveys.radiometric.settings import MeasurementConditions

_ZERO_CELSIUS_K = 273.15
_SEGMENT_START = b"FLIR\0\x01"
_RAW_DATA, _CAMERA_INFO = 0x01, 0x20
_MAX_RECORDS = 200
_MAX_EDGE_PX = 4096
_MIN_SCENE_K, _MAX_SCENE_K = 50.0, 3000.0
"""Temperatures that what is reflected, the air or a window may have: clear skies look 200 K cold, fires 1500 K warm."""

_CAMERA_FIELDS = {
    "emissivity": (0x20, "f"),
    "distance_m": (0x24, "f"),
    "reflected_k": (0x28, "f"),
    "air_k": (0x2C, "f"),
    "window_k": (0x30, "f"),
    "window_transmission": (0x34, "f"),
    "humidity": (0x3C, "f"),
    "R1": (0x58, "f"),
    "B": (0x5C, "f"),
    "F": (0x60, "f"),
    "alpha1": (0x70, "f"),
    "alpha2": (0x74, "f"),
    "beta1": (0x78, "f"),
    "beta2": (0x7C, "f"),
    "X": (0x80, "f"),
    "fov_deg": (0x1B4, "f"),
    "O": (0x308, "i"),
    "R2": (0x30C, "f"),
}
"""Places of fields in the record of the camera, with struct's codes."""


@dataclass(frozen=True, slots=True, eq=False)
class FlirImage:
    """Counts of the sensor with the camera's constants."""

    counts: NDArray[np.uint16]
    """Shape (H, W)."""
    fields: dict[str, float]
    """Constants by the names of the record's fields; temperatures in kelvin."""

    @property
    def horizontal_fov_rad(self) -> float | None:
        """Full horizontal field of view; None where the camera does not tell it."""
        fov_deg = self.fields["fov_deg"]
        return math.radians(fov_deg) if 0.0 < fov_deg < 180.0 else None

    def celsius(self, conditions: MeasurementConditions) -> NDArray[np.float32]:
        """Return the temperatures of objects, degrees Celsius, shape (H, W).

        Raises:
            InputDataError: with the reason alone, if the constants or the conditions give none.
        """
        field = self.fields
        emissivity = field["emissivity"] if conditions.emissivity is None else conditions.emissivity
        distance_m = field["distance_m"] if conditions.distance_m is None else conditions.distance_m
        humidity = _as_share(field["humidity"]) if conditions.humidity is None else conditions.humidity
        reflected_k = (
            field["reflected_k"] if conditions.reflected_c is None else conditions.reflected_c + _ZERO_CELSIUS_K
        )
        air_k = field["air_k"] if conditions.air_c is None else conditions.air_c + _ZERO_CELSIUS_K
        window = field["window_transmission"] if 0.0 < field["window_transmission"] <= 1.0 else 1.0
        if not 0.0 < emissivity <= 1.0:
            raise InputDataError(
                f"its emissivity is {emissivity:g}, which is not between 0 and 1; give --degrees emissivity=0.97"
            )
        reflected = self._signal("reflected temperature", reflected_k, "; give --degrees reflected=5")
        of_air = self._signal("temperature of the air", air_k, "; give --degrees air=12")
        air = self._transmission(distance_m, humidity, air_k - _ZERO_CELSIUS_K)
        other = window * (air * (1.0 - emissivity) * reflected + (1.0 - air) * of_air)
        if window < 1.0:
            other += (1.0 - window) * self._signal("temperature of the window before its lens", field["window_k"])
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            signal = (self.counts.astype(np.float64) - other) / (emissivity * air * window)
            inverse = np.log(field["R1"] / (field["R2"] * (signal + field["O"])) + field["F"])
            celsius = (field["B"] / inverse - _ZERO_CELSIUS_K).astype(np.float32)
        if not np.isfinite(celsius).all():
            raise InputDataError("its constants and its counts give no temperatures; check emissivity and distance")
        return celsius

    def _signal(self, name: str, kelvin: float, remedy: str = "") -> float:
        """Return the counts of a black body of a temperature, which an error calls by its name."""
        field = self.fields
        if not _MIN_SCENE_K <= kelvin <= _MAX_SCENE_K:
            raise InputDataError(f"its {name} is {kelvin:g} K, which no scene has{remedy}")
        divisor = field["R2"] * (_exp(field["B"] / kelvin) - field["F"])
        if not divisor > 0.0:
            raise InputDataError(
                f"its Planck constants are not usable: B = {field['B']:g} and F = {field['F']:g} give no signal at its "
                f"{name}, {kelvin:g} K"
            )
        return field["R1"] / divisor - field["O"]

    def _transmission(self, distance_m: float, humidity: float, air_c: float) -> float:
        """Return the share that air lets through."""
        field = self.fields
        water = humidity * _exp(1.5587 + 6.939e-2 * air_c - 2.7816e-4 * air_c**2 + 6.8455e-7 * air_c**3)
        root_m = math.sqrt(max(distance_m, 0.0))
        first, second = (
            _exp(-root_m * (field[f"alpha{k}"] + field[f"beta{k}"] * math.sqrt(max(water, 0.0)))) for k in (1, 2)
        )
        share = field["X"] * first + (1.0 - field["X"]) * second
        if not 0.0 < share <= 1.5:
            raise InputDataError(f"its constants give the air a transmission of {share:g}")
        return min(share, 1.0)


def _exp(exponent: float) -> float:
    """Return the exponential; infinite where it is too large for a number, as with constants of a damaged file."""
    try:
        return math.exp(exponent)
    except OverflowError:
        return math.inf


def _as_share(humidity: float) -> float:
    """Return a relative humidity as a share; some cameras write percent."""
    return humidity / 100.0 if humidity > 2.0 else humidity


def read_flir(content: bytes) -> FlirImage | None:
    """Read a radiometric JPEG file; None if it has no data of FLIR.

    Raises:
        InputDataError: if they are damaged; with the reason alone, so that it can stand behind the file's name.
    """
    container = _container(content)
    if container is None:
        return None
    try:
        records = _records(container)
        camera, raw = records.get(_CAMERA_INFO), records.get(_RAW_DATA)
        if camera is None or raw is None:
            raise InputDataError("its FLIR data have no counts or no constants of the camera")
        order = _order(camera, 0x0002)
        fields = {name: struct.unpack_from(order + code, camera, at)[0] for name, (at, code) in _CAMERA_FIELDS.items()}
        counts = _counts(raw)
    except struct.error as error:
        raise InputDataError("its FLIR data are incomplete") from error
    if not all(map(math.isfinite, fields.values())) or min(fields["R1"], fields["R2"], fields["B"]) <= 0.0:
        raise InputDataError("its Planck constants are not usable")
    return FlirImage(counts, {name: float(value) for name, value in fields.items()})


def _container(content: bytes) -> bytes | None:
    """Return the FFF container, put together from the segments of a JPEG file; None if there is none."""
    parts: dict[int, bytes] = {}
    at = 2
    while at + 4 <= len(content) and content[at] == 0xFF:
        marker, (length,) = content[at + 1], struct.unpack_from(">H", content, at + 2)
        if marker == 0xDA or length < 2:
            break
        body = content[at + 4 : at + 2 + length]
        if marker == 0xE1 and body.startswith(_SEGMENT_START) and len(body) > 8:
            parts.setdefault(body[6], body[8:])
        at += 2 + length
    if sorted(parts) != list(range(len(parts))):
        raise InputDataError("parts of its FLIR data are missing")
    container = b"".join(parts[number] for number in sorted(parts))
    return container if container.startswith((b"FFF\0", b"AFF\0")) else None


def _records(container: bytes) -> dict[int, bytes]:
    """Return the first record of each type."""
    order = next((order for order in "><" if 100 <= struct.unpack_from(f"{order}I", container, 0x14)[0] < 200), None)
    if order is None:
        raise InputDataError("its FLIR data are of an unknown version")
    directory, count = struct.unpack_from(f"{order}II", container, 0x18)
    records: dict[int, bytes] = {}
    for index in range(min(count, _MAX_RECORDS)):
        entry = directory + 0x20 * index
        (kind,) = struct.unpack_from(f"{order}H", container, entry)
        start, length = struct.unpack_from(f"{order}II", container, entry + 0x0C)
        if start + length <= len(container) and length > 0:
            records.setdefault(kind, container[start : start + length])
    return records


def _order(record: bytes, first: int) -> str:
    """Return struct's code of a record's byte order, which its first number tells."""
    return "<" if struct.unpack_from("<H", record)[0] == first else ">"


def _counts(raw: bytes) -> NDArray[np.uint16]:
    order = _order(raw, 0x0002)
    width, height = struct.unpack_from(f"{order}2H", raw, 2)
    if not (0 < width <= _MAX_EDGE_PX and 0 < height <= _MAX_EDGE_PX):
        raise InputDataError(f"its counts claim {width} x {height} pixels")
    payload = raw[0x20:]
    if not payload.startswith(PNG_START):
        if len(payload) < 2 * width * height:
            raise InputDataError("its counts are incomplete")
        return np.frombuffer(payload, f"{order}u2", width * height).reshape(height, width).astype(np.uint16)
    if struct.unpack_from(">2I", payload, 16) != (width, height):
        raise InputDataError("its counts have another size than they claim")
    image = cv2.imdecode(np.frombuffer(payload, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or image.dtype != np.uint16 or image.shape != (height, width):
        raise InputDataError("its counts cannot be decoded")
    # Most cameras write the bytes of these PNG files in the wrong order, which makes them noise.
    candidates = [np.asarray(order, dtype=np.uint16) for order in (image, image.byteswap())]
    return min(candidates, key=lambda counts: float(np.abs(np.diff(counts.astype(np.int32), axis=1)).sum()))
