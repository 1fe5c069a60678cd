"""A recorded mission, shown like a live one at any time of it."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import AsyncIterator, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Final

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.mission.control import ReplayState, Timeline
from aos_gcs.mission.events import EventStream
from aos_gcs.mission.model.events import Event, EventKind, JumpRecord, NoticeRecord, PicturesRecord
from aos_gcs.mission.model.findings import Finding
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord
from aos_gcs.mission.notices import notices_to_keep
from aos_gcs.ports import Clock, Severity
from aos_gcs.store.reader import EventEntry, MissionReader

TICK_S: Final = 0.2
MIN_SPEED: Final = 0.1
MAX_SPEED: Final = 50.0


class MissionReplay:
    """Implements ``MissionView`` and ``ReplayControl`` on a mission folder.

    What is large stays on the disk: a jump reads one snapshot, whatever the length of the mission.

    Args:
        reader: reader of the mission; must stay open.
        clock: clock of the replay.

    Raises:
        InputDataError: the recording holds no state to show, or is damaged.
    """

    def __init__(self, reader: MissionReader, clock: Clock) -> None:
        self._clock = clock
        self._stream = EventStream(clock)
        self._speed = 1.0
        self._load(reader)

    def _load(self, reader: MissionReader) -> None:
        """Take up a recording at its beginning, not playing; nothing changes if it cannot be shown."""
        index = reader.event_index()
        snapshots = [entry for entry in index if entry.kind is EventKind.SNAPSHOT]
        if not snapshots:
            raise InputDataError(f"{reader.folder} contains no snapshot of the mission; it ended before it began")
        kinds = (kind for kind in EventKind if kind is not EventKind.SNAPSHOT)
        events = sorted((event for kind in kinds for event in reader.events(kind)), key=lambda event: event.seq)
        self._events = list(_numbered(events))
        self._reader, self._snapshots = reader, snapshots
        self._start_utc_s = index[0].utc_s
        self._end_utc_s = self._start_utc_s + _reached_s(index[-1].utc_s - self._start_utc_s)
        self._event_times = [event.utc_s for event in self._events]
        self._snapshot_times = [entry.utc_s for entry in snapshots]
        self._shown: tuple[EventEntry, MissionSnapshot] | None = None
        self._utc_s = self._start_utc_s
        self._playing = False

    def show(self, reader: MissionReader) -> None:
        """Show another mission from its beginning; its reader must stay open, and the former one may be closed.

        Raises:
            InputDataError: the recording holds no state to show, or is damaged; the former mission is still shown.
        """
        self._load(reader)
        self._stream.publish(EventKind.JUMP, JumpRecord(()))
        self._stream.publish(EventKind.SNAPSHOT, self.snapshot())

    # --- MissionView --------------------------------------------------------------------------------------------------

    def snapshot(self) -> MissionSnapshot:
        """Return the state at the present time of the replay; before the first recorded one, that."""
        entry = self._snapshots[max(0, bisect_right(self._snapshot_times, self._utc_s) - 1)]
        if self._shown is None or self._shown[0] is not entry:
            self._shown = entry, self._snapshot_of(entry)
        return self._shown[1]

    def _snapshot_of(self, entry: EventEntry) -> MissionSnapshot:
        data = self._reader.event(entry.seq).data
        if not isinstance(data, MissionSnapshot):
            raise InputDataError(f"event {entry.seq} of {self._reader.folder} is not a snapshot")
        return data

    def steps(self) -> Sequence[StepRecord]:
        """Return all steps up to the present time, oldest first."""
        return [event.data for event in self._past() if isinstance(event.data, StepRecord)]

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if one was recorded."""
        for event in reversed(self._past()):
            data = event.data
            if isinstance(data, PicturesRecord) and kind in data.kinds:
                png = self._reader.picture(data.step, kind)
                if png is None:
                    return None
                return Picture(kind, data.step, png, data.west_m, data.south_m, data.east_m, data.north_m)
        return None

    @property
    def utc_s(self) -> float:
        """Present time in the recording."""
        return self._utc_s

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow what is replayed."""
        return self._stream.subscribe()

    # --- ReplayControl ------------------------------------------------------------------------------------------------

    def replay(self) -> ReplayState:
        """Return the position of the replay."""
        return ReplayState(
            time_s=self._utc_s - self._start_utc_s,
            duration_s=self._end_utc_s - self._start_utc_s,
            speed=self._speed,
            playing=self._playing,
        )

    def timeline(self) -> Timeline:
        """Return the timeline; a seek to the time of an entry shows it."""
        start_utc_s = self._start_utc_s
        timed = [(_reached_s(event.utc_s - start_utc_s), event.data) for event in self._events]
        return Timeline(
            start_utc_s=start_utc_s,
            phases=tuple((_reached_s(utc_s - start_utc_s), phase) for utc_s, phase in self._reader.phases()),
            steps=tuple((time_s, data.step) for time_s, data in timed if isinstance(data, StepRecord)),
            notices=tuple((time_s, data) for time_s, data in timed if isinstance(data, NoticeRecord)),
            findings=self._findings(),
        )

    def _findings(self) -> tuple[tuple[float, Finding], ...]:
        last = self._snapshot_of(self._snapshots[-1])
        # Findings count from the mission's start, a recording may begin earlier.
        began_s = self._snapshots[-1].utc_s - last.elapsed_s - self._start_utc_s if last.elapsed_s > 0.0 else 0.0
        return tuple((_reached_s(max(0.0, began_s + finding.found_at_s)), finding) for finding in last.findings)

    def seek(self, *, time_s: float | None = None, speed: float | None = None, playing: bool | None = None) -> None:
        """Go to another time, change the speed, play or stop.

        Raises:
            ConfigurationError: the speed is out of range.
            InputDataError: what was recorded at that time is damaged; the replay stays where it is.
        """
        if speed is not None:
            if not MIN_SPEED <= speed <= MAX_SPEED:
                raise ConfigurationError(f"speed must lie within {MIN_SPEED:g} and {MAX_SPEED:g}, but is {speed:g}.")
            self._speed = speed
        if time_s is not None:
            self._go_to(self._start_utc_s + time_s)
            acknowledged_ids = [each.notice_id for each in self.snapshot().acknowledgements]
            shown = notices_to_keep(self._notices(), acknowledged_ids)
            self._stream.publish(EventKind.JUMP, JumpRecord(tuple(shown)))
        if playing is not None:
            self._playing = playing
        self._stream.publish(EventKind.SNAPSHOT, self.snapshot())

    async def run(self) -> None:
        """Advance the replay until cancelled."""
        while True:
            before_s = self._clock.now_s()
            await self._clock.sleep(TICK_S)
            if self._playing:
                self._advance(self._speed * (self._clock.now_s() - before_s))

    def _go_to(self, utc_s: float) -> None:
        """Go to a time within the recording, unless the state then cannot be shown."""
        before_utc_s = self._utc_s
        self._utc_s = min(max(utc_s, self._start_utc_s), self._end_utc_s)
        try:
            self.snapshot()
        except InputDataError:
            self._utc_s = before_utc_s
            raise

    def _advance(self, duration_s: float) -> None:
        """Publish everything that happened in a span of the recording; playback stops before damaged data."""
        known = len(self._past())
        try:
            self._go_to(self._utc_s + duration_s)
        except InputDataError as error:
            self._playing = False
            number = max((data.notice_id for data in self._notices()), default=0) + 1
            text, elapsed_s = f"Replay stopped: {error}", self.snapshot().elapsed_s
            notice = NoticeRecord(Severity.CRITICAL, text, None, elapsed_s, number, self._utc_s)
            self._stream.publish(EventKind.NOTICE, notice)
        else:
            self._playing = self._utc_s < self._end_utc_s
        for event in self._past()[known:]:
            self._stream.publish(event.kind, event.data)
        self._stream.publish(EventKind.SNAPSHOT, self.snapshot())

    def _past(self) -> list[Event]:
        return self._events[: bisect_right(self._event_times, self._utc_s)]

    def _notices(self) -> list[NoticeRecord]:
        return [event.data for event in self._past() if isinstance(event.data, NoticeRecord)]


def _reached_s(time_s: float) -> float:
    """Return the first whole tenth of a second at which something has happened: clients know no finer moments."""
    return math.ceil(time_s * 10.0) / 10.0


def _numbered(events: Iterable[Event]) -> Iterator[Event]:
    """Add numbers and times to the notices of older records, which lack them."""
    count = 0
    for event in events:
        if isinstance(event.data, NoticeRecord):
            count = event.data.notice_id or count + 1
            utc_s = event.data.utc_s or event.utc_s
            yield replace(event, data=replace(event.data, notice_id=count, utc_s=utc_s))
        else:
            yield event
