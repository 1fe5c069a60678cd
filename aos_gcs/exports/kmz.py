"""Findings with their pictures in one file for Google Earth and phones."""

from __future__ import annotations

import html
import io
import zipfile
from collections.abc import Mapping, Sequence
from typing import Final
from xml.etree import ElementTree as ET

from aos_gcs.exports.finding_files import KML, PlacedFinding, placemark, xml_document

MEDIA_TYPE: Final = "application/vnd.google-earth.kmz"
_WRITTEN: Final = (1980, 1, 1, 0, 0, 0)
"""Time of the entries: the same findings make the same file."""
Pictures = Mapping[str, bytes]
"""PNG files by what they show."""


def to_kmz(findings: Sequence[PlacedFinding], pictures: Mapping[int, Pictures]) -> bytes:
    """Return an archive of a document and the pictures that its balloons show.

    Args:
        findings: findings and their places.
        pictures: pictures by the number of the finding; those without any have none.
    """
    root = ET.Element("kml", xmlns=KML)
    document = ET.SubElement(root, "Document")
    ET.SubElement(document, "name").text = "Findings"
    files: dict[str, bytes] = {}
    for placed in findings:
        number = placed.finding.finding_id
        named = {f"files/finding-{number}-{kind}.png": png for kind, png in pictures.get(number, {}).items()}
        files |= named
        # Balloons are HTML: what people have written must not become markup.
        balloon = f"<p>{html.escape(placed.description())}</p>"
        balloon += "".join(f'<img src="{path}" width="320"/>' for path in named)
        document.append(placemark(placed, balloon))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in {"doc.kml": xml_document(root).encode(), **files}.items():
            archive.writestr(zipfile.ZipInfo(path, _WRITTEN), data, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()
