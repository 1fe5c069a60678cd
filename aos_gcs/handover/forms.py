"""Assignment and activity log in the order of the forms ICS 204 and ICS 214, with room to write, and the flights."""

from __future__ import annotations

from typing import Final

from reportlab.lib.units import mm
from reportlab.platypus import Flowable, Spacer

from aos_gcs.groundmap.figures import GroundFigures, SegmentFigures
from aos_gcs.handover.model import Handover, LoggedFlight
from aos_gcs.handover.styles import box, boxes, listing, paragraph, styles
from aos_gcs.handover.texts import STATUSES, UNKNOWN, Writer, duration, kind_text, percent, searched_lines
from aos_gcs.mission.model.findings import FindingStatus
from aos_gcs.mission.model.vehicles import VehicleSnapshot

MOST_ENTRIES: Final = 2000
"""Largest number of entries of the log that are printed: the latest ones."""
_ROOM: Final = 9 * mm
"""Height of a box that is filled in by hand."""


def assignment(handover: Handover, writer: Writer, width: float) -> list[Flowable]:
    """Return the assignment of the sortie and what is left to do, in the order of ICS 204."""
    final = handover.final
    wide, half = [width], [0.5 * width, 0.5 * width]
    return [
        paragraph("Assignment (after ICS 204)", styles().heading),
        boxes(
            [
                [
                    [*box(1, "Incident name"), Spacer(0, _ROOM)],
                    box(2, "Operational period", _period(handover, writer)),
                ],
                [
                    box(3, "Branch, division, group", f"Air search, {handover.operation}, sortie {handover.sortie}"),
                    box(4, "Operations personnel", ", ".join(handover.operators) or " "),
                ],
            ],
            half,
        ),
        boxes([[box(5, "Resources assigned")]], wide),
        _resources(handover, writer, width),
        boxes(
            [
                [box(6, "Work assignments", *_area(handover, writer))],
                [box(7, "Special instructions", *_instructions(handover, writer))],
                [[*box(8, "Communications (name, function, channel, frequency)"), Spacer(0, 2 * _ROOM)]],
                [[*box(9, "Prepared by (name, position, signature, date and time)"), Spacer(0, _ROOM)]],
            ],
            wide,
        ),
        *([paragraph(f"Strategy {final.strategy}.", styles().small)] if final.strategy else []),
    ]


def flight_table(handover: Handover, writer: Writer, width: float) -> list[Flowable]:
    """Return the flights of all vehicles."""
    content: list[Flowable] = [paragraph("Flights", styles().heading)]
    if not handover.flights:
        return [*content, paragraph("No flight is in the record.")]
    columns = ("Vehicle", "Take-off", "Landing", "In the air", "Way", "Height", "Battery", "Used", "Pilot")
    widths = [share * width for share in (0.08, 0.19, 0.19, 0.11, 0.09, 0.08, 0.10, 0.06, 0.10)]
    rows = [_flight(flight, writer) for flight in handover.flights]
    note = "Ways go through the positions recorded once per second; heights are above the mission's origin."
    return [*content, listing(columns, rows, widths), paragraph(note, styles().small)]


def activity_log(handover: Handover, writer: Writer, width: float) -> list[Flowable]:
    """Return the log of events and communications, in the order of ICS 214."""
    shown = handover.log[-MOST_ENTRIES:]
    half = [0.5 * width, 0.5 * width]
    third = [width / 3.0] * 3
    resources = [f"vehicle {vehicle.telemetry.vehicle_id}" for vehicle in handover.final.vehicles if vehicle.takes_part]
    rows = [(writer.time(entry.utc_s), entry.severity, entry.source, entry.text) for entry in shown]
    content: list[Flowable] = [
        paragraph("Activity log (after ICS 214)", styles().heading),
        boxes(
            [
                [
                    [*box(1, "Incident name"), Spacer(0, _ROOM)],
                    box(2, "Operational period", _period(handover, writer)),
                ]
            ],
            half,
        ),
        boxes([[[*box(3, "Name"), Spacer(0, _ROOM)], box(4, "ICS position", " "), box(5, "Home agency", " ")]], third),
        boxes([[box(6, "Resources assigned", ", ".join(resources) or UNKNOWN)], [box(7, "Activity log")]], [width]),
    ]
    if len(shown) < len(handover.log):
        text = f"The latest {len(shown)} of {len(handover.log)} entries; the others are in the mission folder."
        content.append(paragraph(text, styles().small))
    if rows:
        columns = ("Date and time", "Kind", "Vehicle", "Notable activities")
        content.append(listing(columns, rows, [0.22 * width, 0.10 * width, 0.11 * width, 0.57 * width]))
    prepared = [*box(8, "Prepared by (name, position, signature, date and time)"), Spacer(0, _ROOM)]
    return [*content, boxes([[prepared]], [width]), paragraph(handover.audit, styles().small)]


def _period(handover: Handover, writer: Writer) -> str:
    return f"{writer.time(handover.start_utc_s)} to {writer.time(handover.end_utc_s)}"


