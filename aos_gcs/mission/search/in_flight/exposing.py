"""Frames that vehicles expose in flight: each camera at its own pace, and rounds of what has come.

No camera waits for another: a frame that comes late is part of a later round, with the pose of its own exposure.
"""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import AsyncIterator, Coroutine, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from aos_gcs.errors import CaptureError, NoIntervalError
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet import motion
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.handler_watch import sign_of_life, unwatched
from aos_gcs.mission.search.frames.sampling import Sample, Sampler, without
from aos_gcs.mission.search.in_flight.camera_pace import CameraPace
from aos_gcs.ports import Capture, Severity

KEPT = 2
"""Frames of one vehicle that may wait for analysis. Policy: the oldest is dropped, and counted."""
BLIND_S = 3.0
"""Time without any frame after which a sweep must not go on, where the rate is not lower still."""
_BLIND_PERIODS = 2.0
MAX_MOTION_M = 0.5
"""Greatest standard deviation of a place of exposure by the time of it alone: frames that err by more disagree about
the ground below them."""
LATE_S = 6.0
"""Flight at the speed along the legs after which an image that comes is of another place than where its vehicle is."""
STALL_S = 1.0
"""Time without a look at the clock after which this station has stood still."""
_POLL_S = 0.05
_DRAIN_S = 2.0
"""Time for which frames on their way are awaited when a sweep is over: a camera takes one at a time, and one that takes
images by itself has to be stopped."""
_START_S = 2.0
"""Time in which a camera has to begin to take images by itself."""
_KEPT_SPEEDS = 4


def blind_s(rate_hz: float) -> float:
    """Return the time without any frame after which a sweep must not go on, at a rate of frames."""
    return max(BLIND_S, _BLIND_PERIODS / rate_hz)


@dataclass(frozen=True, slots=True, eq=False)
class _Exposed:
    capture: Capture
    speed_mps: float
    come_at_s: float


