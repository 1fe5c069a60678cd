"""What a mission puts on the maps of others: vehicles, places looked at, area, legs and findings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from aos_gcs.geometry.geodesy import EnuPoint, LocalFrame
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.model.vehicles import VehicleSnapshot
from aos_gcs.sharing.heights import UndulationM, ellipsoidal_m
from aos_gcs.sharing.state import SeenState
from aos_gcs.sharing.tak.events import CE90, LE90, Mark, clean
from aos_gcs.sharing.wording import finding_remarks, finding_title, finding_uid, is_shown

VEHICLE_S = 10.0
"""Lifetime of a vehicle's mark."""
SHAPE_S = 300.0
"""Lifetime of areas, legs and places looked at."""
FINDING_S = 3600.0
"""Lifetime of a finding: it outlasts the station by an hour."""
_ROTORCRAFT = "a-f-A-M-H-Q"
_SHAPE = "u-d-f"
_LOOK = "b-m-p-s-p-i"
_SPOT = "b-m-p-s-m"
_RED, _ORANGE, _YELLOW, _WHITE, _GREEN, _NO_FILL = -65536, -29696, -256, -1, -16711936, 16777215
"""Colours as signed integers of alpha, red, green and blue."""
_MOVING_MPS = 0.3
"""Speed below which the course of a vehicle is its heading."""


@dataclass(frozen=True, slots=True)
class Scene:
    """All marks of a state, and those that must be on no map."""

    marks: tuple[Mark, ...] = ()
    withdrawn: tuple[str, ...] = ()
    """Names of the marks of findings that were rejected or have turned out to be others."""


def scene(state: SeenState, name: str, undulation_m: UndulationM | None, now_s: float) -> Scene:
    """Return the marks of a mission's state; none before its origin is known.

    Args:
        state: state of the mission.
        name: name of this station.
        undulation_m: height of the geoid; None: heights are sent as unknown.
        now_s: real seconds of the clock that the processes share.
    """
    origin = state.snapshot.origin
    if origin is None:
        return Scene()
    painter = _Painter(state, name, LocalFrame(origin), undulation_m)
    findings = state.snapshot.findings
    marks = [
        *(painter.vehicle(one) for one in state.fresh_vehicles(now_s)),
        *painter.looks(),
        *painter.areas(),
        *(painter.finding(one) for one in findings if is_shown(one)),
    ]
    return Scene(tuple(marks), tuple(painter.finding_uid(one) for one in findings if not is_shown(one)))


