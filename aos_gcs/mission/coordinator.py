"""The coordinator: the state machine that runs a mission through its phases."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping

from aos_gcs.errors import AosError
from aos_gcs.mission.actions import ActionHandler
from aos_gcs.mission.auto_start import AutoStart
from aos_gcs.mission.command_order import MAX_AGE_S, CommandOrder
from aos_gcs.mission.commands import LiveCommands
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.landing.afterwards import is_any_heard_flying, may_any_hover_unheard, send_all_home
from aos_gcs.mission.fleet.landing.return_heights import ReturnHeights
from aos_gcs.mission.fleet.monitor import Monitor
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.standing_hold import StandingHold
from aos_gcs.mission.fleet.vehicle_tasks import VehicleTasks
from aos_gcs.mission.former_flight import FormerFlight
from aos_gcs.mission.handler_watch import HandlerWatch
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal, Recorder
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.next_sortie import NextSortie, next_sortie
from aos_gcs.mission.outcome_record import outcome_record
from aos_gcs.mission.phases import ENDING, ON_GROUND, PHASE_NAMES, check_transition
from aos_gcs.mission.preflight.inspection import Inspector
from aos_gcs.mission.relaying import keep_relay
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.ground.mapping import GroundMapping, GroundPlace
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.sortie import Sortie, TakenUp
from aos_gcs.mission.suspending import SuspensionState
from aos_gcs.mission.take_up import TakeUp
from aos_gcs.mission.views import LiveView
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Clock, Fleet, Severity, ThreadWorker, Worker

_STAY_POLL_S = 0.5


class Coordinator:
    """One mission, from the first heartbeat to the last landing.

    One handler, that of the present phase, runs at a time, beside the monitor. An operator's action may end it early
    and choose what follows; every handler looks at the vehicles afresh, so it can be entered again.
    """

    def __init__(
        self,
        mission_id: str,
        settings: MissionSettings,
        *,
        fleet: Fleet,
        clock: Clock,
        journal: Journal,
        recorder: Recorder,
        loop_monitor: LoopMonitor,
        max_command_age_s: float = MAX_AGE_S,
        imaging: Worker | None = None,
        former: FormerFlight | None = None,
        unrestored: Mapping[int, Mapping[str, float]] | None = None,
        following: NextSortie | None = None,
        ground: GroundPlace | None = None,
        pictures: bool = True,
    ) -> None:
        """Prepare the mission.

        ``imaging`` analyses its images, None: in threads of this process; ``former`` is a flight to take up;
        ``unrestored`` are the return settings that vehicles had before a mission that did not restore them, by id;
        ``following`` is what the former sortie has left, None for the first one; ``ground``: where the map of searched
        ground is kept, None: nowhere; ``pictures``: whether to render what operators look at.
        """
        self.auto_start = AutoStart(journal, is_on=settings.auto_start)
        self._context = MissionContext(
            clock=clock,
            roster=Roster(fleet, clock),
            journal=journal,
            recorder=recorder,
            loop_monitor=loop_monitor,
            auto_start=self.auto_start,
            order=CommandOrder(mission_id, asyncio.get_running_loop().time, max_command_age_s),
            suspension=SuspensionState(),
            imaging=imaging or ThreadWorker(),
        )
        self._gallery = Gallery(journal, recorder, self._context.imaging, is_open=pictures)
        self._findings = Findings(() if following is None else following.findings)
        self._ground = GroundMapping(
            ground,
            self._context,
            self._gallery,
            settings=lambda: self.sortie.context.settings,
            ground=lambda: self.sortie.context.bounds.ground,
        )
        self._mission_id = mission_id
        self._following = following
        self._is_renewed = asyncio.Event()
        self._vehicle_tasks = VehicleTasks(lambda: self.sortie.context)
        self._return_heights = ReturnHeights(self._context, settings, unrestored)
        self._inspector = Inspector(self._context, settings, self._return_heights, lambda: self.sortie.context)
        self.sortie = self._make_sortie(settings, None)
        standing_hold = StandingHold()
        self._monitor = Monitor(
            lambda: self.sortie.return_and_land, self.publish_snapshot, self.end_without_vehicles, standing_hold
        )
        self.phase = Phase.CONNECT
        self._outcome = Outcome.OPEN
        self._redirect: Phase | None = None
        self._activity: asyncio.Future[Phase] | None = None
        self._take_up = TakeUp(self._context, self, former)
        self._handler_watch = HandlerWatch()
        loop_monitor.depend_on(self._handler_watch.is_alive)
        self.view = LiveView(mission_id, self._context, self, self._gallery, self._findings, ground=self._ground)
        actions = ActionHandler(self._context, self._vehicle_tasks, self, standing_hold)
        self.commands = LiveCommands(self._context, self, actions, self.view, self._findings)

    def _make_sortie(
        self, settings: MissionSettings, focus_override_m: float | None, taken_up: TakenUp | None = None
    ) -> Sortie:
        return Sortie(
            self._context,
            settings,
            vehicle_tasks=self._vehicle_tasks,
            inspector=self._inspector,
            gallery=self._gallery,
            findings=self._findings,
            ground=self._ground,
            left_for_later=() if self._following is None else self._following.left_for_later,
            focus_override_m=focus_override_m,
            taken_up=taken_up,
        )

    @property
    def outcome(self) -> Outcome:
        """Result of the mission; in flight, whether a possible person was found that operators have not rejected."""
        if self._outcome is not Outcome.OPEN:
            return self._outcome
        if self._findings.persons():
            return Outcome.FOUND
        return Outcome.NOT_FOUND if self.phase is Phase.DONE else Outcome.OPEN

    @property
    def suspension(self) -> Suspension:
        """Why no steps are made at present."""
        return self._context.suspension.present

    @property
    def min_separation_m(self) -> float | None:
        """The smallest 3-D distance measured between two vehicles in the air so far."""
        return self._monitor.min_separation_m

    def publish_snapshot(self) -> None:
        """Put the present state on the event stream."""
        self.view.publish()

    # --- what operators do to the flow --------------------------------------------------------------------------------

    @property
    def heading(self) -> Phase:
        """The phase that the mission is in, or changes to by an action just taken."""
        return self.phase if self._redirect is None else self._redirect

    def redirect(self, phase: Phase) -> None:
        """End the present handler and go on with ``phase``; a suspension ends."""
        check_transition(self.heading, phase)
        self._redirect = phase
        self.resume()
        self._interrupt()

    def suspend(self, suspension: Suspension) -> None:
        """Make no further step. A hold ends the present handler at once, a pause lets the step in hand finish."""
        self._context.suspension.begin(suspension)
        if suspension is Suspension.HELD:
            self._interrupt()

    def resume(self) -> None:
        """Go on where the mission was suspended."""
        self._context.suspension.end()

    def abort(self) -> None:
        """Note that an operator has aborted the mission, whatever was found."""
        self._outcome = Outcome.ABORTED

    def follow_plan(self, settings: MissionSettings) -> None:
        """Fly by other settings: a new sortie begins with connecting."""
        self.sortie = self._make_sortie(settings, self.sortie.vision.focus_override_m)
        self.redirect(Phase.CONNECT)

    def go_on_held(self, settings: MissionSettings, taken_up: TakenUp) -> None:
        """Go on with a flight in the air by these settings, held."""
        self.sortie = self._make_sortie(settings, None, taken_up)
        # Resumed, all fly straight up or down into their layers first.
        self.redirect(Phase.TAKEOFF)
        self.suspend(Suspension.HELD)
        self._ground.take_up()

    def begin_new_sortie(self) -> None:
        """Make room for another sortie: ``stay`` ends."""
        self._is_renewed.set()

    def end_without_vehicles(self) -> None:
        """End the mission at once: no vehicle is left to be flown."""
        if self.phase is Phase.DONE:
            return
        self._outcome = Outcome.FAILED
        self._report_failure("All vehicles are lost: the mission is over. Their own failsafes fly them.")
        self._redirect = Phase.DONE
        self.resume()
        self._interrupt()

    def _interrupt(self) -> None:
        if self._activity is not None:
            self._activity.cancel()

    # --- the flow -----------------------------------------------------------------------------------------------------

    async def run(self) -> Outcome:
        """Run the mission to its end and return how it ended. Cancelled in flight, it first sends all vehicles home."""
        if (following := self._following) is not None:
            self._context.journal.notice(Severity.INFO, f"Sortie {following.number}. {following.text}")
        try:
            async with asyncio.TaskGroup() as group:
                helpers = (
                    group.create_task(self._vehicle_tasks.run()),
                    group.create_task(self._inspector.run()),
                    group.create_task(self._monitor.run()),
                    group.create_task(self._context.loop_monitor.run(self._context.journal.note_stall)),
                    group.create_task(self._handler_watch.run(self._end_hung_handler)),
                    group.create_task(self._take_up.run()),
                    group.create_task(self._ground.run()),
                    group.create_task(keep_relay(self, self._context.clock)),
                )
                while self.phase is not Phase.DONE:
                    if self.suspension is Suspension.PAUSED:
                        # The pause may have come between two phases of a look, while others scan on.
                        await self.sortie.search.rest()
                    await self._context.suspension.until_over()
                    self._enter(await self._run_handler())
                for helper in helpers:
                    helper.cancel()
        except Exception as error:
            self._report_failure(f"Internal error, all vehicles return: {error!r}")
            self._settle(Outcome.FAILED)
            raise
        finally:
            await self._leave()
        return self.outcome

    async def stay(self, *, until_landed: bool = False) -> NextSortie | None:
        """Go on after the end: our heartbeat is sent, and what still flies is monitored and can be brought down.

        Args:
            until_landed: return when no vehicle flies any more, as far as is known; else it goes on until cancelled.

        Returns:
            What the sortie that an operator has asked for begins with; None if nobody has.
        """
        context = self._context
        async with asyncio.TaskGroup() as group:
            pulse = group.create_task(context.loop_monitor.run(context.journal.note_stall))
            while self.may_any_fly if until_landed else self.is_any_flying or not self._is_renewed.is_set():
                if self.is_any_flying:
                    await self._monitor_until_landed()
                await context.clock.sleep(_STAY_POLL_S)
            pulse.cancel()
        return self._next_sortie() if self._is_renewed.is_set() else None

    def _next_sortie(self) -> NextSortie:
        frame, settings = self._context.roster.frame, self.sortie.context.settings
        origin = None if frame is None else frame.origin
        found, former, decider = self._findings.all(), self._following, self.sortie.search.decider
        return next_sortie(self._mission_id, settings, origin, decider, findings=found, former=former)

    @property
    def is_any_flying(self) -> bool:
        """Whether a vehicle that is heard flies."""
        return is_any_heard_flying(self._context.roster, self.sortie.context.settings.deadlines.lost_s)

    @property
    def may_any_fly(self) -> bool:
        """Whether a vehicle that is heard flies, or one that is lost may hover: it can be heard again."""
        return self.is_any_flying or may_any_hover_unheard(self._context.roster)

    async def _monitor_until_landed(self) -> None:
        async with asyncio.TaskGroup() as group:
            helpers = (group.create_task(self._vehicle_tasks.run()), group.create_task(self._monitor.run()))
            while self.is_any_flying:
                await self._context.clock.sleep(_STAY_POLL_S)
            for helper in helpers:
                helper.cancel()
        self.publish_snapshot()

    async def _run_handler(self) -> Phase:
        """Run the present phase's handler once, or until an operator ends it, and return what follows."""
        result: Phase | BaseException = self.phase
        if self._redirect is None:
            self._activity = self._handler_watch.start(self.sortie.handlers[self.phase]())
            # Cancelling us cancels the activity and waits for it; its own cancellation comes back as a value.
            (result,) = await asyncio.gather(self._activity, return_exceptions=True)
            self._activity = None
            self._handler_watch.rest()
        redirect, self._redirect = self._redirect, None
        if redirect is not None:
            return redirect
        if isinstance(result, asyncio.CancelledError):
            return self.phase
        if isinstance(result, AosError):
            return self._fail(str(result))
        if isinstance(result, BaseException):
            raise result
        return result

    def _end_hung_handler(self) -> None:
        """Go on with the way down where a handler hangs; if it does not end, the heartbeat stops."""
        if self.phase in ON_GROUND or self._redirect is not None:
            return
        self._report_failure(f"{PHASE_NAMES[self.phase]} makes no progress: all vehicles return.")
        self._settle(Outcome.FAILED)
        self._redirect = Phase.LAND if self.phase in ENDING else Phase.RETURN
        self._interrupt()

    def _enter(self, phase: Phase) -> None:
        if phase is self.phase:
            return
        if phase in ENDING and self.phase not in ENDING:
            self.sortie.search.decider.tell_end()
        self.phase = phase
        if phase is Phase.ARM:
            self._context.journal.start_timing()
        if phase is Phase.DONE:
            self._settle(Outcome.NOT_FOUND)
            self._monitor.end()
        self._context.journal.notice(Severity.INFO, PHASE_NAMES[phase])

    def _settle(self, outcome: Outcome) -> None:
        """Set how the mission has ended, unless that is known already."""
        if self.outcome is Outcome.OPEN:
            self._outcome = outcome

    def _fail(self, text: str) -> Phase:
        """Report the failure and return the phase that ends it: none on the ground, the return from the air."""
        self._report_failure(text)
        self._settle(Outcome.FAILED)
        if self.phase in ON_GROUND or not self._context.roster.airborne():
            return Phase.DONE
        return Phase.LAND if self.phase in ENDING else Phase.RETURN

    def _report_failure(self, text: str) -> None:
        self._context.journal.set_message(text)
        self._context.journal.notice(Severity.CRITICAL, text)

    async def _leave(self) -> None:
        """Send home the vehicles that still fly under our command, and close the record whatever comes of it."""
        try:
            if self.phase is not Phase.DONE:
                await send_all_home(self.sortie.context)
            await self._return_heights.restore()
        finally:
            await self._ground.finish()
            await self._close_record()

    async def _close_record(self) -> None:
        context = self._context
        self._settle(Outcome.ABORTED)
        self.publish_snapshot()
        decider, persons = self.sortie.search.decider, self._findings.persons()
        record = outcome_record(context, self.outcome, decider, persons, min_separation_m=self.min_separation_m)
        async with context.journal.with_disk_timeout("the outcome"):
            await context.recorder.record_outcome(record)
            await context.recorder.flush()
