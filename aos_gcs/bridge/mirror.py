"""The interface's side: a mission that flies in another process, as if it were in this one."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractContextManager
from typing import Any, cast

from aos_gcs.bridge.calls import BUSY, ERRORS, MAX_CALLS
from aos_gcs.bridge.messages import MAX_REQUEST_BYTES, REPORTS, pack, read_message, unpack
from aos_gcs.errors import AosError, InputDataError, LinkError, MissionError
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.events import Subscribers
from aos_gcs.mission.model.actions import Action, ActionResult, Seen
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.events import Event, EventData, EventKind, JumpRecord, NoticeRecord
from aos_gcs.mission.model.findings import Finding, FindingChange
from aos_gcs.mission.model.proposals import Proposal, ProposalRecord, ProposalUse
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord
from aos_gcs.mission.notices import notices_to_keep
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings

_GONE = "The station's flight process does not answer. Use the remote control."
_MAX_REPORT_BYTES = 2**30


class MissionMirror:
    """Implements ``MissionView`` and ``MissionCommands`` by messages; :meth:`run` takes them in.

    Before ``greeted`` it shows nothing, and only that may be waited for.
    """

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader = reader
        self._writer = writer
        self._subscribers = Subscribers()
        self._snapshot: MissionSnapshot | None = None
        self._settings: MissionSettings | None = None
        self._steps: dict[int, StepRecord] = {}
        self._pictures: dict[PictureKind, Picture] = {}
        self._is_greeted = asyncio.Event()
        self._pending: dict[int, asyncio.Future[Any]] = {}
        self._numbers = itertools.count(1)
        self._is_gone = False
        self.notices: list[NoticeRecord] = []
        """Notices so far that are kept."""
        self.seq = 0
        """Number of the latest event."""
        self.heard_at_s = 0.0
        """Time at which the mission last published its state, in real seconds of a clock that processes share."""

    async def run(self) -> None:
        """Take in messages until the flight's process is gone.

        Raises:
            MalformedMessageError: it has sent what is no message.
        """
        try:
            while (payload := await read_message(self._reader, _MAX_REPORT_BYTES)) is not None:
                self._take(*unpack(payload, REPORTS))
        finally:
            self._is_gone = True
            for waiting in self._pending.values():
                if not waiting.done():
                    waiting.set_exception(LinkError(_GONE))

    async def greeted(self) -> None:
        """Wait until the mission is known."""
        await self._is_greeted.wait()

    def say_alive(self, serves: bool) -> None:
        """Tell the flight's process that this one works, and whether it serves clients."""
        self._writer.write(pack("alive", serves))

    def tell_sharing(self, statuses: tuple[ChannelStatus, ...]) -> None:
        """Tell the flight's process the states of live sharing; only the sharing process may."""
        self._writer.write(pack("sharing", statuses))

    def tell_proposals(self, source: str, proposals: tuple[Proposal, ...], withdrawn: tuple[str, ...]) -> None:
        """Tell the flight's process what others have proposed; only the sharing process may."""
        self._writer.write(pack("proposals", source, proposals, withdrawn))

    def close(self) -> None:
        """Close the connection."""
        self._writer.close()

    # --- MissionView --------------------------------------------------------------------------------------------------

    def snapshot(self) -> MissionSnapshot:
        """Return the state that was heard last."""
        return cast("MissionSnapshot", self._snapshot)

    def steps(self) -> Sequence[StepRecord]:
        """Return all steps so far, oldest first."""
        return list(self._steps.values())

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        return self._pictures.get(kind)

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the event stream from now on."""
        return self._subscribers.subscribe()

    # --- MissionCommands ----------------------------------------------------------------------------------------------

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
        seen: Seen | None = None,
    ) -> tuple[ActionResult, ...]:
        """Carry out an operator's action; see ``MissionCommands.act``."""
        is_urgent = action is Action.HOLD
        results = await self._call("act", action, vehicle_ids, focal_height_m, operator, seen, is_urgent=is_urgent)
        return cast("tuple[ActionResult, ...]", results)

    async def override_check(
        self, vehicle_id: int, check: str, reason: str | None, *, operator: str = "", seen: Seen | None = None
    ) -> PreflightCheck:
        """Override a failed preflight check; see ``MissionCommands.override_check``."""
        return cast("PreflightCheck", await self._call("override_check", vehicle_id, check, reason, operator, seen))

    async def acknowledge(self, notice_ids: Sequence[int], *, operator: str = "") -> None:
        """Acknowledge notices on behalf of all operators; see ``MissionCommands.acknowledge``."""
        await self._call("acknowledge", tuple(notice_ids), operator)

    async def announce(self, text: str, *, operator: str = "") -> None:
        """Put on record what operators have settled among themselves; see ``MissionCommands.announce``."""
        await self._call("announce", text, operator)

    async def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        """Mark a place by hand; see ``MissionCommands.add_finding``."""
        return cast("Finding", await self._call("add_finding", position_enu_m, comment, operator))

    async def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        """Judge, comment or assign a finding; see ``MissionCommands.change_finding``."""
        return cast("Finding", await self._call("change_finding", finding_id, change, operator))

    async def decide_proposal(self, proposal_id: int, use: ProposalUse, *, operator: str = "") -> ProposalRecord:
        """Decide about a proposal of others; see ``MissionCommands.decide_proposal``."""
        return cast("ProposalRecord", await self._call("decide_proposal", proposal_id, use, operator))

    @property
    def settings(self) -> MissionSettings:
        """Settings that the mission flies by at present."""
        return cast("MissionSettings", self._settings)

    async def apply_plan(self, plan: MissionPlan, *, operator: str = "", seen: Seen | None = None) -> None:
        """Fly by another plan; see ``MissionCommands.apply_plan``."""
        await self._call("apply_plan", plan, operator, seen)

    async def _call(self, name: str, *values: object, is_urgent: bool = False) -> object:
        if self._is_gone:
            raise LinkError(_GONE)
        if len(self._pending) >= MAX_CALLS and not is_urgent:
            raise MissionError(BUSY)
        number = next(self._numbers)
        message = pack(name, number, *values)
        if len(message) > MAX_REQUEST_BYTES:
            raise InputDataError("The request is too large for the station.")
        self._pending[number] = answer = asyncio.get_running_loop().create_future()
        try:
            self._writer.write(message)
            return await answer
        finally:
            del self._pending[number]

    # --- messages of the flight ---------------------------------------------------------------------------------------

    def _take(self, name: str, values: tuple[Any, ...]) -> None:
        kind, _, rest = name.partition(" ")
        if kind == "event":
            self._take_event(EventKind(rest), *values)
        elif kind == "done":
            self._answered(values[0], values[1])
        else:
            getattr(self, f"_take_{kind}")(*values)

    def _take_welcome(
        self, at_s: float, snapshot: MissionSnapshot, settings: MissionSettings, notices: tuple[NoticeRecord, ...]
    ) -> None:
        self._settings, self.notices = settings, list(notices)
        self._steps.clear()
        self._take_state(at_s, snapshot)

    def _take_step(self, step: StepRecord) -> None:
        self._steps[step.step] = step

    def _take_picture(self, picture: Picture) -> None:
        self._pictures[picture.kind] = picture

    def _take_ready(self, seq: int) -> None:
        """Note that everything is known now; what clients were told before has gaps if it is known anew."""
        self.seq = max(self.seq, seq)
        if self._is_greeted.is_set():
            jump = JumpRecord(tuple(self.notices))
            self._subscribers.hand_out(Event(self.seq, 0.0, EventKind.JUMP, jump))
        self._is_greeted.set()

    def _take_settings(self, settings: MissionSettings) -> None:
        self._settings = settings

    def _take_state(self, at_s: float, snapshot: MissionSnapshot) -> None:
        self._snapshot, self.heard_at_s = snapshot, at_s

    def _take_refused(self, number: int, kind: str, text: str) -> None:
        self._answered(number, ERRORS.get(kind, AosError)(text))

    def _answered(self, number: int, result: object) -> None:
        waiting = self._pending.get(number)
        if waiting is None or waiting.done():
            return
        if isinstance(result, AosError):
            waiting.set_exception(result)
        else:
            waiting.set_result(result)

    def _take_event(self, kind: EventKind, seq: int, utc_s: float, data: EventData, at_s: float = 0.0) -> None:
        self.seq = max(self.seq, seq)
        if isinstance(data, MissionSnapshot):
            self._take_state(at_s, data)
        elif isinstance(data, StepRecord):
            self._take_step(data)
        elif isinstance(data, NoticeRecord):
            acknowledged = (each.notice_id for each in self.snapshot().acknowledgements)
            self.notices = notices_to_keep([*self.notices, data], acknowledged)
        self._subscribers.hand_out(Event(seq, utc_s, kind, data))