@dataclass(frozen=True, slots=True)
class _Painter:
    state: SeenState
    name: str
    frame: LocalFrame
    undulation_m: UndulationM | None

    def vehicle(self, vehicle: VehicleSnapshot) -> Mark:
        telemetry = vehicle.telemetry
        east_mps, north_mps, _ = telemetry.velocity_enu_mps or (0.0, 0.0, 0.0)
        speed_mps = math.hypot(east_mps, north_mps)
        course_rad = math.atan2(east_mps, north_mps) if speed_mps > _MOVING_MPS else telemetry.heading_rad
        detail = _detail(f"{self.name} {telemetry.vehicle_id}", f"Task: {vehicle.task}")
        if course_rad is not None:
            course_deg = math.degrees(course_rad) % 360.0
            ET.SubElement(detail, "track", course=f"{course_deg:.1f}", speed=f"{speed_mps:.2f}")
        if telemetry.battery_fraction is not None:
            ET.SubElement(detail, "status", battery=f"{100.0 * telemetry.battery_fraction:.0f}")
        return self._mark(
            f"{self.name}.vehicle.{telemetry.vehicle_id}",
            _ROTORCRAFT,
            vehicle.position_enu_m or (0.0, 0.0, 0.0),
            detail,
            VEHICLE_S,
            how="m-g",
            ce_m=_times(telemetry.horizontal_accuracy_m, CE90),
            le_m=_times(telemetry.vertical_accuracy_m, LE90),
            is_live=True,
        )

    def looks(self) -> Iterator[Mark]:
        """Yield what each camera saw last: the middle of the frame, tied to the vehicle, and its outline."""
        focus = self.state.snapshot.focus
        height_m = 0.0 if focus is None else focus.height_m
        for vehicle in self.state.snapshot.vehicles:
            corners = () if vehicle.camera is None else vehicle.camera.footprint_enu_m
            if not corners:
                continue
            number = vehicle.telemetry.vehicle_id
            look = _detail(f"{self.name} {number} looks here")
            uid = f"{self.name}.vehicle.{number}"
            ET.SubElement(look, "link", uid=uid, relation="p-p", type=_ROTORCRAFT)
            yield self._mark(f"{self.name}.look.{number}", _LOOK, (*_middle(corners), height_m), look, SHAPE_S)
            outline = f"{self.name}.frame.{number}"
            yield self._shape(outline, f"{self.name} {number} frame", [*corners, corners[0]], _WHITE, height_m)

    def areas(self) -> Iterator[Mark]:
        """Yield the search area and the legs that have been flown."""
        snapshot = self.state.snapshot
        if snapshot.area_enu_m:
            corners = [*snapshot.area_enu_m, snapshot.area_enu_m[0]]
            yield self._shape(f"{self.name}.area", f"{self.name} search area", corners, _ORANGE)
        for number, leg in enumerate(snapshot.legs_enu_m[: snapshot.leg], start=1):
            yield self._shape(f"{self.name}.leg.{number}", f"{self.name} leg {number}, flown", leg, _GREEN)

    def finding(self, finding: Finding) -> Mark:
        position = self.frame.to_geodetic(finding.position_enu_m)
        remarks = finding_remarks(finding, position, self.state.snapshot)
        detail = _detail(finding_title(finding), remarks)
        is_confirmed = finding.status is FindingStatus.CONFIRMED
        colour = _RED if is_confirmed else _ORANGE if finding.is_claimed else _YELLOW
        ET.SubElement(detail, "color", argb=str(colour))
        sigma_m = finding.sigma_m if finding.ellipse is None else finding.ellipse.semi_major_m
        how = "h-e" if finding.track_id is None and not finding.sightings else "m-f"
        uid = self.finding_uid(finding)
        return self._mark(uid, _SPOT, finding.position_enu_m, detail, FINDING_S, how=how, ce_m=_times(sigma_m, CE90))

    def finding_uid(self, finding: Finding) -> str:
        return f"{self.name}.{finding_uid(finding, self.state.snapshot.mission_id)}"

    def _shape(
        self, uid: str, title: str, points: Sequence[tuple[float, float]], colour: int, height_m: float = 0.0
    ) -> Mark:
        detail = _detail(title)
        for east_m, north_m in points:
            position = self.frame.to_geodetic((east_m, north_m, height_m))
            ET.SubElement(detail, "link", point=f"{position.latitude_deg:.7f},{position.longitude_deg:.7f}")
        for tag, value in (("strokeColor", colour), ("fillColor", _NO_FILL), ("strokeWeight", 3.0)):
            ET.SubElement(detail, tag, value=str(value))
        return self._mark(uid, _SHAPE, (*_middle(points), height_m), detail, SHAPE_S)

    def _mark(
        self,
        uid: str,
        kind: str,
        position_enu_m: EnuPoint,
        detail: ET.Element,
        lifetime_s: float,
        *,
        how: str = "m-g",
        ce_m: float | None = None,
        le_m: float | None = None,
        is_live: bool = False,
    ) -> Mark:
        position = self.frame.to_geodetic(position_enu_m)
        return Mark(
            uid=uid,
            type=kind,
            how=how,
            latitude_deg=position.latitude_deg,
            longitude_deg=position.longitude_deg,
            hae_m=ellipsoidal_m(position, self.undulation_m),
            lifetime_s=lifetime_s,
            detail=ET.tostring(detail, encoding="unicode"),
            ce_m=ce_m,
            le_m=le_m,
            is_live=is_live,
        )


def _detail(callsign: str, remarks: str = "") -> ET.Element:
    detail = ET.Element("detail")
    ET.SubElement(detail, "contact", callsign=clean(callsign))
    if remarks:
        ET.SubElement(detail, "remarks").text = clean(remarks)
    return detail


def _middle(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    corners = points[:-1] if len(points) > 1 and points[0] == points[-1] else points
    easts, norths = zip(*corners, strict=True)
    return sum(easts) / len(easts), sum(norths) / len(norths)


def _times(sigma_m: float | None, factor: float) -> float | None:
    return None if sigma_m is None or not math.isfinite(sigma_m) else factor * sigma_m
