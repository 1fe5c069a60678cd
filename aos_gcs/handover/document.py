"""The hand-over as a PDF: summary with map, findings, assignment (after ICS 204), flights, and log (after ICS 214)."""

from __future__ import annotations

from functools import partial
from typing import BinaryIO, Final

from reportlab.lib.units import mm
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import BaseDocTemplate, Flowable, Frame, PageBreak, PageTemplate

from aos_gcs.handover.findings import finding_sheets
from aos_gcs.handover.forms import activity_log, assignment, flight_table
from aos_gcs.handover.map import MissionMap
from aos_gcs.handover.model import Handover, HandoverOptions
from aos_gcs.handover.styles import FONT, HEAD, MARGIN, SIZES, box, boxes, paragraph, register_fonts, styles
from aos_gcs.handover.texts import OUTCOMES, UNKNOWN, Writer, duration, make_writer, searched_lines, shortened
from aos_gcs.mission.model.findings import FindingStatus

_MAP_SHARE: Final = 0.55
"""Share of the first page's height that the map may take."""


def write_document(file: BinaryIO, handover: Handover, options: HandoverOptions, printed_utc_s: float) -> None:
    """Write the PDF.

    Args:
        file: file that is written.
        handover: content.
        options: paper, notation and time zone.
        printed_utc_s: time at which it is made.

    Raises:
        ConfigurationError: the time zone is not known.
        InputDataError: a picture of the record is damaged.
    """
    register_fonts()
    writer = make_writer(options.time_zone, options.notation, handover.frame)
    paper_width, paper_height = SIZES[options.paper]
    width, height = paper_width - 2.0 * MARGIN, paper_height - 2.0 * (MARGIN + HEAD)
    document = BaseDocTemplate(
        file,
        pagesize=SIZES[options.paper],
        title=f"Hand-over {shortened(handover.operation, 100)}",
        author="aos-gcs",
        subject="Findings, flights and log of a search",
    )
    place = Frame(MARGIN, MARGIN + HEAD, width, height, 0, 0, 0, 0)
    document.addPageTemplates([PageTemplate("page", [place])])
    content = [
        *_summary(handover, writer, width, height, printed_utc_s),
        *finding_sheets(handover, writer, width),
        PageBreak(),
        *assignment(handover, writer, width),
        *flight_table(handover, writer, width),
        PageBreak(),
        *activity_log(handover, writer, width),
    ]
    head = f"Hand-over · {shortened(handover.operation, 60)} · sortie {handover.sortie}"
    foot = f"Printed {writer.time(printed_utc_s)} · all times {writer.zone_name} · positions WGS 84"
    document.build(content, canvasmaker=partial(_NumberedCanvas, head=head, foot=foot))


class _NumberedCanvas(Canvas):
    """Writes head and foot once the number of pages is known."""

    def __init__(self, *args: object, head: str, foot: str, **kwargs: object) -> None:
        super().__init__(*args, **kwargs)
        self._texts = head, foot
        self._pages: list[dict[str, object]] = []

    def showPage(self) -> None:  # the library's name
        """Keep the page until all are known."""
        self._pages.append(dict(self.__dict__))
        self._startPage()

    def save(self) -> None:
        """Write all pages."""
        width, height = self._pagesize
        for number, page in enumerate(self._pages, start=1):
            self.__dict__.update(page)
            self.setFont(FONT, 7.0)
            self.setLineWidth(0.5)
            self.line(MARGIN, height - MARGIN - 4 * mm, width - MARGIN, height - MARGIN - 4 * mm)
            self.line(MARGIN, MARGIN + 5 * mm, width - MARGIN, MARGIN + 5 * mm)
            self.drawString(MARGIN, height - MARGIN - 2 * mm, self._texts[0])
            self.drawString(MARGIN, MARGIN + 1 * mm, self._texts[1])
            self.drawRightString(width - MARGIN, MARGIN + 1 * mm, f"Page {number} of {len(self._pages)}")
            super().showPage()
        super().save()


def _summary(handover: Handover, writer: Writer, width: float, height: float, printed_utc_s: float) -> list[Flowable]:
    final = handover.final
    persons = sum(one.finding.stands for one in handover.findings)
    undecided = sum(one.finding.status is FindingStatus.NEW for one in handover.findings)
    vehicles = [vehicle for vehicle in final.vehicles if vehicle.takes_part]
    found = f"{persons} counted as persons, {len(handover.findings)} in all, {undecided} not decided"
    result = OUTCOMES[handover.outcome]
    period = f"{writer.time(handover.start_utc_s)} to {writer.time(handover.end_utc_s)}"
    rows = [
        [
            box(None, "Incident name", " "),
            box(None, "Survey" if handover.is_survey else "Operation and sortie", _identity(handover)),
            box(None, "Result", result),
        ],
        [
            box(None, "Operational period", period),
            box(None, "Duration", duration(final.elapsed_s)),
            box(None, "Findings", found),
        ],
        [
            box(None, "Searched share of the area", *searched_lines(final)),
            box(None, "Vehicles", "none: recorded flight" if handover.is_survey else str(len(vehicles))),
            box(None, "Operators", ", ".join(handover.operators) or UNKNOWN),
        ],
    ]
    return [
        paragraph("Hand-over", styles().title),
        boxes(rows, [0.40 * width, 0.32 * width, 0.28 * width]),
        paragraph("Map", styles().heading),
        MissionMap(handover, writer, width, _MAP_SHARE * height),
        paragraph(_prepared(handover, writer, printed_utc_s), styles().small),
    ]


def _identity(handover: Handover) -> str:
    name = handover.operation
    if handover.final.mission_id != handover.operation:
        name += f" ({handover.final.mission_id})"
    return name if handover.is_survey else f"{name}, sortie {handover.sortie}"


def _prepared(handover: Handover, writer: Writer, printed_utc_s: float) -> str:
    version = f" of version {handover.version}" if handover.version else ""
    state = "" if handover.outcome is not None else f" The record was not closed at {writer.time(printed_utc_s)}."
    return (
        f"Made by aos-gcs from the record{version}.{state} A finding is something that the cameras have seen; that it "
        "is a person has to be seen on the ground. Ground without a finding may hide a person all the same."
    )
