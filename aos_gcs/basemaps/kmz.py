"""Ground overlays in KMZ files as sources of tiles.

Source: OGC KML 2.3, sections 11.2 (GroundOverlay) and 11.3 (LatLonBox).
"""

from __future__ import annotations

import math
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element, ParseError

import cv2
import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring
from numpy.typing import NDArray

from aos_gcs.basemaps.mercator import WorldBox, from_degrees
from aos_gcs.basemaps.picture import PictureSource
from aos_gcs.errors import InputDataError
from aos_gcs.image_headers import picture_sizes

FloatArray = NDArray[np.float64]

MAX_OVERLAYS: Final = 100
MAX_PIXELS: Final = 200_000_000
"""Greatest number of pixels of all overlays of a file together."""
_MAX_KML_BYTES = 4 * 1024 * 1024
_MAX_PICTURE_BYTES = 512 * 1024 * 1024
_URL = re.compile(r"[a-z][a-z0-9+.-]+:|//", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class _LatLonBox:
    north: float
    south: float
    east: float
    west: float
    rotation_rad: float
    """Counter-clockwise, about the middle."""

    @property
    def middle(self) -> tuple[float, float]:
        """Longitude and latitude."""
        return (self.west + self.east) / 2.0, (self.south + self.north) / 2.0

    @property
    def half(self) -> tuple[float, float]:
        """Half the width and half the height, in degrees of latitude."""
        narrowing = math.cos(math.radians(self.middle[1]))
        return (self.east - self.west) / 2.0 * narrowing, (self.north - self.south) / 2.0

    def shares(self, longitude: FloatArray, latitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return places as shares of the picture, from 0 to 1 to the right and down."""
        narrowing = math.cos(math.radians(self.middle[1]))
        east, north = (longitude - self.middle[0]) * narrowing, latitude - self.middle[1]
        cos, sin = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        right, up = cos * east + sin * north, cos * north - sin * east
        return 0.5 + right / (2.0 * self.half[0]), 0.5 - up / (2.0 * self.half[1])

    def corners(self) -> tuple[FloatArray, FloatArray]:
        """Return longitudes and latitudes of the corners of the picture."""
        narrowing = math.cos(math.radians(self.middle[1]))
        right, up = np.array([-1, 1, 1, -1]) * self.half[0], np.array([1, 1, -1, -1]) * self.half[1]
        cos, sin = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        return self.middle[0] + (cos * right - sin * up) / narrowing, self.middle[1] + sin * right + cos * up


def kmz_sources(path: Path) -> list[PictureSource]:
    """Return the ground overlays of a KMZ file, in the order in which they are drawn.

    Raises:
        InputDataError: it is no KMZ, has no ground overlay, or one that links to another place or cannot be read.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            overlays = sorted(_overlays(archive, path), key=_draw_order)
            if not overlays:
                raise InputDataError(
                    f"{path} has no ground overlay: a base map is made of pictures. Shapes are imported in Plan."
                )
            return _sources(archive, path, overlays)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError) as error:
        raise InputDataError(f"{path} is no KMZ that can be read: {str(error).rstrip('.')}.") from error


def _overlays(archive: zipfile.ZipFile, path: Path) -> Iterator[Element]:
    """Yield the ground overlays of the root document, which is the first KML file of the archive."""
    document = next((name for name in archive.namelist() if name.lower().endswith(".kml")), None)
    if document is None:
        raise InputDataError(f"{path} holds no KML document: it is no KMZ.")
    try:
        root = fromstring(_read(archive, document, _MAX_KML_BYTES, path))
    except (ParseError, DefusedXmlException, LookupError, ValueError) as error:
        raise InputDataError(f"{path}: {document} cannot be read as KML: {error}.") from error
    if _first(root, "NetworkLink") is not None:
        raise InputDataError(
            f"{path} is made of linked parts (a super-overlay): convert it to one picture (gdal_translate IN.kmz "
            "OUT.tif)."
        )
    for element in root.iter():
        if _name(element) == "GroundOverlay":
            yield element


def _sources(archive: zipfile.ZipFile, path: Path, overlays: list[Element]) -> list[PictureSource]:
    if len(overlays) > MAX_OVERLAYS:
        raise InputDataError(f"{path} has {len(overlays)} ground overlays; {MAX_OVERLAYS} are allowed.")
    left, sources = MAX_PIXELS, []
    for overlay in overlays:
        rgba = _picture(archive, path, overlay, left)
        left -= rgba.shape[0] * rgba.shape[1]
        sources.append(_placed(rgba, _box(overlay, path)))
    return sources


def _picture(archive: zipfile.ZipFile, path: Path, overlay: Element, max_pixels: int) -> NDArray[np.uint8]:
    """Return the picture of an overlay, shape (rows, columns, 4): red, green, blue and opacity."""
    icon = _first(overlay, "Icon")
    href = "" if icon is None else _text(icon, "href")
    if not href:
        raise InputDataError(f"{path}: a ground overlay names no picture.")
    if _URL.match(href):
        raise InputDataError(
            f"{path}: a ground overlay links to {href[:80]}, outside of the file: save it with its pictures inside."
        )
    data = _read(archive, href, _MAX_PICTURE_BYTES, path)
    try:
        ((width, height), *_) = picture_sizes(data)
    except InputDataError as error:
        raise InputDataError(f"{path}: {href}: {error}.") from error
    if width * height > max_pixels:
        raise InputDataError(
            f"{path}: its pictures have more than {MAX_PIXELS // 1_000_000} megapixels: make them smaller."
        )
    decoded = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if decoded is None or decoded.dtype != np.uint8:
        raise InputDataError(f"{path}: the picture {href} cannot be decoded to 8 bits.")
    conversions = {1: cv2.COLOR_GRAY2RGBA, 3: cv2.COLOR_BGR2RGBA, 4: cv2.COLOR_BGRA2RGBA}
    channels = 1 if decoded.ndim == 2 else decoded.shape[2]
    rgba = cv2.cvtColor(decoded, conversions[channels])
    rgba[..., 3] = np.rint(rgba[..., 3] * _opacity(overlay)).astype(np.uint8)
    return np.asarray(rgba, dtype=np.uint8)


def _box(overlay: Element, path: Path) -> _LatLonBox:
    element = _first(overlay, "LatLonBox")
    if element is None:
        raise InputDataError(f"{path}: a ground overlay has no LatLonBox, so that its place is not known.")
    try:
        north, south, east, west = (float(_text(element, side)) for side in ("north", "south", "east", "west"))
        rotation_deg = float(_text(element, "rotation") or 0.0)
    except ValueError as error:
        raise InputDataError(f"{path}: the LatLonBox of a ground overlay is incomplete: {error}.") from error
    if not (-90.0 < south < north < 90.0 and -180.0 <= west < east <= 180.0 and math.isfinite(rotation_deg)):
        raise InputDataError(
            f"{path}: the LatLonBox of a ground overlay is no place: {south:g} to {north:g} north, {west:g} to "
            f"{east:g} east."
        )
    return _LatLonBox(north, south, east, west, math.radians(rotation_deg))


def _placed(rgba: NDArray[np.uint8], box: _LatLonBox) -> PictureSource:
    rows, columns = rgba.shape[:2]
    x, y = from_degrees(*box.corners())
    extent = WorldBox(float(x.min()), float(y.min()), float(x.max()), float(y.max()))
    pixel = math.hypot(x[1] - x[0], y[1] - y[0]) / columns

    def to_pixels(longitude: FloatArray, latitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        right, down = box.shares(longitude, latitude)
        return right * columns - 0.5, down * rows - 0.5

    return PictureSource(rgba, extent, pixel, to_pixels)


def _opacity(overlay: Element) -> float:
    """Return the opacity of an overlay's colour, which is in hexadecimal digits: aabbggrr."""
    colour = _text(overlay, "color")
    return int(colour[:2], 16) / 255.0 if re.fullmatch(r"[0-9a-fA-F]{8}", colour) else 1.0


def _draw_order(overlay: Element) -> int:
    order = _text(overlay, "drawOrder")
    return int(order) if re.fullmatch(r"-?\d{1,9}", order) else 0


def _read(archive: zipfile.ZipFile, name: str, max_bytes: int, path: Path) -> bytes:
    try:
        info = archive.getinfo(name)
    except KeyError:
        raise InputDataError(f"{path}: the picture {name[:80]} is not in the file.") from None
    if info.file_size > max_bytes:
        raise InputDataError(f"{path}: {name} is larger than {max_bytes // 1024**2} MiB.")
    with archive.open(info) as content:
        # Whatever the archive says of its size, no more is unpacked.
        return content.read(max_bytes)


def _first(element: Element, name: str) -> Element | None:
    return next((one for one in element.iter() if _name(one) == name), None)


def _text(element: Element, name: str) -> str:
    """Return the text of a direct child, empty if there is none."""
    child = next((one for one in element if _name(one) == name), None)
    return "" if child is None or child.text is None else child.text.strip()


def _name(element: Element) -> str:
    """Return an element's name without its namespace."""
    return str(element.tag).rpartition("}")[2]
