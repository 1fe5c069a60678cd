"""What is known of a survey: its place, its findings, and how far its examination has come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.events import EventKind, NoticeRecord, PicturesRecord
from aos_gcs.mission.model.findings import Finding
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import FocusSnapshot, FocusSource, Picture, PictureKind, StepRecord
from aos_gcs.store.reader import MissionReader

PICTURES_KEY = "pictures"
"""Entry of a survey's manifest: names of its pictures."""
STRATEGY = "survey"
"""Name in the record where a mission has that of its strategy."""


@dataclass(frozen=True, slots=True)
class SurveyPlace:
    """A survey before anything is known of it."""

    name: str
    origin: GeodeticPosition
    area_enu_m: tuple[tuple[float, float], ...]
    """Rectangle around all that its frames see."""
    ground_m: float
    """Height of the ground above the origin."""

    def snapshot(self) -> MissionSnapshot:
        """Return the state before the first window."""
        return MissionSnapshot(
            mission_id=self.name,
            strategy=STRATEGY,
            phase=Phase.SCAN,
            suspension=Suspension.NONE,
            outcome=Outcome.OPEN,
            message="Reading the pictures.",
            elapsed_s=0.0,
            step=0,
            origin=self.origin,
            area_enu_m=self.area_enu_m,
            fence_enu_m=(),
            vehicles=(),
            preflight=(),
            target=None,
            min_separation_m=None,
            focus=FocusSnapshot(self.ground_m, FocusSource.CONFIGURED, None),
        )


@dataclass(slots=True)
class SurveyState:
    """State of a survey, in memory and as it is restored from its record."""

    snapshot: MissionSnapshot
    steps: list[StepRecord] = field(default_factory=list)
    pictures: dict[PictureKind, Picture] = field(default_factory=dict)
    event_count: int = 0
    """Number of the latest event in the record."""
    notice_count: int = 0

    @property
    def is_finished(self) -> bool:
        """Whether all windows have been examined."""
        return self.snapshot.phase is Phase.DONE

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All findings."""
        return self.snapshot.findings


def picture_names(reader: MissionReader) -> dict[int, str]:
    """Return the names of a survey's pictures by their indices; none where the record is that of a mission."""
    try:
        names = reader.manifest().get(PICTURES_KEY)
    except InputDataError:
        return {}
    return dict(enumerate(map(str, names))) if isinstance(names, list) else {}


def restored(reader: MissionReader) -> SurveyState:
    """Return the state that a record holds.

    Raises:
        InputDataError: it holds none, or is damaged.
    """
    snapshot = reader.last_snapshot()
    if snapshot is None or snapshot.strategy != STRATEGY:
        raise InputDataError(f"{reader.folder} holds no survey.")
    index = reader.event_index()
    notices = [event.data for event in reader.events(EventKind.NOTICE) if isinstance(event.data, NoticeRecord)]
    steps = [record for record in reader.steps() if record.step <= snapshot.step]
    return SurveyState(
        snapshot=replace(snapshot, step=len(steps)),
        steps=steps,
        pictures={picture.kind: picture for picture in _pictures(reader)},
        event_count=index[-1].seq,
        notice_count=max((notice.notice_id for notice in notices), default=0),
    )


def _pictures(reader: MissionReader) -> Sequence[Picture]:
    latest = [event.data for event in reader.events(EventKind.PICTURES) if isinstance(event.data, PicturesRecord)][-1:]
    return [
        Picture(kind, one.step, png, one.west_m, one.south_m, one.east_m, one.north_m)
        for one in latest
        for kind in one.kinds
        if (png := reader.picture(one.step, kind)) is not None
    ]
