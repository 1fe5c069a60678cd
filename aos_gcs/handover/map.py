"""Map of a sortie to scale, north up, drawn for black and white."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from PIL import Image
from reportlab.lib.colors import Color
from reportlab.lib.utils import ImageReader
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import Flowable

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.handover.model import Handover, Raster
from aos_gcs.handover.searched import LEGENDS, searched_grey
from aos_gcs.handover.styles import BOLD, FONT
from aos_gcs.handover.texts import Writer
from aos_gcs.mission.model.findings import Finding, FindingStatus

Point = tuple[float, float]

MARGIN_M: Final = 15.0
_ELLIPSE_POINTS: Final = 48
_LEGEND_PT: Final = 12.0
_WHITE: Final = Color(1.0, 1.0, 1.0)
_BLACK: Final = Color(0.0, 0.0, 0.0)
_TRACK: Final = Color(0.15, 0.15, 0.15)
_NO_GO: Final = Color(0.6, 0.6, 0.6)


class MissionMap(Flowable):
    """The map, as large as its place on the paper allows.

    Args:
        handover: content.
        writer: notation of the corners' places.
        width: width that it may take, points.
        height: height that it may take, points.
    """

    def __init__(self, handover: Handover, writer: Writer, width: float, height: float) -> None:
        super().__init__()
        self._handover = handover
        self._writer = writer
        self._bounds = _bounds(handover)
        west_m, south_m, east_m, north_m = self._bounds
        drawing = height - 3.0 * _LEGEND_PT
        self._scale = min(width / (east_m - west_m), drawing / (north_m - south_m))
        self.width = width
        self._across = self._scale * (east_m - west_m)
        self._drawing = self._scale * (north_m - south_m)
        self.height = self._drawing + 3.0 * _LEGEND_PT

    def draw(self) -> None:
        """Draw on the canvas of the page."""
        canvas, final = self.canv, self._handover.final
        canvas.saveState()
        canvas.translate((self.width - self._across) / 2.0, 3.0 * _LEGEND_PT)
        canvas.saveState()
        frame = canvas.beginPath()
        frame.rect(0.0, 0.0, self._across, self._drawing)
        canvas.clipPath(frame, stroke=0, fill=0)
        if self._handover.searched is not None:
            self._draw_searched(canvas, self._handover.searched)
        for zone in final.no_go_enu_m:
            self._ring(canvas, zone, width=0.8, fill=_NO_GO)
        self._ring(canvas, final.fence_enu_m, width=0.8, dash=(5, 2))
        self._ring(canvas, final.area_enu_m, width=1.6)
        for start, end in final.legs_enu_m:
            self._line(canvas, (start, end), width=0.4, dash=(1, 2))
        for ways in self._handover.tracks_enu_m.values():
            for way in ways:
                self._line(canvas, [(east_m, north_m) for east_m, north_m, _ in way], width=0.4, colour=_TRACK)
        self._draw_homes(canvas)
        for reported in reversed(self._handover.findings):
            self._draw_finding(canvas, reported.finding)
        canvas.restoreState()
        canvas.setLineWidth(0.7)
        canvas.rect(0.0, 0.0, self._across, self._drawing)
        self._draw_scale(canvas)
        self._draw_north(canvas)
        canvas.restoreState()
        self._draw_legend(canvas)

    def _at(self, point: Sequence[float]) -> Point:
        """Return a place of the mission's frame on the paper."""
        west_m, south_m, _, _ = self._bounds
        return self._scale * (point[0] - west_m), self._scale * (point[1] - south_m)

    def _draw_searched(self, canvas: Canvas, raster: Raster) -> None:
        left, bottom = self._at((raster.west_m, raster.south_m))
        width = self._scale * (raster.east_m - raster.west_m)
        height = self._scale * (raster.north_m - raster.south_m)
        canvas.drawImage(ImageReader(Image.fromarray(searched_grey(raster))), left, bottom, width, height)

    def _ring(
        self,
        canvas: Canvas,
        corners: Sequence[Sequence[float]],
        *,
        width: float,
        dash: tuple[float, ...] = (),
        fill: Color | None = None,
    ) -> None:
        if corners:
            self._path(canvas, corners, width=width, dash=dash, fill=fill, close=True)

    def _line(
        self,
        canvas: Canvas,
        points: Sequence[Sequence[float]],
        *,
        width: float,
        dash: tuple[float, ...] = (),
        colour: Color = _BLACK,
    ) -> None:
        if len(points) > 1:
            self._path(canvas, points, width=width, dash=dash, colour=colour)

    def _path(
        self,
        canvas: Canvas,
        points: Sequence[Sequence[float]],
        *,
        width: float,
        dash: tuple[float, ...] = (),
        colour: Color = _BLACK,
        fill: Color | None = None,
        close: bool = False,
    ) -> None:
        path = canvas.beginPath()
        path.moveTo(*self._at(points[0]))
        for point in points[1:]:
            path.lineTo(*self._at(point))
        if close:
            path.close()
        canvas.setLineWidth(width)
        canvas.setDash(dash)
        canvas.setStrokeColor(colour)
        canvas.setFillColor(_WHITE if fill is None else fill)
        canvas.drawPath(path, stroke=1, fill=int(fill is not None))
        canvas.setDash()

    def _draw_homes(self, canvas: Canvas) -> None:
        canvas.setFillColor(_BLACK)
        for vehicle in self._handover.final.vehicles:
            if vehicle.home_enu_m is not None and vehicle.takes_part:
                x, y = self._at(vehicle.home_enu_m)
                canvas.rect(x - 1.5, y - 1.5, 3.0, 3.0, stroke=0, fill=1)

    def _draw_finding(self, canvas: Canvas, finding: Finding) -> None:
        if finding.ellipse is not None:
            self._ring(canvas, _outline(finding), width=0.5)
        x, y = self._at(finding.position_enu_m)
        text, size = str(finding.finding_id), 8.0
        half = max(6.0, 0.7 * canvas.stringWidth(text, BOLD, size))
        is_counted = finding.stands
        canvas.setStrokeColor(_BLACK)
        canvas.setLineWidth(0.8)
        canvas.setFillColor(_BLACK if is_counted else _WHITE)
        centre = x, y + 2.2 * half
        canvas.line(x, y, centre[0], centre[1])
        canvas.circle(*centre, half, stroke=1, fill=1)
        canvas.circle(x, y, 1.2, stroke=1, fill=1)
        canvas.setFillColor(_WHITE if is_counted else _BLACK)
        canvas.setFont(BOLD, size)
        canvas.drawCentredString(centre[0], centre[1] - 0.35 * size, text)
        if finding.status is FindingStatus.REJECTED:
            canvas.setLineWidth(1.2)
            canvas.line(centre[0] - half, centre[1] - half, centre[0] + half, centre[1] + half)

    def _draw_scale(self, canvas: Canvas) -> None:
        length_m = nice_length_m((self._bounds[2] - self._bounds[0]) / 4.0)
        length = self._scale * length_m
        canvas.setFillColor(_WHITE)
        canvas.setStrokeColor(_BLACK)
        canvas.rect(4.0, 4.0, length + 40.0, 11.0, stroke=0, fill=1)
        canvas.setLineWidth(1.5)
        canvas.line(7.0, 7.0, 7.0 + length, 7.0)
        canvas.line(7.0, 6.0, 7.0, 11.0)
        canvas.line(7.0 + length, 6.0, 7.0 + length, 11.0)
        canvas.setFillColor(_BLACK)
        canvas.setFont(FONT, 7.0)
        canvas.drawString(11.0 + length, 7.0, f"{length_m:g} m")

    def _draw_north(self, canvas: Canvas) -> None:
        x, y = self._across - 14.0, self._drawing - 30.0
        canvas.setFillColor(_WHITE)
        canvas.rect(x - 8.0, y - 3.0, 18.0, 31.0, stroke=0, fill=1)
        canvas.setFillColor(_BLACK)
        arrow = canvas.beginPath()
        arrow.moveTo(x + 1.0, y + 17.0)
        arrow.lineTo(x - 4.0, y)
        arrow.lineTo(x + 1.0, y + 4.0)
        arrow.lineTo(x + 6.0, y)
        arrow.close()
        canvas.drawPath(arrow, stroke=0, fill=1)
        canvas.setFont(BOLD, 8.0)
        canvas.drawCentredString(x + 1.0, y + 19.0, "N")

    def _draw_legend(self, canvas: Canvas) -> None:
        west_m, south_m, east_m, north_m = self._bounds
        canvas.setFillColor(_BLACK)
        canvas.setFont(FONT, 6.5)
        has_zones = " · dark: no-go zone" if self._handover.final.no_go_enu_m else ""
        raster = self._handover.searched
        searched = "" if raster is None else f"{LEGENDS[raster.kind]} · "
        corners = (
            f"north-west corner {self._place((west_m, north_m, 0.0))}"
            f" · south-east corner {self._place((east_m, south_m, 0.0))}"
        )
        lines = (
            f"thick: search area · dashed: geofence · dotted: legs · thin: flown · squares: launch points{has_zones}",
            f"{searched}black number: counts as a person · white: other finding · struck out: rejected",
            corners,
        )
        for row, line in enumerate(lines):
            canvas.drawString(0.0, (2.1 - row) * _LEGEND_PT, line)

    def _place(self, point: EnuPoint) -> str:
        return self._writer.place(point)