def _resources(handover: Handover, writer: Writer, width: float) -> Flowable:
    """Return the vehicles; the contact is left to write."""
    vehicles = [vehicle for vehicle in handover.final.vehicles if vehicle.takes_part]
    if not vehicles:
        return boxes([[paragraph("No vehicles: the frames are those of a recorded flight.")]], [width])
    columns = ("Vehicle", "Autopilot", "Altitude layer", "Launch point", "Task at the end", "Frames", "Contact")
    widths = [share * width for share in (0.09, 0.13, 0.12, 0.28, 0.14, 0.09, 0.15)]
    rows = [_vehicle(vehicle, handover, writer) for vehicle in vehicles]
    return listing(columns, rows, widths)


def _vehicle(vehicle: VehicleSnapshot, handover: Handover, writer: Writer) -> tuple[str, ...]:
    layer_m, vehicle_id = vehicle.layer_height_m, vehicle.telemetry.vehicle_id
    return (
        str(vehicle_id),
        vehicle.telemetry.autopilot,
        UNKNOWN if layer_m is None else f"{layer_m:.1f} m",
        UNKNOWN if vehicle.home_enu_m is None else writer.place(vehicle.home_enu_m),
        vehicle.task.value,
        str(handover.frames.get(vehicle_id, 0)),
        " ",
    )


def _area(handover: Handover, writer: Writer) -> list[str]:
    final = handover.final
    corners = "; ".join(writer.place((east_m, north_m, 0.0)) for east_m, north_m in final.area_enu_m)
    flown = f"{len(final.legs_enu_m)} legs planned. " if final.legs_enu_m else ""
    return [
        f"Search area of {_area_m2(final.area_enu_m) / 10_000.0:.2f} ha, corners: {corners or 'not recorded'}.",
        f"{flown}Searched share of the area: {'. '.join(searched_lines(final))}.",
        *_searched(final.ground),
    ]


def _searched(ground: GroundFigures | None) -> list[str]:
    """Return how likely a person in the area would have been noticed, where that is known."""
    if ground is None or ground.detection is None:
        return []
    shares = ground.detection
    values = f"standing {percent(shares.standing)}, sitting {percent(shares.sitting)}, lying {percent(shares.lying)}"
    lines = [f"Mean probability of detection in the area, all sorties so far: {values}."]
    if ground.success is not None:
        lines.append(f"Probability of success by the prior, all sorties so far: {percent(ground.success)}.")
    return [*lines, *map(_segment, ground.segments)]


def _segment(segment: SegmentFigures) -> str:
    """Return the figures of a segment."""
    detection = "" if segment.detection is None else f", detection of a standing person {percent(segment.detection)}"
    success = "" if segment.success is None else f", success {percent(segment.success)}"
    seen = f"{percent(segment.seen_fraction)} of {segment.area_m2 / 10_000.0:.2f} ha seen"
    return f"Segment {segment.name}, all sorties so far: {seen}{detection}{success}."


def _instructions(handover: Handover, writer: Writer) -> list[str]:
    """Return what is left to do: findings that nobody has decided on, ground that was not seen, and zones to avoid."""
    final, lines = handover.final, []
    for reported in handover.findings:
        finding = reported.finding
        if finding.status is FindingStatus.REJECTED or not (finding.stands or finding.is_claimed):
            continue
        whom = f", assigned to {finding.assignee}" if finding.assignee else ""
        place = writer.place(finding.position_enu_m)
        lines.append(f"Finding {finding.finding_id}, {kind_text(finding)}: {place}. {STATUSES[finding.status]}{whom}.")
    undecided = [
        str(one.finding.finding_id)
        for one in handover.findings
        if one.finding.status is FindingStatus.NEW and not one.finding.stands
    ]
    if undecided:
        lines.append(f"Other findings that nobody has decided on: {', '.join(undecided)}.")
    if final.covered_fraction is not None and final.covered_fraction < 1.0:
        lines.append(f"{1.0 - final.covered_fraction:.0%} of the search area was in no frame.")
    if final.no_go_enu_m:
        lines.append(f"No-go zones: {len(final.no_go_enu_m)}, dark on the map.")
    return lines or [" "]


def _flight(flight: LoggedFlight, writer: Writer) -> tuple[str, ...]:
    landing = "not recorded" if flight.landing_utc_s is None else writer.time(flight.landing_utc_s)
    return (
        str(flight.vehicle_id),
        writer.time(flight.takeoff_utc_s),
        landing,
        duration(flight.duration_s),
        f"{flight.distance_m:.0f} m",
        f"{flight.max_height_m:.0f} m",
        f"{percent(flight.battery_takeoff)} to {percent(flight.battery_landing)}",
        percent(flight.battery_used),
        " ",
    )


def _area_m2(corners: tuple[tuple[float, float], ...]) -> float:
    """Return the area of a polygon."""
    following = (*corners[1:], *corners[:1])
    return abs(sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(corners, following, strict=True))) / 2.0