class Exposures:
    """Exposes the vehicles of the swarm in flight, at most at the rate.

    Cameras that can take images by themselves do so; of the others, each is asked again when its image has come. Made
    by :func:`exposing`.

    Args:
        context: context of the flight.
        sampler: places captures above the shared datum, and knows whose position is not known.
        pace: knows which cameras take images by themselves.
        group: owns the tasks, one per vehicle.
    """

    def __init__(self, context: FlightContext, sampler: Sampler, pace: CameraPace, group: asyncio.TaskGroup) -> None:
        self._context = context
        self._sampler = sampler
        self._pace = pace
        self._period_s = 1.0 / context.settings.imaging.rate_hz
        self._group = group
        self._tasks: dict[int, asyncio.Task[None]] = {}
        self._waiting: dict[int, deque[_Exposed]] = {}
        self._failures: dict[int, str] = {}
        """Reason why a vehicle has delivered nothing since the round before."""
        self._last_at_s: dict[int, float] = {}
        """Time at which each vehicle's latest frame came, or its exposures began."""
        self._silent: dict[int, int] = {}
        """Rounds without each vehicle that has been named."""
        self._exposed: set[int] = set()
        """Vehicles whose requested image is on its way."""
        self._is_over = False
        self.dropped = 0
        """Frames that were not analysed because later ones had come."""

    def follow(self, swarm: Sequence[Member]) -> None:
        """Expose these vehicles from now on, and no others."""
        members = {member.vehicle_id: member for member in swarm}
        for vehicle_id in self._tasks.keys() - members.keys():
            self._tasks.pop(vehicle_id).cancel()
            self._waiting.pop(vehicle_id, None)
            self._failures.pop(vehicle_id, None)
        for vehicle_id in members.keys() - self._tasks.keys():
            self._waiting[vehicle_id] = deque(maxlen=KEPT)
            self._last_at_s[vehicle_id] = self._context.clock.now_s()
            self._pace.begin(vehicle_id, self._context.clock.now_s())
            self._tasks[vehicle_id] = self._group.create_task(self._expose(members[vehicle_id]))

    def start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Do work beside the exposures, for as long as these may go on."""
        return self._group.create_task(work, context=unwatched())

    async def round(self) -> Sample | None:
        """Return the oldest frame of each vehicle, once all have one or the first has waited for one period.

        None where none has come for :attr:`blind_s`. Vehicles whose frames failed or stay away are missing in it.
        """
        clock, begin_s = self._context.clock, self._context.clock.now_s()
        while True:
            sign_of_life()
            first_s = min((queue[0].come_at_s for queue in self._waiting.values() if queue), default=math.inf)
            if all(self._waiting.values()) or clock.now_s() - first_s >= self._period_s:
                return self._take()
            if math.isinf(first_s) and clock.now_s() - begin_s >= self.blind_s:
                return None
            await clock.sleep(_POLL_S)

    @property
    def blind_s(self) -> float:
        """Time without any frame after which a sweep must not go on."""
        return blind_s(self._context.settings.imaging.rate_hz)

    @property
    def trouble(self) -> str:
        """Reason why a vehicle's latest frame did not come, in words."""
        return next((f"vehicle {key}: {reason}" for key, reason in sorted(self._failures.items())), "no image yet")

    async def finish(self) -> None:
        """Expose no more, and wait for what is on its way, which nobody needs any more."""
        self._is_over = True
        for vehicle_id, task in self._tasks.items():
            if vehicle_id not in self._exposed:
                task.cancel()
        if self._tasks:
            sign_of_life(_DRAIN_S)
            await asyncio.wait(self._tasks.values(), timeout=_DRAIN_S / self._context.clock.speed)
        self.follow(())

    def _take(self) -> Sample:
        taken = {vehicle_id: queue.popleft() for vehicle_id, queue in self._waiting.items() if queue}
        now_s, missing = self._context.clock.now_s(), dict[int, str]()
        for vehicle_id in self._waiting.keys() - taken.keys():
            silent_s = now_s - self._last_at_s[vehicle_id]
            if vehicle_id in self._failures or silent_s >= BLIND_S:
                missing[vehicle_id] = self._failures.pop(vehicle_id, f"no image for {silent_s:.0f} s")
        return Sample(
            captures=tuple(one.capture for one in taken.values()),
            missing=missing,
            speeds_mps={vehicle_id: one.speed_mps for vehicle_id, one in taken.items()},
        )

    def leave_out(self, step: int, taken: Sample, reasons: Mapping[int, str]) -> Sample:  # noqa: ARG002
        """Return a round without the frames of some vehicles.

        Reports a vehicle once when its frames stay away, or cannot be used, and once when they come again.
        """
        notice, used = self._context.journal.notice, without(taken, reasons)
        for vehicle_id, reason in used.missing.items():
            if vehicle_id not in self._silent:
                notice(Severity.WARNING, f"the line flies on without its frames: {reason}", vehicle_id)
            self._silent[vehicle_id] = self._silent.get(vehicle_id, 0) + 1
        for capture in used.captures:
            if count := self._silent.pop(capture.vehicle_id, 0):
                notice(Severity.INFO, f"frames received again. Missing: {count}", capture.vehicle_id)
        return used

    async def watch_station(self) -> None:
        """Keep time in which this station stood still from counting against cameras."""
        clock = self._context.clock
        while True:
            begin_s = clock.now_s()
            await clock.sleep(_POLL_S)
            if clock.now_s() - begin_s > STALL_S:
                self._pace.forgive(clock.now_s())

    @property
    def is_behind(self) -> bool:
        """Whether a vehicle's frames wait for analysis while later ones have come."""
        return any(len(queue) == KEPT for queue in self._waiting.values())

    async def _expose(self, member: Member) -> None:
        while not self._is_over:
            if self._takes_interval(member):
                await self._take_interval(member)
            else:
                await self._take_requested(member)

    def _takes_interval(self, member: Member) -> bool:
        return self._pace.takes_interval(member.vehicle_id, self._context.clock.now_s())

    async def _take_interval(self, member: Member) -> None:
        """Have the camera take images by itself, and return when it does not, or no longer."""
        clock, settings = self._context.clock, self._context.settings
        speeds_mps = deque([motion.speed_mps(member)], maxlen=_KEPT_SPEEDS)
        try:
            async with member.vehicle.interval(self._period_s, clock.now_s() + _START_S) as images:
                while self._takes_interval(member):
                    try:
                        capture = await images.next(clock.now_s() + settings.deadlines.capture_s)
                        self._pace.note_image(member.vehicle_id, clock.now_s())
                        self._check_placed(member)
                        # It was exposed a while ago, at a speed that has passed.
                        speeds_mps.append(motion.speed_mps(member))
                        self._keep(self._checked(member, capture, max(speeds_mps)))
                    except NoIntervalError:
                        raise
                    except CaptureError as error:
                        self._failures[member.vehicle_id] = str(error)
                        await clock.sleep(_POLL_S)
        except NoIntervalError as error:
            self._pace.refuse_interval(member.vehicle_id, clock.now_s(), str(error), may_pass=error.may_pass)
        except CaptureError as error:
            self._failures[member.vehicle_id] = str(error)
            self._pace.put_off_interval(member.vehicle_id, clock.now_s())

    async def _take_requested(self, member: Member) -> None:
        """Request one image after the other, and return when the camera is to take them by itself."""
        clock = self._context.clock
        while not self._takes_interval(member):
            begin_s = clock.now_s()
            self._exposed.add(member.vehicle_id)
            try:
                self._keep(await self._capture(member))
            except CaptureError as error:
                self._failures[member.vehicle_id] = str(error)
            finally:
                self._exposed.discard(member.vehicle_id)
            if self._is_over:
                return
            await clock.sleep(max(0.0, begin_s + self._period_s - clock.now_s()))

    async def _capture(self, member: Member) -> _Exposed:
        """Expose one frame.

        Raises:
            CaptureError: it did not come, or its pose cannot be trusted.
        """
        self._check_placed(member)
        speed_mps = motion.speed_mps(member)
        deadline_s = self._context.clock.now_s() + self._context.settings.deadlines.capture_s
        capture = await member.vehicle.capture(deadline_s)
        self._pace.note_image(member.vehicle_id, self._context.clock.now_s())
        return self._checked(member, capture, speed_mps)

    def _check_placed(self, member: Member) -> None:
        if (refusal := self._sampler.why_not_placed(member)) is not None:
            raise CaptureError(refusal.text)

    def _checked(self, member: Member, capture: Capture, speed_mps: float) -> _Exposed:
        """Return a frame that was exposed at a speed, placed above the datum.

        Raises:
            CaptureError: its pose cannot be trusted.
        """
        settings = self._context.settings
        sigma_s = settings.uncertainty.clock_s if capture.time_sigma_s is None else capture.time_sigma_s
        if speed_mps * sigma_s > MAX_MOTION_M:
            raise CaptureError(
                f"its time of exposure is known to ± {sigma_s:.2f} s, at {speed_mps:.1f} m/s ± "
                f"{speed_mps * sigma_s:.1f} m; {MAX_MOTION_M:g} m are allowed: synchronise its clock, or fly slower"
            )
        placed = self._sampler.above_datum(capture)
        self._check_place(member, placed)
        return _Exposed(placed, speed_mps, self._context.clock.now_s())

    def _check_place(self, member: Member, capture: Capture) -> None:
        """Refuse a frame of a place that its vehicle has long left: waypoints count on where frames were exposed.

        Raises:
            CaptureError: it is.
        """
        roster, leg_mps = self._context.roster, self._context.settings.flight.leg_speed_mps
        here_enu_m = roster.position_enu_m(member)
        exposed_enu_m = roster.local_frame().to_enu(capture.position)
        away_m = 0.0 if here_enu_m is None else float(np.linalg.norm((exposed_enu_m - here_enu_m)[:2]))
        if away_m > LATE_S * leg_mps:
            raise CaptureError(
                f"its image was exposed {away_m:.0f} m from where it is: it came more than {LATE_S:g} s late"
            )

    def _keep(self, exposed: _Exposed) -> None:
        vehicle_id = exposed.capture.vehicle_id
        if self._is_over or (queue := self._waiting.get(vehicle_id)) is None:
            return
        self._last_at_s[vehicle_id] = exposed.come_at_s
        self._failures.pop(vehicle_id, None)
        if len(queue) == KEPT:
            self.dropped += 1
            if self.dropped == 1:
                text = "Frames come faster than this station analyses them: the oldest are left out"
                self._context.journal.notice(Severity.WARNING, text)
        queue.append(exposed)


@asynccontextmanager
async def exposing(context: FlightContext, sampler: Sampler, pace: CameraPace) -> AsyncIterator[Exposures]:
    """Expose vehicles in flight for as long as the context is entered; leaving it ends all exposures."""
    async with asyncio.TaskGroup() as group:
        exposures = Exposures(context, sampler, pace, group)
        watch = exposures.start(exposures.watch_station())
        try:
            yield exposures
        finally:
            watch.cancel()
            exposures.follow(())
            if exposures.dropped > 1:
                text = f"{exposures.dropped} frames of this stretch were left out"
                context.journal.notice(Severity.WARNING, text)
