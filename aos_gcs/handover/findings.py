"""Sheets of the findings: a list of all, then each with its pictures and facts."""

from __future__ import annotations

import io
from typing import Final

from reportlab.lib.units import mm
from reportlab.lib.utils import ImageReader
from reportlab.platypus import Flowable, KeepTogether, Spacer, Table, TableStyle

from aos_gcs.errors import InputDataError
from aos_gcs.handover.map import nice_length_m
from aos_gcs.handover.model import FindingPicture, Handover, ReportedFinding
from aos_gcs.handover.styles import FONT, box, boxes, listing, paragraph, styles
from aos_gcs.handover.texts import NOTATIONS, STATUSES, UNKNOWN, Writer, error_text, kind_text

_GAP: Final = 4 * mm
_LARGE: Final = 84 * mm
"""Edge of a picture of a possible person."""
_SMALL: Final = 52 * mm
"""Edge of a picture of another finding."""


def finding_sheets(handover: Handover, writer: Writer, width: float) -> list[Flowable]:
    """Return the list of all findings and a sheet of each."""
    content: list[Flowable] = [paragraph("Findings", styles().heading)]
    if not handover.findings:
        return [*content, paragraph("Nothing was found. That does not mean that nobody is there.")]
    rows = [_row(reported, writer) for reported in handover.findings]
    columns = (
        "No.",
        "Belief",
        "Status",
        f"Place, {NOTATIONS[writer.notation]}",
        "Error (1 sd)",
        "Decided by",
        "Assigned to",
    )
    widths = [share * width for share in (0.05, 0.19, 0.10, 0.23, 0.19, 0.12, 0.12)]
    content.append(listing(columns, rows, widths))
    for merged in handover.merged:
        same = f"Finding {merged.finding_id} is the same as finding {merged.merged_into}."
        content.append(paragraph(same, styles().small))
    for reported in handover.findings:
        content += _sheet(reported, writer, width)
    return content


def _row(reported: ReportedFinding, writer: Writer) -> tuple[str, ...]:
    finding = reported.finding
    return (
        str(finding.finding_id),
        kind_text(finding),
        STATUSES[finding.status],
        writer.place(finding.position_enu_m),
        error_text(finding),
        finding.decided_by or UNKNOWN,
        finding.assignee or UNKNOWN,
    )


def _sheet(reported: ReportedFinding, writer: Writer, width: float) -> list[Flowable]:
    finding = reported.finding
    east_m, north_m, _ = finding.position_enu_m
    found = f"in sortie {finding.found_in}" if finding.found_in else writer.time(reported.found_utc_s)
    facts = [
        [
            box(None, "Place", paragraph(writer.place(finding.position_enu_m), styles().bold)),
            box(None, "Error, one standard deviation", error_text(finding)),
            box(None, "From the mission's origin", f"{east_m:.1f} m east, {north_m:.1f} m north"),
        ],
        [
            box(None, "Status", STATUSES[finding.status]),
            box(None, "Decided by", _decided(reported, writer)),
            box(None, "Assigned to", finding.assignee or " "),
        ],
        [
            box(None, "First seen", found),
            box(None, "Last seen", writer.time(reported.seen_utc_s)),
            box(None, "Sightings", _sightings(finding.sightings, finding.step)),
        ],
    ]
    words = [box(None, "Reasons", "; ".join(finding.reasons) or UNKNOWN), box(None, "Comment", finding.comment or " ")]
    sheet = [
        paragraph(f"Finding {finding.finding_id}: {kind_text(finding)}", styles().heading),
        *_pictures(reported, width),
        boxes(facts, [width / 3.0] * 3),
        boxes([words], [0.5 * width] * 2),
    ]
    return [KeepTogether(sheet)]


def _decided(reported: ReportedFinding, writer: Writer) -> str:
    if not reported.finding.decided_by:
        return "nobody yet"
    is_earlier = reported.decided_utc_s is None
    time = "in an earlier sortie" if is_earlier else f"at {writer.time(reported.decided_utc_s)}"
    return f"{reported.finding.decided_by} {time}"


def _sightings(sightings: int, step: int) -> str:
    if sightings == 0:
        return "marked by hand"
    return f"{sightings}, shown in step {step}"


def _pictures(reported: ReportedFinding, width: float) -> list[Flowable]:
    if not reported.pictures:
        return [paragraph(f"No picture: {reported.pictures_missing}", styles().small)]
    edge = min(_LARGE if reported.finding.stands else _SMALL, (width - _GAP) / 2.0)
    drawn: list[Flowable | str] = [PlacePicture(picture, edge) for picture in reported.pictures]
    table = Table([drawn], colWidths=[edge + _GAP] * len(drawn), hAlign="LEFT")
    table.setStyle(TableStyle([("LEFTPADDING", (0, 0), (-1, -1), 0), ("VALIGN", (0, 0), (-1, -1), "TOP")]))
    return [table, Spacer(0, 1 * mm)]


class PlacePicture(Flowable):
    """A picture of the ground with its caption, a scale and marks that point to its middle.

    Args:
        picture: picture.
        edge: width and height of the picture on the paper, points.
    """

    def __init__(self, picture: FindingPicture, edge: float) -> None:
        super().__init__()
        self._picture = picture
        self._edge = edge
        self.width, self.height = edge, edge + 10.0

    def draw(self) -> None:
        """Draw on the canvas of the page."""
        canvas, edge = self.canv, self._edge
        canvas.saveState()
        try:
            image = ImageReader(io.BytesIO(self._picture.jpeg))
        except OSError as error:
            raise InputDataError(f"a picture of a finding is damaged: {error}") from error
        canvas.drawImage(image, 0.0, 10.0, edge, edge)
        canvas.setLineWidth(0.7)
        canvas.rect(0.0, 10.0, edge, edge)
        middle, mark = edge / 2.0, 6.0
        for x0, y0, x1, y1 in (
            (middle, 10.0, middle, 10.0 + mark),
            (middle, 10.0 + edge, middle, 10.0 + edge - mark),
            (0.0, 10.0 + middle, mark, 10.0 + middle),
            (edge, 10.0 + middle, edge - mark, 10.0 + middle),
        ):
            # Black on white shows on dark and on bright ground.
            for colour, line in ((1.0, 3.0), (0.0, 1.2)):
                canvas.setStrokeGray(colour)
                canvas.setLineWidth(line)
                canvas.line(x0, y0, x1, y1)
        self._draw_scale()
        canvas.setFillGray(0.0)
        canvas.setFont(FONT, 6.5)
        canvas.drawString(0.0, 1.5, self._picture.caption)
        canvas.restoreState()

    def _draw_scale(self) -> None:
        canvas = self.canv
        length_m = nice_length_m(self._picture.width_m / 4.0)
        length = self._edge * length_m / self._picture.width_m
        canvas.setFillGray(1.0)
        canvas.rect(3.0, 13.0, length + 24.0, 10.0, stroke=0, fill=1)
        canvas.setStrokeGray(0.0)
        canvas.setLineWidth(1.5)
        canvas.line(5.0, 16.0, 5.0 + length, 16.0)
        canvas.setFillGray(0.0)
        canvas.setFont(FONT, 6.5)
        canvas.drawString(8.0 + length, 15.5, f"{length_m:g} m")
