"""AOS-APSO with views kept: remember every view of the target, and hold those that show most of it together.

The swarm scans as the paper's AOS-APSO does until the target is in view. From then on every frame is archived with its
line of sight and its own mask of the target. The drones look along the lines that are expected to show most *together*:
lines that are known to be good, and lines that nobody has looked along, of which more is hoped for than is likely. The
length of a step fits the time that steps take; the archive strategy is the same with steps of one length. See
docs/strategies.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm import motion
from aos_gcs.swarm.archive.looks import MAX_LOOKS, SAME_LINE_M, LookArchive, no_looks, with_looks
from aos_gcs.swarm.archive.moves import HOLDS_WITHIN_M, STILL_WITHIN_M, kept_apart, random_ways, stepped
from aos_gcs.swarm.archive.parameters import AosApsoParameters, ArchiveParameters
from aos_gcs.swarm.archive.plan import choose_lines, goals_along
from aos_gcs.swarm.archive.raster import FINE_CELLS, anchor_of, resampled
from aos_gcs.swarm.archive.target import (
    JUMP_M,
    TargetState,
    after_sighting,
    first_sighting,
    ground_point,
    is_elsewhere,
    out_of_view,
)
from aos_gcs.swarm.factors import fractional_rule
from aos_gcs.swarm.follow import LeaderFollowing
from aos_gcs.swarm.model import Diagnostics, Observation, TargetMasks
from aos_gcs.swarm.parameters import parse_parameters
from aos_gcs.swarm.state import SwarmState

NAME = "aos-archive"

FORGET_STEPS = 8
"""Steps out of view after which a moving target is no longer where the archive knows it."""
SEARCH_STEPS = 15
"""The same for one that stands still."""
REPLAN_WAY_M = 3.0
"""Way that drones may fly until views are chosen anew, above a still target."""
BRISK_MPS = 3.0
"""Mean speed of steps below which longer ones pay, as most of their time is not spent on the way."""
REST_STEPS = 8
"""Steps until views are chosen anew while all drones hold theirs."""


@dataclass(frozen=True, slots=True, eq=False)
class ViewState:
    """Everything that is carried from step to step."""

    swarm: SwarmState
    """State of the strategy that scans, and that takes over without masks."""
    looks: LookArchive
    target: TargetState | None = None
    """None before it is seen, and after it was lost."""
    heights_m: NDArray[np.float64] | None = None
    """Heights of the vehicles above the focal plane in the order of their ids, shape (n,); None if unknown."""
    held_enu_m: NDArray[np.float64] | None = None
    """Crossings of the last chosen lines of sight with the canopy, shape (k, 2)."""
    plan_age: int = 0
    """Steps since they were chosen."""
    is_resting: bool = False
    """Whether all drones held their places in the last step."""
    told_at_s: float | None = None
    """Time of the latest observation, if it tells one."""
    step_s: float | None = None
    """Time from the observation before to the latest one."""


@dataclass(frozen=True, slots=True)
class ViewKeeping:
    """See the module."""

    name: str
    """The name in the registry."""
    parameters: AosApsoParameters
    follower: LeaderFollowing
    """Strategy that scans, and that takes over without masks."""

    @property
    def spacing_m(self) -> float:
        """See :attr:`aos_gcs.swarm.model.Strategy.spacing_m`."""
        return self.parameters.c4_m

    def init(self, scan_direction_enu: NDArray[np.float64]) -> ViewState:
        """See :meth:`aos_gcs.swarm.model.Strategy.init`."""
        return ViewState(self.follower.init(scan_direction_enu), no_looks())

    def tell(self, state: ViewState, observation: Observation) -> ViewState:
        """See :meth:`aos_gcs.swarm.model.Strategy.tell`."""
        swarm = self.follower.tell(state.swarm, observation)
        heights_m, masks = _checked_heights(observation), observation.masks
        state = _with_time(state, observation.time_s)
        if heights_m is None:
            return self._without_sight(replace(state, swarm=swarm, heights_m=None), FORGET_STEPS)
        state = replace(state, swarm=swarm, heights_m=heights_m[np.argsort(observation.vehicle_ids)])
        if not observation.target_in_view or masks is None or not masks.marked.any():
            return self._with_nothing_seen(state, observation, heights_m)
        return self._with_sight(state, observation, heights_m, masks)

    def ask(self, state: ViewState, rng: np.random.Generator) -> tuple[NDArray[np.float64], ViewState]:
        """See :meth:`aos_gcs.swarm.model.Strategy.ask`."""
        situation = motion.check_told(state.swarm)
        if not _knows_target(state) or state.target is None or state.heights_m is None:
            positions_m, swarm = self.follower.ask(state.swarm, rng)
            return positions_m, replace(state, swarm=swarm)
        positions_m, order, _ = motion.sorted_positions(situation)
        target, heights_m = state.target, state.heights_m
        parameters, step_m = self.parameters, self._step_m(state)
        held_m, plan_age = state.held_enu_m, state.plan_age
        if held_m is None or not _is_planned(state, target, len(positions_m), step_m):
            held_m, plan_age = choose_lines(state.looks, target, heights_m, held_m, parameters), 0
        goals_m = goals_along(held_m, target, positions_m, heights_m, parameters.canopy)
        # All drones go along with the target, those that hold too.
        moved_m = positions_m + target.next_way_m
        ways_m = np.linalg.norm(goals_m - moved_m, axis=1)
        holds, is_there = ways_m < HOLDS_WITHIN_M, ways_m < STILL_WITHIN_M
        # The mean of a still target's sightings shifts by centimetres: no reason to move.
        goals_m[is_there] = moved_m[is_there]
        if parameters.wander_m > 0.0:
            goals_m[holds] += random_ways(rng, int(holds.sum()), parameters.wander_m)
        stepped_m = stepped(moved_m, goals_m, step_m)
        apart_m = kept_apart(stepped_m, moved_m, holds, parameters.min_distance_m, rng)
        asked = replace(state.swarm, awaits_ask=False)
        return motion.in_told_order(apart_m, order), replace(
            state, swarm=asked, held_enu_m=held_m, plan_age=plan_age + 1, is_resting=bool(holds.all())
        )

    def diagnostics(self, state: ViewState) -> Diagnostics:
        """See :meth:`aos_gcs.swarm.model.Strategy.diagnostics`."""
        if not _knows_target(state) or state.swarm.situation is None:
            return self.follower.diagnostics(state.swarm)
        return Diagnostics(branch="archive", leader_id=state.swarm.situation.leader_id)

    def _step_m(self, state: ViewState) -> float:
        """Return the longest way of a step: what a brisk vehicle flies in the time that the last one took.

        Where a step takes only the time of its way, that makes ever shorter steps, and longer ones where it also takes
        time to brake, to expose and to compute.
        """
        shortest_m, longest_m = self.parameters.max_step_m, self.parameters.long_step_m
        if not self.parameters.timed_steps or state.step_s is None:
            return shortest_m
        return min(max(BRISK_MPS * state.step_s, shortest_m), longest_m)

    def _without_sight(self, state: ViewState, patience: int) -> ViewState:
        if state.target is None:
            return state
        target = out_of_view(state.target)
        if target.lost_steps > patience:
            return replace(state, target=None, looks=no_looks(), held_enu_m=None)
        return replace(state, target=target)

    def _with_nothing_seen(
        self, state: ViewState, observation: Observation, heights_m: NDArray[np.float64]
    ) -> ViewState:
        """Return the state with empty looks along the lines that nobody has looked along before.

        A still target must be there and only has to be seen: without them the swarm would stay where it sees nothing.
        """
        if state.target is None:
            return state
        state = self._without_sight(state, FORGET_STEPS if state.target.is_moving else SEARCH_STEPS)
        if state.target is None:
            return state
        target, canopy = state.target, self.parameters.canopy
        slopes = (observation.positions_enu_m - target.position_enu_m) / heights_m[:, None]
        lines = canopy.lines_of_slopes(target.position_enu_m, slopes[self._is_useful(slopes, heights_m, observation)])
        is_new = np.asarray((canopy.distances_m(lines, state.looks.lines) > SAME_LINE_M).all(axis=1))
        lines = lines[is_new]
        looks = with_looks(
            state.looks,
            canopy,
            lines,
            masks=np.zeros((len(lines), FINE_CELLS), dtype=np.bool_),
            anchor=anchor_of(target.position_enu_m),
            drift_enu_m=np.array(target.drift_enu_m),
            at_most=MAX_LOOKS if self.parameters.keeps_looks else len(heights_m),
        )
        return replace(state, looks=looks)

    def _with_sight(
        self, state: ViewState, observation: Observation, heights_m: NDArray[np.float64], masks: TargetMasks
    ) -> ViewState:
        """Return the state with the looks of this step in the archive."""
        positions_m, body_height_m = observation.positions_enu_m, self.parameters.body_height_m
        guess_m = positions_m.mean(axis=0) if observation.target_enu_m is None else observation.target_enu_m
        ground_m = ground_point(masks, positions_m, heights_m, guess_m, body_height_m)
        # The masks are of the largest anomaly, which may be another one than the target that the mission follows.
        is_other = observation.target_enu_m is not None and np.linalg.norm(ground_m - guess_m) > JUMP_M
        if is_other or (state.target is not None and is_elsewhere(state.target, ground_m)):
            return self._without_sight(state, FORGET_STEPS)
        target = first_sighting(ground_m) if state.target is None else after_sighting(state.target, ground_m)
        slopes = (positions_m - target.position_enu_m) / heights_m[:, None]
        useful = self._is_useful(slopes, heights_m, observation)
        anchor = anchor_of(target.position_enu_m)
        canopy = self.parameters.canopy
        looks = with_looks(
            state.looks,
            canopy,
            canopy.lines_of_slopes(target.position_enu_m, slopes[useful]),
            masks=resampled(masks, anchor)[useful],
            anchor=anchor,
            drift_enu_m=np.array(target.drift_enu_m),
            at_most=MAX_LOOKS if self.parameters.keeps_looks else len(heights_m),
        )
        return replace(state, target=target, looks=looks)

    def _is_useful(
        self, slopes: NDArray[np.float64], heights_m: NDArray[np.float64], observation: Observation
    ) -> NDArray[np.bool_]:
        """Return whose frames to remember: not those from far beside the aperture, which push out better ones."""
        reach = (self.parameters.aperture_radius_m + self.parameters.c4_m) / heights_m.mean()
        return np.asarray((np.linalg.norm(slopes, axis=1) <= reach) & ~np.isnan(observation.fitness))


def view_keeping(name: str, parameters: AosApsoParameters) -> ViewKeeping:
    """Return the strategy under a name."""
    return ViewKeeping(name, parameters, LeaderFollowing(name, parameters, fractional_rule(parameters)))


def make_aos_archive(parameters: Mapping[str, object]) -> ViewKeeping:
    """Return the archive strategy with the parameters given (:class:`ArchiveParameters`) and defaults for the rest.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return view_keeping(NAME, parse_parameters(ArchiveParameters, parameters, NAME))


