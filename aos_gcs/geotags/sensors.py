"""Cameras of an aircraft that carries several, which write all their pictures into one folder."""

from __future__ import annotations

import re
from collections.abc import Mapping
from enum import StrEnum
from pathlib import PurePath


class Sensor(StrEnum):
    """Camera of an aircraft that carries several."""

    THERMAL = "thermal"
    WIDE = "wide"
    ZOOM = "zoom"


_SOURCES = {
    "infraredcamera": Sensor.THERMAL,
    "widecamera": Sensor.WIDE,
    "visible": Sensor.WIDE,
    "visiblecamera": Sensor.WIDE,
    "zoomcamera": Sensor.ZOOM,
    "infrared": Sensor.THERMAL,
    "main_visible": Sensor.WIDE,
    "boson 640": Sensor.THERMAL,
    "hadron 640r eo": Sensor.WIDE,
}
"""Sensors by DJI's ``ImageSource``, Skydio's ``CameraSource`` and the ``Model`` of Teal's, in lower case."""
_TAGS = ("ImageSource", "CameraSource", "Model")
_LETTERS = {"T": Sensor.THERMAL, "W": Sensor.WIDE, "V": Sensor.WIDE, "Z": Sensor.ZOOM}
"""Sensors by the letter at the end of the names of DJI's files."""
_DJI_NAME = re.compile(r"DJI_.*_(?P<letter>[TWVZ])", re.IGNORECASE)


def sensor_of(xmp: Mapping[str, str], name: str) -> Sensor | None:
    """Return the sensor of a photograph by its XMP, or else by its name; None where neither tells it."""
    source = next((_SOURCES[said] for tag in _TAGS if (said := xmp.get(tag, "").lower()) in _SOURCES), None)
    match = _DJI_NAME.fullmatch(PurePath(name).stem)
    return source or (_LETTERS[match["letter"].upper()] if match else None)
