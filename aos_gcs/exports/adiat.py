"""Results as ADIAT, the Automated Drone Image Analysis Tool, stores its own: ``ADIAT_Data.xml``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final
from xml.etree import ElementTree as ET

from aos_gcs.exports.finding_files import xml_document

FILE_NAME: Final = "ADIAT_Data.xml"
_ALGORITHM: Final = "RXAnomaly"
"""The one of ADIAT's algorithms that is closest to ours: it refuses files of others."""
_COLOUR: Final = (255, 0, 0)
_RADIUS_PX: Final = 15
"""Smallest radius of an area: it is drawn as a circle."""
_CORNERS: Final = 32


@dataclass(frozen=True, slots=True)
class InterestArea:
    """An area of interest in an image: an ellipse, given in pixels (u to the right, v down)."""

    centre_px: tuple[float, float]
    semi_major_px: float
    semi_minor_px: float
    heading_rad: float
    """Heading of the major axis, clockwise from the upper edge of the image."""
    comment: str
    confidence: float | None
    """Probability that it is a person; None where it is not known."""
    is_flagged: bool
    """Whether somebody has confirmed it."""
    is_by_hand: bool
    """Whether somebody has marked it by hand."""


@dataclass(frozen=True, slots=True)
class AdiatImage:
    """An image and what is of interest in it."""

    path: str
    """Relative to the folder of the results, with forward slashes."""
    areas: tuple[InterestArea, ...] = ()
    is_hidden: bool = False


def adiat_document(images: Sequence[AdiatImage]) -> str:
    """Return the file; images come in the order in which they are to be reviewed."""
    root = ET.Element("data")
    settings = ET.SubElement(root, "settings", output_dir="", input_dir="", num_processes="1")
    for name, value in {
        "identifier_color": str(_COLOUR),
        "aoi_radius": str(_RADIUS_PX),
        "min_area": "1",
        "max_area": "0",
        "hist_ref_path": "",
        "kmeans_clusters": "0",
        "algorithm": _ALGORITHM,
        "thermal": "False",
    }.items():
        settings.set(name, value)
    ET.SubElement(settings, "options")
    listed = ET.SubElement(root, "images")
    for image in images:
        element = ET.SubElement(listed, "image", path=image.path, hidden=str(image.is_hidden))
        for area in image.areas:
            ET.SubElement(element, "areas_of_interest", _attributes(area))
    return xml_document(root)


def _attributes(area: InterestArea) -> dict[str, str]:
    u, v = round(area.centre_px[0]), round(area.centre_px[1])
    attributes = {
        "center": str((u, v)),
        "radius": str(max(_RADIUS_PX, math.ceil(area.semi_major_px))),
        "area": f"{math.pi * area.semi_major_px * area.semi_minor_px:.1f}",
        "flagged": str(area.is_flagged),
        "user_comment": area.comment,
        "user_created": str(area.is_by_hand),
        "contour": str(_contour(area)),
    }
    if area.confidence is not None and math.isfinite(area.confidence):
        attributes |= {
            "confidence": f"{100.0 * area.confidence:.1f}",
            "raw_score": f"{area.confidence:.4f}",
            "score_type": "probability",
            "score_method": "person",
        }
    return attributes


def _contour(area: InterestArea) -> list[list[int]]:
    """Return points of the ellipse's outline."""
    (u, v), points = area.centre_px, []
    sine, cosine = math.sin(area.heading_rad), math.cos(area.heading_rad)
    for corner in range(_CORNERS):
        angle = 2.0 * math.pi * corner / _CORNERS
        along_px, across_px = area.semi_major_px * math.cos(angle), area.semi_minor_px * math.sin(angle)
        right_px, up_px = along_px * sine + across_px * cosine, along_px * cosine - across_px * sine
        points.append([round(u + right_px), round(v - up_px)])
    return points