def _is_planned(state: ViewState, target: TargetState, drones: int, step_m: float) -> bool:
    """Return whether the lines chosen a few steps before are flown along still, as little has happened since."""
    if state.held_enu_m is None or len(state.held_enu_m) != drones or target.is_moving or target.lost_steps > 0:
        return False
    return state.plan_age < REST_STEPS if state.is_resting else state.plan_age * step_m < REPLAN_WAY_M


def _with_time(state: ViewState, time_s: float | None) -> ViewState:
    step_s = None if time_s is None or state.told_at_s is None else time_s - state.told_at_s
    return replace(state, told_at_s=time_s, step_s=step_s)


def _knows_target(state: ViewState) -> bool:
    return state.target is not None and state.heights_m is not None and len(state.looks) > 0


def _checked_heights(observation: Observation) -> NDArray[np.float64] | None:
    """Return the heights of an observation.

    Raises:
        ValueError: they, or the masks, do not fit the vehicles.
    """
    n, heights_m, masks = len(observation.vehicle_ids), observation.heights_m, observation.masks
    if heights_m is not None and (np.shape(heights_m) != (n,) or not np.all(np.greater(heights_m, 0.0))):
        raise ValueError(f"heights need shape ({n},) and values above 0, but were {heights_m}")
    if masks is not None and (masks.marked.ndim != 3 or len(masks.marked) != n):
        raise ValueError(f"masks need shape ({n}, rows, columns), but have {masks.marked.shape}")
    return heights_m
