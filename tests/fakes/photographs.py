"""Photographs as drones write them: JPEG files with EXIF and XMP."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

NAMESPACES = {
    "drone-dji": "http://www.dji.com/drone-dji/1.0/",
    "drone": "http://www.autelrobotics.com/drone/1.0/",
    "drone-parrot": "http://www.parrot.com/drone-parrot/1.0/",
    "drone-skydio": "https://www.skydio.com/drone-skydio/1.0/",
    "exif": "http://ns.adobe.com/exif/1.0/",
    "Camera": "http://pix4d.com/camera/1.0/",
}


def xmp_packet(attributes: Mapping[str, object], elements: str = "") -> bytes:
    """Return a packet with properties, ``prefix:name`` to value, as attributes, and others as elements."""
    spaces = " ".join(f'xmlns:{prefix}="{uri}"' for prefix, uri in NAMESPACES.items())
    values = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    return (
        '<?xpacket begin="" id="W5M0MpCehiHzreSzNTczkc9d"?><x:xmpmeta xmlns:x="adobe:ns:meta/">'
        '<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        f'<rdf:Description rdf:about="" {spaces} {values}>{elements}</rdf:Description>'
        '</rdf:RDF></x:xmpmeta><?xpacket end="w"?>'
    ).encode()


def exif_block(
    latitude_deg: float | None = None,
    longitude_deg: float | None = None,
    altitude_m: float | None = None,
    camera: Mapping[int, Any] | None = None,
    orientation: int = 1,
    *,
    model: str | None = None,
    software: str | None = None,
) -> Image.Exif:
    """Return EXIF with a position in degrees, minutes and seconds, and tags of the camera."""
    exif = Image.Exif()
    exif[0x0112] = orientation
    if model is not None:
        exif[0x0110] = model
    if software is not None:
        exif[0x0131] = software
    gps: dict[int, Any] = {}
    if latitude_deg is not None and longitude_deg is not None:
        gps |= {1: "N" if latitude_deg >= 0 else "S", 2: _degrees_minutes_seconds(latitude_deg)}
        gps |= {3: "E" if longitude_deg >= 0 else "W", 4: _degrees_minutes_seconds(longitude_deg)}
    if altitude_m is not None:
        gps |= {5: b"\x00" if altitude_m >= 0 else b"\x01", 6: IFDRational(round(abs(altitude_m) * 1000), 1000)}
    if gps:
        exif[0x8825] = gps
    if camera:
        exif[0x8769] = dict(camera)
    # As it comes from a file: Pillow parses the nested tables of bytes only.
    read = Image.Exif()
    read.load(exif.tobytes())
    return read


def write_photograph(path: Path, image: NDArray[np.uint8], exif: Image.Exif, xmp: bytes = b"") -> None:
    """Write a JPEG of the best quality, shape (H, W) or (H, W, 3)."""
    Image.fromarray(image).save(path, "JPEG", quality=100, subsampling=0, exif=exif, xmp=xmp)


def write_temperatures(path: Path, celsius: NDArray[np.float32], exif: Image.Exif, xmp: bytes) -> None:
    """Write a TIFF of 32-bit floating-point numbers with geotags, shape (H, W)."""
    exif[700] = xmp
    Image.fromarray(celsius).save(path, "TIFF", exif=exif)


def _degrees_minutes_seconds(angle_deg: float) -> tuple[IFDRational, IFDRational, IFDRational]:
    degrees, rest = divmod(abs(angle_deg) * 60.0, 60.0)
    minutes, rest = divmod(rest, 1.0)
    return IFDRational(int(degrees), 1), IFDRational(int(minutes), 1), IFDRational(round(rest * 60e7), 10_000_000)
