"""Control of a vehicle: whether it follows this station, a pilot, another station, or its own failsafe."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AboveHomeM

TARGET_MOVED_M = 1.0
"""Distance from our target at which a reported target is another one; autopilots repeat theirs unchanged."""
_OUR_TARGET_M = 2.0
"""Distance of the reported target from the commanded one at which it is ours."""
_REPORTS = 2
"""Reports in a row that show another target: a single one may have been overtaken on a radio."""
_LATE_S = 3.0
"""Time for which effects of older commands, and older heartbeats, may arrive after a newer command took effect."""
_SETTLING_S = 1.5
"""Time from a confirmed command until the reported target is the one of that command."""
_FORMER_S = 10.0
"""Time from a confirmed command for which reports of targets before it may arrive, as over a busy link."""
_FORMER_TARGETS = 4
"""Number of targets before the newest one that are remembered."""
_ENDS_BELOW_M = 3.0
"""Largest distance below its top at which a take-off may seem to end: PX4 ends it 0.8 m below (NAV_MC_ALT_RAD), by a
height that its reports have been seen to miss by 2 m."""
_ENDS_BELOW_SHARE = 0.3
"""The same, as a share of a low take-off's height."""
_SILENT_BEATS = 6
"""Heartbeats without a reported target after which it is asked for."""
_UNANSWERED_BEATS = 4
"""Further heartbeats without one after which the vehicle has none."""
_BEAT_S = 0.8
"""Least time between two heartbeats that are counted: those from a queue come at once."""
_FLYING = frozenset(
    {
        mavlink.MAV_CMD_NAV_LOITER_UNLIM,
        mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
        mavlink.MAV_CMD_NAV_LAND,
        mavlink.MAV_CMD_NAV_TAKEOFF,
        mavlink.MAV_CMD_DO_FOLLOW,
        mavlink.MAV_CMD_DO_ORBIT,
        mavlink.MAV_CMD_DO_SET_MODE,
        mavlink.MAV_CMD_DO_REPOSITION,
        mavlink.MAV_CMD_DO_PAUSE_CONTINUE,
        mavlink.MAV_CMD_OVERRIDE_GOTO,
        mavlink.MAV_CMD_MISSION_START,
    }
)
"""Commands that lead a vehicle elsewhere, or stop it."""
_FAILSAFES: Mapping[int, str] = MappingProxyType(
    {
        mavlink.MAV_STATE_CRITICAL: "critical",
        mavlink.MAV_STATE_EMERGENCY: "emergency",
        mavlink.MAV_STATE_FLIGHT_TERMINATION: "flight termination",
    }
)


@dataclass(frozen=True, slots=True)
class Climb:
    """Top of a take-off, and the modes that the autopilot enters by itself there."""

    height_above_home_m: AboveHomeM
    modes: frozenset[str]

    def may_end_at(self, height_above_home_m: AboveHomeM) -> bool:
        """Whether the autopilot may take this reported height for the top."""
        top_m = self.height_above_home_m
        return height_above_home_m >= top_m - min(_ENDS_BELOW_M, _ENDS_BELOW_SHARE * top_m)


