"""Proposals for the plan: marks and drawings that others have sent, and what operators have made of them.

A proposal commands nothing and changes nothing. It comes from outside by way of a process that reads what strangers
send; so its bounds are checked where it is made, and again where it is kept.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.heights import AmslM

MAX_PROPOSALS: Final = 64
"""Number of proposals that are kept; further ones are refused until some are decided."""
MAX_PROPOSAL_POINTS: Final = 200
MAX_UID: Final = 160
MAX_NAME: Final = 80
"""Longest name of a mark, and of its sender."""
MAX_REMARKS: Final = 300
_MAX_POINTS_OF: Final = {"point": (1, 1), "line": (2, MAX_PROPOSAL_POINTS), "area": (3, MAX_PROPOSAL_POINTS)}


class ProposalShape(StrEnum):
    """Form of a proposal."""

    POINT = "point"
    LINE = "line"
    AREA = "area"


class ProposalUse(StrEnum):
    """What an operator has made of a proposal."""

    AREA = "area"
    """Search area."""
    NO_GO = "no_go"
    FENCE = "fence"
    LAUNCH = "launch"
    RETURN = "return"
    FINDING = "finding"
    """A place to look at, among the findings."""
    DISMISSED = "dismissed"


POINT_USES: Final = frozenset({ProposalUse.LAUNCH, ProposalUse.RETURN, ProposalUse.FINDING})
AREA_USES: Final = frozenset({ProposalUse.AREA, ProposalUse.NO_GO, ProposalUse.FENCE})


@dataclass(frozen=True, slots=True)
class Proposal:
    """A mark or a drawing of somebody else."""

    uid: str
    """Name by which the sender changes or deletes it."""
    source: str
    """System that it comes from, such as ``TAK``."""
    name: str
    """Label, for operators."""
    sender: str
    """Call sign of the sender; empty where the mark names none."""
    kind: str
    """Type in the terms of the other system."""
    shape: ProposalShape
    points_deg: tuple[tuple[float, float], ...]
    """Latitude and longitude (WGS84) of its points; an area does not repeat the first one."""
    altitude_amsl_m: AmslM | None
    """Altitude above mean sea level of a point; None where it is not known, and for lines and areas."""
    remarks: str
    sent_utc_s: float
    """Time at which it was made, by the sender's clock."""
    stale_utc_s: float
    """Time from which it is out of date, by the sender's clock."""
    received_utc_s: float

    def require_bounds(self) -> None:
        """Refuse what no honest reader of strangers' messages would make of them.

        Raises:
            InputDataError: a text is too long, or a place or a time is none.
        """
        lengths = {"uid": MAX_UID, "source": MAX_NAME, "name": MAX_NAME, "sender": MAX_NAME, "kind": MAX_NAME}
        for field, most in (lengths | {"remarks": MAX_REMARKS}).items():
            if len(getattr(self, field)) > most:
                raise InputDataError(f"A proposal's {field} has more than {most} characters.")
        least, most = _MAX_POINTS_OF[self.shape]
        if not least <= len(self.points_deg) <= most:
            raise InputDataError(f"It has {len(self.points_deg)} points; {least} to {most} are possible.")
        for latitude_deg, longitude_deg in self.points_deg:
            if not (abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0):
                raise InputDataError(f"{latitude_deg:g}, {longitude_deg:g} is no latitude and longitude.")
        times = (self.sent_utc_s, self.stale_utc_s, self.received_utc_s)
        if not all(map(math.isfinite, times)):
            raise InputDataError("A proposal's times must be finite.")

    @property
    def content(self) -> tuple[object, ...]:
        """What an operator decides on: the rest only tells when it was sent again."""
        return self.name, self.shape, self.points_deg, self.altitude_amsl_m, self.remarks

    def allows(self, use: ProposalUse) -> bool:
        """Return whether it can be used so: points as points, areas as areas, and closed lines as areas, too."""
        if use is ProposalUse.DISMISSED:
            return True
        if self.shape is ProposalShape.POINT:
            return use in POINT_USES
        return use in AREA_USES and len(self.points_deg) >= _MAX_POINTS_OF[ProposalShape.AREA][0]


@dataclass(frozen=True, slots=True)
class ProposalRecord:
    """A proposal, and what an operator has decided about it."""

    proposal_id: int
    """Counts from 1; a proposal whose content changes gets another one."""
    proposal: Proposal
    use: ProposalUse | None = None
    """None until somebody has decided."""
    operator: str = ""
    decided_utc_s: float | None = None