def nice_length_m(most_m: float) -> float:
    """Return the largest of 1, 2, 5, 10, 20 … metres that is not longer."""
    power = 10.0 ** math.floor(math.log10(most_m))
    # Just below a power of ten the logarithm is rounded up to it.
    return next(factor * power for factor in (5.0, 2.0, 1.0, 0.5) if factor * power <= most_m)


def _bounds(handover: Handover) -> tuple[float, float, float, float]:
    """Return west, south, east and north of what was searched, flown and found; a wide geofence is cut off."""
    final = handover.final
    points: Iterable[Sequence[float]] = [
        *final.area_enu_m,
        *(point for ways in handover.tracks_enu_m.values() for way in ways for point in way),
        *(finding.finding.position_enu_m for finding in handover.findings),
        *(vehicle.home_enu_m for vehicle in final.vehicles if vehicle.home_enu_m is not None and vehicle.takes_part),
    ]
    places = np.array([point[:2] for point in points] or [(0.0, 0.0)])
    (west_m, south_m), (east_m, north_m) = places.min(axis=0) - MARGIN_M, places.max(axis=0) + MARGIN_M
    return float(west_m), float(south_m), float(east_m), float(north_m)


def _outline(finding: Finding) -> list[Point]:
    """Return the error ellipse of a finding, one standard deviation."""
    ellipse = finding.ellipse
    if ellipse is None:
        return []
    east_m, north_m, _ = finding.position_enu_m
    sine, cosine = math.sin(ellipse.heading_rad), math.cos(ellipse.heading_rad)
    points = []
    for angle in np.linspace(0.0, 2.0 * math.pi, _ELLIPSE_POINTS, endpoint=False):
        along_m, across_m = ellipse.semi_major_m * math.cos(angle), ellipse.semi_minor_m * math.sin(angle)
        points.append((east_m + along_m * sine + across_m * cosine, north_m + along_m * cosine - across_m * sine))
    return points