class ControlWatch:
    """Comparison of the mode and the target that an armed vehicle reports with those that we have commanded.

    A mode, or a target, that none of our commands explains is a take-over. It stays one, whatever the vehicle reports
    later, until ``reclaim`` is called or the motors stop; who flew the vehicle last stays known until they run again.
    """

    def __init__(self) -> None:
        self.reason = ""
        """What shows that the vehicle was taken over: "its mode changed to LOITER"; empty while it was not."""
        self.takeovers = 0
        """Number of take-overs so far. A command that began before the latest one must not be repeated."""
        self.has_pilot = False
        """Whether a pilot or another station has flown it since it was taken over, not only the autopilot's own return
        or landing; a command of ours ends it, and a new start of the motors."""
        self.failsafe = ""
        """Status of the autopilot's own failsafe, in a word; empty while it has none."""
        self._is_armed = False
        self._came_down = False
        """Whether the mode of the latest heartbeat was a return or a landing."""
        self._reported: GeodeticPosition | None = None
        """Target that was reported last."""
        self._former: tuple[GeodeticPosition, ...] = ()
        """Targets that were commanded or reported before the newest command."""
        self._mode_name = ""
        self._modes: frozenset[str] = frozenset()
        """Modes that the newest command explains; empty before the first command."""
        self._older_modes: frozenset[str] = frozenset()
        """Modes before it, and of the commands before it."""
        self._shown_at_s: float | None = None
        """Time at which a mode of the newest command was first reported."""
        self._accepted_at_s: float | None = None
        """Time at which the vehicle accepted the newest command."""
        self._climb: Climb | None = None
        """End of the take-off that is in progress."""
        self._beats_without_target: int | None = None
        """Heartbeats since a target was reported; None before the first one, and in modes without targets."""
        self._counted_at_s = -math.inf
        self.misses_target = False
        """Whether the vehicle has ceased to report its target, by the latest heartbeat: it is to be asked for it."""
        self._forget_target()

    def _forget_target(self) -> None:
        self._commanded: GeodeticPosition | None = None
        self._target: LocalFrame | None = None
        """Frame at the target that the vehicle reported for our command; None while that is not known."""
        self._judged_from_s: float | None = None
        """Time from which reported targets are judged; None while a command is on its way."""
        self._strange_reports = 0

    @property
    def is_mode_outdated(self) -> bool:
        """Whether the latest heartbeat has another mode than those that the newest command leads to."""
        return bool(self._modes) and self._mode_name not in self._modes

    @property
    def is_mode_doubtful(self) -> bool:
        """Whether it has, though an earlier one had one of them: it is late, or somebody has changed the mode since."""
        return self.is_mode_outdated and self._shown_at_s is not None

    def begin(self, modes: frozenset[str], target: GeodeticPosition | None, climb: Climb | None = None) -> None:
        """Note that a command is sent which explains ``modes``, and flies to ``target``, or on top of a ``climb``."""
        self._older_modes = self._older_modes | self._modes | {self._mode_name}
        self._climb = climb
        self._modes, self._shown_at_s, self._accepted_at_s = modes, None, None
        self.has_pilot = False
        former = (*self._former, self._commanded, self._reported)
        self._former = tuple(each for each in former if each is not None)[-_FORMER_TARGETS:]
        self._forget_target()
        self._commanded = target

    def hear_answer_to_another(self, ack: mavlink.MAVLink_command_ack_message) -> None:
        """Judge an answer of the autopilot to another station: that it flies by a command of that one.

        The next waypoint may be due before a target is reported twice: in a sweep, there is one every half second.
        """
        if self._is_armed and ack.command in _FLYING and ack.result == mavlink.MAV_RESULT_ACCEPTED:
            self._take_over(f"it follows a command of station {ack.target_system}", has_pilot=True)

    def take_answer(self, now_s: float, *, is_accepted: bool) -> None:
        """Note the vehicle's latest answer to the newest command; once it is accepted, older modes soon end."""
        if not is_accepted:
            self._accepted_at_s = None
        elif self._accepted_at_s is None:
            self._accepted_at_s = now_s

    def confirm(self, reported: GeodeticPosition | None, now_s: float, *, has_target: bool) -> None:
        """Note that the newest command has taken effect; ``reported`` is the target that the vehicle reports now."""
        if not has_target:
            return
        self._judged_from_s = now_s + _SETTLING_S
        if reported is not None and _are_near(self._commanded, reported, _OUR_TARGET_M):
            self._target, self._judged_from_s = LocalFrame(reported), now_s

    def reclaim(self) -> None:
        """Count the present mode and target as ours: an operator gives the vehicle back to this station."""
        self.reason, self.has_pilot, self._beats_without_target = "", False, None
        self._modes, self._older_modes = frozenset({self._mode_name}), frozenset()
        self._shown_at_s = self._accepted_at_s = None
        self._forget_target()

    def take_heartbeat(
        self,
        mode_name: str,
        heartbeat: mavlink.MAVLink_heartbeat_message,
        our_modes: frozenset[str],
        now_s: float,
        *,
        comes_down: bool = False,
        reports_targets: bool = False,
    ) -> None:
        """Judge the mode of a heartbeat, and whether the vehicle still has a target.

        ``our_modes`` are all those that we ever command; ``comes_down`` tells whether the mode is a return or a
        landing, which the autopilot also begins by itself; ``reports_targets`` whether the autopilot reports its
        target in this mode all the time.
        """
        is_armed = bool(heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        if is_armed and not self._is_armed:
            self.has_pilot = False
        ends_way_down = self._is_armed and self._came_down and not comes_down
        self._is_armed, self._came_down = is_armed, comes_down
        self._mode_name = mode_name
        self.failsafe = _FAILSAFES.get(heartbeat.system_status, "") if is_armed else ""
        if not is_armed:
            self._stand_down()
        elif mode_name in self._modes:
            self._shown_at_s = now_s if self._shown_at_s is None else self._shown_at_s
            self._count_beat(now_s, reports_targets=reports_targets)
        elif not self._is_explained(mode_name, our_modes, now_s, ends_way_down=ends_way_down):
            self._take_over(f"its mode changed to {mode_name}", has_pilot=not comes_down)
            self._modes, self._older_modes = frozenset({mode_name}), frozenset()

    def _count_beat(self, now_s: float, *, reports_targets: bool) -> None:
        """Count the heartbeats since the last target, across commands: ours end attitudes for a moment only."""
        self.misses_target = False
        if self._beats_without_target is None or not reports_targets:
            self._beats_without_target = None
            return
        if now_s - self._counted_at_s < _BEAT_S:
            return
        self._counted_at_s = now_s
        self._beats_without_target += 1
        self.misses_target = self._beats_without_target == _SILENT_BEATS
        if self._beats_without_target >= _SILENT_BEATS + _UNANSWERED_BEATS:
            self._take_over("it reports no target any more, as when another station sets its attitude", has_pilot=True)

    def hear_target(self) -> None:
        """Note that the vehicle reports a target, in whatever message."""
        self._beats_without_target = 0

    def take_height(self, height_above_home_m: AboveHomeM | None) -> None:
        """Expect the modes that end a take-off once the vehicle is high enough; call it before ``take_heartbeat``."""
        climb = self._climb
        if climb is None or height_above_home_m is None:
            return
        if climb.may_end_at(height_above_home_m):
            self._modes, self._climb = self._modes | climb.modes, None

    def _stand_down(self) -> None:
        """Forget commands and take-overs when the motors stop, but not whether a pilot has landed the vehicle."""
        self.reason, self._beats_without_target = "", None
        self._modes = self._older_modes = frozenset()
        self._shown_at_s = self._accepted_at_s = self._climb = None
        self._forget_target()

    def _is_explained(self, mode_name: str, our_modes: frozenset[str], now_s: float, *, ends_way_down: bool) -> bool:
        if not self._modes:
            # Nothing was commanded, as after a restart: only a pilot ends a return or a landing in the air.
            return mode_name in our_modes and not ends_way_down
        since_s = self._accepted_at_s if self._shown_at_s is None else self._shown_at_s
        is_recent = since_s is None or now_s - since_s <= _LATE_S
        return is_recent and mode_name in self._older_modes

    def take_text(self, text: str) -> None:
        """Note a failsafe that a status text reports, up to a second before the heartbeat that shows it."""
        if "failsafe" in text.lower() and self._is_armed:
            self.failsafe = self.failsafe or "reported"

    def take_target(self, position: GeodeticPosition | None, now_s: float) -> None:
        """Judge a reported target; None stands for a target without a position, such as a velocity."""
        self._reported = position
        if self._judged_from_s is None or now_s < self._judged_from_s:
            return
        if position is not None:
            if self._target is None and now_s < self._judged_from_s + _FORMER_S and self._is_former(position):
                return
            if self._target is None or _are_near(self._commanded, position, _OUR_TARGET_M):
                self._target = LocalFrame(position)
        is_ours = position is not None and _distance_m(self._target, position) <= TARGET_MOVED_M
        self._strange_reports = 0 if is_ours else self._strange_reports + 1
        if self._strange_reports == _REPORTS:
            self._take_over("it flies to a target of another station or pilot", has_pilot=True)

    def _is_former(self, position: GeodeticPosition) -> bool:
        """Return whether a report may be one of an older command that is late."""
        is_ours = _are_near(self._commanded, position, _OUR_TARGET_M)
        return not is_ours and any(_are_near(former, position, TARGET_MOVED_M) for former in self._former)

    def _take_over(self, reason: str, *, has_pilot: bool) -> None:
        self.reason = reason
        self.has_pilot = self.has_pilot or has_pilot
        self.takeovers += 1
        self._former = ()
        self._beats_without_target = None
        self._forget_target()


def _are_near(one: GeodeticPosition | None, other: GeodeticPosition, distance_m: float) -> bool:
    return one is not None and _distance_m(LocalFrame(one), other) <= distance_m


def _distance_m(frame: LocalFrame | None, position: GeodeticPosition) -> float:
    return math.inf if frame is None else float(np.linalg.norm(frame.to_enu(position)))
