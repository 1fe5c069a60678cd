"""Findings in words, for the maps of others."""

from __future__ import annotations

from datetime import UTC, datetime

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.notations import mgrs_text
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import KIND_NAMES, Finding, FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot

_OTHERS = frozenset({FindingKind.ANIMAL, FindingKind.WARM_OBJECT, FindingKind.OBJECT})
"""Kinds of findings that are no person."""


def is_shown(finding: Finding) -> bool:
    """Return whether a finding belongs on the maps of searchers.

    Rejected ones do not, nor those that have turned out to be another finding, nor what the mission takes for an animal
    or a thing before an operator has confirmed it.
    """
    if finding.merged_into is not None or finding.status is FindingStatus.REJECTED:
        return False
    return finding.status is FindingStatus.CONFIRMED or finding.kind not in _OTHERS


def finding_uid(finding: Finding, mission_id: str) -> str:
    """Return a name of a finding that it keeps in later sorties of the operation."""
    return f"{finding.found_in or mission_id}.finding.{finding.finding_id}"


def finding_title(finding: Finding) -> str:
    """Return a label for a map, such as ``Finding 3: Possible person (88 %), confirmed``."""
    kind = "Marked by hand" if finding.track_id is None and not finding.sightings else KIND_NAMES[finding.kind]
    confidence = "" if finding.person_confidence is None else f" ({finding.person_confidence:.0%})".replace("%", " %")
    status = "" if finding.status is FindingStatus.NEW else f", {finding.status}"
    return f"Finding {finding.finding_id}: {kind}{confidence}{status}"


def finding_remarks(finding: Finding, position: GeodeticPosition, snapshot: MissionSnapshot) -> str:
    """Return what searchers have to know beside the label.

    Args:
        finding: the finding.
        position: where it is.
        snapshot: state of the mission in which it is.
    """
    parts = [mgrs_text(position.latitude_deg, position.longitude_deg)]
    if finding.sigma_m is not None:
        parts.append(f"standard deviation {finding.sigma_m:.1f} m")
    if snapshot.started_utc_s is not None and not finding.found_in:
        seen = datetime.fromtimestamp(snapshot.started_utc_s + finding.seen_at_s, UTC)
        parts.append(f"last seen {seen:%H:%M:%S} UTC")
    if finding.sightings:
        parts.append(f"{finding.sightings} sightings")
    parts += finding.reasons
    if finding.decided_by:
        parts.append(f"judged by {finding.decided_by}")
    if finding.assignee:
        parts.append(f"assigned to {finding.assignee}")
    if finding.comment:
        parts.append(finding.comment)
    return "; ".join(parts)
