"""What a sortie leaves to the next one of the same operation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.model.findings import Finding
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.planning.remaining import remaining_area
from aos_gcs.planning.settings import MissionSettings


@dataclass(frozen=True, slots=True)
class NextSortie:
    """Beginning of a sortie that follows another one."""

    settings: MissionSettings
    """Settings of the former sortie, with what it has left of its area. The operator starts it."""
    findings: tuple[Finding, ...]
    """Findings of all former sorties."""
    former_id: str
    """Identifier of the former sortie: its map of the searched ground goes on."""
    number: int
    """Number of the sortie in its operation; the first one has 1."""
    operation: str
    """Identifier of the operation: that of its first mission."""
    text: str
    """What is proposed, for operators."""
    left_for_later: tuple[LeftPlace, ...] = ()
    """Places that were in view and not looked at."""
    folder: Path | None = None
    """Folder of the former sortie's record; None: beside that of this one."""


def next_sortie(
    mission_id: str,
    settings: MissionSettings,
    origin: GeodeticPosition | None,
    decider: Decider,
    *,
    findings: Sequence[Finding],
    former: NextSortie | None,
) -> NextSortie:
    """Return the beginning of the sortie that follows a mission which has ended.

    Args:
        mission_id: identifier of that mission.
        settings: settings that it has flown by.
        origin: origin of its frame, which the next one shares, as findings and areas are in it.
        decider: progress of its scan, and what it has left for later.
        findings: its findings, those of former sorties included.
        former: what it has begun with; None for the first sortie.
    """
    progress, passes, left = decider.progress, settings.search.passes, decider.choice.left_for_later
    area_enu_m = remaining_area(settings.area_enu_m, progress.planned_legs, progress.leg, progress.along_m, passes)
    text = "The area is searched: it is proposed again."
    if area_enu_m is not None:
        text = "The part of the area that is not searched yet is proposed."
        if area_enu_m == settings.area_enu_m:
            text = "The whole area is proposed: no leg of it was flown to its end."
            if passes > 1:
                text = "The whole area is proposed: no leg of its last pass was flown to its end."
    if left:
        places = "1 place" if len(left) == 1 else f"{len(left)} places"
        text += f" What is left for later, {places}, is looked at behind the last leg if the geofence allows it."
    return NextSortie(
        settings=replace(
            settings,
            area_enu_m=settings.area_enu_m if area_enu_m is None else area_enu_m,
            origin=settings.origin if origin is None else origin,
            auto_start=False,
        ),
        findings=carried_findings(findings, mission_id),
        former_id=mission_id,
        number=2 if former is None else former.number + 1,
        operation=mission_id if former is None else former.operation,
        text=text,
        left_for_later=left,
    )


def carried_findings(findings: Sequence[Finding], mission_id: str) -> tuple[Finding, ...]:
    """Return the findings of a mission as the next sortie knows them."""
    return tuple(_carried(finding, mission_id) for finding in findings)


def _carried(finding: Finding, mission_id: str) -> Finding:
    """Return a finding as the next sortie knows it: its track, times and step are those of another mission."""
    found_in = finding.found_in or mission_id
    return replace(finding, found_in=found_in, track_id=None, found_at_s=0.0, seen_at_s=0.0)
