"""Hands the mission's events to all connected clients."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from aos_gcs.api import convert, messages
from aos_gcs.api.models import SCHEMA_VERSION, NoticeModel, PictureModel, StepModel
from aos_gcs.api.outbox import DEFAULT_CAPACITY, Outbox
from aos_gcs.mission.model import (
    Event,
    MissionControl,
    MissionSnapshot,
    NoticeRecord,
    PictureKind,
    PlanRecord,
    StepRecord,
)

NOTICES_KEPT = 200


class EventHub:
    """The mission's one subscriber on behalf of all clients: each event is converted once.

    It keeps the latest notices, so that a page that is loaded again still shows what has gone wrong.
    """

    def __init__(self, mission: MissionControl, outbox_capacity: int = DEFAULT_CAPACITY) -> None:
        self._mission = mission
        self._outbox_capacity = outbox_capacity
        self._outboxes: set[Outbox] = set()
        self._notices: deque[NoticeModel] = deque(maxlen=NOTICES_KEPT)
        self._steps: dict[int, StepModel] = {}

    async def run(self) -> None:
        """Distribute events until cancelled."""
        previous_seq: int | None = None
        with self._mission.subscribe() as events:
            async for event in events:
                lost = event.seq - previous_seq - 1 if previous_seq is not None else 0
                previous_seq = event.seq
                message = self._convert(event)
                for outbox in self._outboxes:
                    outbox.lose(lost)
                    outbox.put(message)

    @contextmanager
    def connect(self) -> Iterator[Outbox]:
        """Collect events for a client for as long as the context is entered."""
        outbox = Outbox(self._outbox_capacity)
        self._outboxes.add(outbox)
        try:
            yield outbox
        finally:
            self._outboxes.discard(outbox)

    def hello(self) -> messages.HelloMessage:
        """Return the state that a client needs before its first event."""
        return messages.HelloMessage(
            seq=1,
            schema_version=SCHEMA_VERSION,
            mission=convert.mission(self._mission.snapshot()),
            steps=self.steps(),
            notices=list(self._notices),
            pictures=self._pictures(),
        )

    def steps(self) -> list[StepModel]:
        """Return all steps so far, oldest first."""
        return [self._step(record) for record in self._mission.steps()]

    def _step(self, record: StepRecord) -> StepModel:
        """Convert a step, once: doing it for a whole mission when a client connects would block the loop."""
        if record.step not in self._steps:
            self._steps[record.step] = convert.step(record, self._mission.snapshot().origin)
        return self._steps[record.step]

    def _pictures(self) -> list[PictureModel]:
        origin = self._mission.snapshot().origin
        found = (self._mission.picture(kind) for kind in PictureKind)
        return [
            described
            for picture in found
            if picture is not None
            for described in convert.pictures([picture.kind], picture, origin)
        ]

    def _convert(self, event: Event) -> messages.EventMessage:
        """Convert an event; its number is given to it when a client's turn comes."""
        data, utc_s = event.data, event.utc_s
        if isinstance(data, MissionSnapshot):
            return messages.SnapshotMessage(seq=0, utc_s=utc_s, mission=convert.mission(data))
        if isinstance(data, StepRecord):
            return messages.StepMessage(seq=0, utc_s=utc_s, step=self._step(data))
        if isinstance(data, NoticeRecord):
            notice = convert.notice(data)
            self._notices.append(notice)
            return messages.NoticeMessage(seq=0, utc_s=utc_s, notice=notice)
        if isinstance(data, PlanRecord):
            return messages.PlanMessage(seq=0, utc_s=utc_s, operator=data.operator)
        origin = self._mission.snapshot().origin
        return messages.PicturesMessage(seq=0, utc_s=utc_s, pictures=convert.pictures(data.kinds, data, origin))
