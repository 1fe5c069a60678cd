"""Hands the mission's events and state to all connected clients."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import Protocol

from aos_gcs.api.access.control import Control
from aos_gcs.api.convert.mission import MissionConverter, control
from aos_gcs.api.convert.notices import notice as notice_model
from aos_gcs.api.convert.seen import seen_text
from aos_gcs.api.convert.steps import pictures as picture_models
from aos_gcs.api.convert.steps import step as step_model
from aos_gcs.api.convert.steps import step_figures
from aos_gcs.api.events.outbox import Outbox
from aos_gcs.api.events.state import MissionState
from aos_gcs.api.models import messages
from aos_gcs.api.models.messages import SCHEMA_VERSION
from aos_gcs.api.models.mission import MissionModel
from aos_gcs.api.models.notices import NoticeModel
from aos_gcs.api.models.service import CapabilitiesModel
from aos_gcs.api.models.steps import PictureModel, StepFiguresModel, StepModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.control import MissionView, ReplayControl
from aos_gcs.mission.model.actions import Seen
from aos_gcs.mission.model.events import Event, JumpRecord, NoticeRecord, PicturesRecord, PlanRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind, StepRecord
from aos_gcs.mission.notices import notices_to_keep

EVENTS_KEPT = 1024
"""Events kept, as texts, for clients that reconnect: minutes of a mission."""
STEPS_PER_ANSWER = 500
"""Steps that one request reads: to convert those of hours at once would block the loop."""
GREETING_KEPT_S = 0.25
"""Time for which many clients that connect at once share one greeting."""
NO_CAPABILITIES = CapabilitiesModel(
    planning=False, viewer=False, findings=False, operation=False, survey=False, handover=False, wall=False, video=False
)


def loop_time_s() -> float:
    """Return the running event loop's own time, which never jumps and runs as fast as real time."""
    return asyncio.get_running_loop().time()


class Upstream(Protocol):
    """Another process, in which the mission flies: what it had told before this one listened."""

    @property
    def seq(self) -> int:
        """Number of its latest event; clients may know all until then from a former process."""
        ...

    @property
    def notices(self) -> Sequence[NoticeRecord]:
        """Notices so far."""
        ...

    @property
    def heard_at_s(self) -> float:
        """Time at which the mission last published its state, by the clock of ``now_s``."""
        ...


class EventHub:
    """The mission's one subscriber on behalf of all clients: everything is converted once for all of them.

    It keeps the notices that matter, so that a reloaded page still shows them, the figures of all steps, and the latest
    events, so that a client that reconnects misses none.

    Args:
        mission: mission to follow.
        replay: replay of the mission; None for a live one.
        capabilities: capabilities that the service offers to clients.
        now_s: clock in real seconds, for the age of the mission's last sign of life.
        upstream: process in which the mission flies; None: this one.
    """

    def __init__(
        self,
        mission: MissionView,
        replay: ReplayControl | None = None,
        capabilities: CapabilitiesModel = NO_CAPABILITIES,
        now_s: Callable[[], float] = loop_time_s,
        upstream: Upstream | None = None,
    ) -> None:
        self._mission = mission
        self._upstream = upstream
        self._replay = replay
        self._outboxes: set[Outbox] = set()
        self._state = MissionState()
        self._notices: list[NoticeModel] = []
        self._acknowledged_ids: frozenset[int] = frozenset()
        self._events: deque[tuple[int, str]] = deque(maxlen=EVENTS_KEPT)
        """Number and text of the latest events."""
        self._figures: dict[int, StepFiguresModel] = {}
        self._announced: dict[PictureKind, int] = {}
        """Number of the event that announced the latest picture of a kind."""
        self._seq = 0
        self._capabilities = capabilities
        self._now_s = now_s
        self._heard_at_s: float | None = None
        self._converter = MissionConverter(None)
        self._known_origin: GeodeticPosition | None = None
        self._greeting: tuple[float, int, int, str] | None = None
        """Time, revision of the state, number of the latest event and text of the latest greeting."""
        self._control: Control | None = None
        self._shown: MissionSnapshot | None = None
        """The snapshot that was published last; clients are shown it, or greeted with a later one."""

    def show_control(self, control: Control) -> None:
        """Show from now on who has control."""
        self._control = control

    def refresh(self) -> None:
        """Show changes beside the mission now, and not with its next state."""
        if self._outboxes:
            self._take_state(self.mission(), self._state.utc_s)

    async def run(self) -> None:
        """Distribute events until cancelled."""
        previous_seq: int | None = None
        with self._mission.subscribe() as events:
            self._hear()
            if self._upstream is not None:
                previous_seq = self._seq = self._upstream.seq
                self._notices = list(map(notice_model, self._upstream.notices))
            async for event in events:
                if previous_seq is not None and event.seq > previous_seq + 1:
                    # Events were lost before they arrived here. A skipped number makes clients request the whole state.
                    self._seq += 1
                previous_seq = event.seq
                self._distribute(event)

    @contextmanager
    def connect(self) -> Iterator[Outbox]:
        """Collect messages for a client for as long as the context is entered; the first one is ``hello``."""
        outbox = Outbox(self._state, self._hello_text, self.mission_age_s, self.shown)
        self._outboxes.add(outbox)
        try:
            yield outbox
        finally:
            self._outboxes.discard(outbox)

    def hello(self) -> messages.HelloMessage:
        """Return the state that a client needs before its first event."""
        records = self._mission.steps()
        return messages.HelloMessage(
            seq=self._seq,
            schema_version=SCHEMA_VERSION,
            mission_age_s=self.mission_age_s(),
            seen=self.seen(),
            capabilities=self._capabilities,
            mission=self.mission(),
            steps=[self._figures_of(record) for record in records],
            latest_step=self._step(records[-1]) if records else None,
            notices=list(self._notices),
            pictures=self._pictures(),
        )

    def mission(self) -> MissionModel:
        """Return the mission at this moment."""
        return self._model(self._mission.snapshot())

    def seen(self) -> str:
        """Return the name of the mission's state at this moment, by which a client commands that has just read it."""
        return self._name(self._mission.snapshot())

    def shown(self) -> str:
        """Return the name of the state that followers of the events are shown."""
        return self.seen() if self._shown is None else self._name(self._shown)

    def _name(self, snapshot: MissionSnapshot) -> str:
        # A mission that has ended reports nothing more, and its state stays true.
        is_lasting = snapshot.phase is Phase.DONE or self._heard_at_s is None
        at_s = self._heard_at_s if self._heard_at_s is not None and not is_lasting else self._now_s()
        return seen_text(Seen(snapshot.mission_id, snapshot.command_count, at_s))

    def mission_age_s(self) -> float:
        """Return the real seconds since the mission last published its state, which it does several times per second.

        It does so by a task of its own: when that hangs or has failed, this server may still answer.
        """
        if self._replay is not None or self._heard_at_s is None:
            return 0.0
        return round(self._now_s() - self._heard_at_s, 1)

    def steps(self, after: int) -> list[StepModel]:
        """Return the first ``STEPS_PER_ANSWER`` steps after a number, oldest first."""
        later = (record for record in self._mission.steps() if record.step > after)
        return [self._step(record) for record in islice(later, STEPS_PER_ANSWER)]

    def missed_text(self, after: int) -> str:
        """Return the events after a number, as JSON of a ``MissedEventsModel``.

        Where some of them are no longer kept it has the whole state.
        """
        found = [text for seq, text in self._events if seq > after]
        complete = len(found) == self._seq - after
        hello = "null" if complete else self.hello().model_dump_json()
        mission_id = json.dumps(self._mission.snapshot().mission_id)
        events = ",".join(found) if complete else ""
        return f'{{"mission_id":{mission_id},"seq":{self._seq},"events":[{events}],"hello":{hello}}}'

    def _hello_text(self) -> tuple[int, str]:
        now_s = self._now_s()
        if self._greeting is not None:
            at_s, revision, seq, text = self._greeting
            if now_s - at_s < GREETING_KEPT_S and (revision, seq) == (self._state.revision, self._seq):
                return seq, text
        hello = self.hello()
        # The changes that follow must start from exactly what this message says.
        self._take_state(hello.mission, 0.0)
        text = hello.model_dump_json()
        self._greeting = now_s, self._state.revision, hello.seq, text
        return hello.seq, text

    def _take_state(self, mission: MissionModel, utc_s: float) -> None:
        if self._state.update(mission, utc_s):
            for outbox in self._outboxes:
                outbox.nudge()

    def _distribute(self, event: Event) -> None:
        if isinstance(event.data, MissionSnapshot):
            self._hear()
            self._acknowledged_ids = frozenset(each.notice_id for each in event.data.acknowledgements)
            self._shown = event.data
            if self._outboxes:
                self._take_state(self._model(event.data), event.utc_s)
            return
        self._seq += 1
        if isinstance(event.data, JumpRecord):
            self._start_over(event.data)
            return
        message = self._convert(event)
        text = message.model_dump_json()
        self._events.append((message.seq, text))
        for outbox in self._outboxes:
            outbox.put(message.seq, text)

    def _hear(self) -> None:
        self._heard_at_s = self._now_s() if self._upstream is None else self._upstream.heard_at_s

    def _start_over(self, jump: JumpRecord) -> None:
        self._notices = list(map(notice_model, jump.notices))
        self._events.clear()
        # A replay may show another mission now.
        self._figures.clear()
        self._known_origin = None
        for outbox in self._outboxes:
            outbox.start_over()

    def _model(self, snapshot: MissionSnapshot) -> MissionModel:
        if self._converter.origin != snapshot.origin:
            self._converter = MissionConverter(snapshot.origin)
        replay = self._replay.replay() if self._replay else None
        shown = None if self._control is None else control(self._control.state())
        return self._converter.convert(snapshot, replay, shown, is_survey=self._capabilities.survey)

    def _figures_of(self, record: StepRecord) -> StepFiguresModel:
        """Convert a step's figures, once: doing it for a whole mission when a client connects would block the loop."""
        if record.step not in self._figures:
            self._figures[record.step] = step_figures(record)
        return self._figures[record.step]

    def _step(self, record: StepRecord) -> StepModel:
        return step_model(record, self._origin())

    def _origin(self) -> GeodeticPosition | None:
        """Return the mission's origin, which never moves: a snapshot of a large fleet just for it would be costly."""
        if self._known_origin is None:
            self._known_origin = self._mission.snapshot().origin
        return self._known_origin

    def _pictures(self) -> list[PictureModel]:
        origin = self._origin()
        found = (self._mission.picture(kind) for kind in PictureKind)
        return [
            described
            for picture in found
            if picture is not None
            for described in picture_models([picture.kind], picture, origin, self._announced.get(picture.kind, 0))
        ]

    def _convert(self, event: Event) -> messages.EventMessage:
        data, utc_s, seq = event.data, event.utc_s, self._seq
        if isinstance(data, StepRecord):
            return messages.StepMessage(seq=seq, utc_s=utc_s, step=self._step(data))
        if isinstance(data, NoticeRecord):
            notice = notice_model(data)
            self._notices = notices_to_keep([*self._notices, notice], self._acknowledged_ids)
            return messages.NoticeMessage(seq=seq, utc_s=utc_s, notice=notice)
        if isinstance(data, PlanRecord):
            return messages.PlanMessage(seq=seq, utc_s=utc_s, operator=data.operator)
        if isinstance(data, PicturesRecord):
            self._announced |= dict.fromkeys(data.kinds, seq)
            described = picture_models(data.kinds, data, self._origin(), seq)
            return messages.PicturesMessage(seq=seq, utc_s=utc_s, pictures=described)
        raise TypeError(f"{event.kind} is not an event for clients")
