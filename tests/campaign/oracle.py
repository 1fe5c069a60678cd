"""What must hold in every mission, checked against the truth that only a simulation knows."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.fakes.air import FIRST_PORT, Address

AIRBORNE_M = 0.5
"""True height from which a vehicle flies, whatever anybody believes."""
PILOT_GRACE_S = 5.0
"""Time in which the station may not have seen yet that a pilot has taken over."""
MOVING = frozenset(
    {
        mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
        mavlink.MAV_CMD_NAV_TAKEOFF,
        mavlink.MAV_CMD_NAV_LAND,
        mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
        mavlink.MAV_CMD_DO_SET_MODE,
        mavlink.MAV_CMD_DO_REPOSITION,
    }
)


@dataclass(frozen=True)
class Violation:
    """Something that must not happen, and did."""

    kind: str
    at_s: float
    text: str

    def __str__(self) -> str:
        return f"{self.kind} at {self.at_s:.1f} s: {self.text}"


class Oracle(logging.Handler):
    """Collects violations of one mission.

    Stands in for the simulator's separation monitor, and listens to the log.

    Args:
        separation_m: configured separation.
        now_s: returns the mission's time.
        landed_ids: returns the ids of the vehicles that the station counts as landed.
    """

    def __init__(
        self, separation_m: float, now_s: Callable[[], float], landed_ids: Callable[[], Sequence[int]]
    ) -> None:
        super().__init__(logging.WARNING)
        self.violations: dict[str, Violation] = {}
        """First of each kind; of separations, the smallest."""
        self.smallest_m: float | None = None
        self.pair: tuple[int, int] | None = None
        self._separation_m = separation_m
        self._now_s = now_s
        self._landed_ids = landed_ids
        self.on_step: Callable[[NDArray[np.float64]], None] = lambda position_enu_m: None  # noqa: ARG005
        """Called with the true positions, shape (N, 3), after each step of the simulation."""
        self._before_enu_m: NDArray[np.float64] | None = None
        self._fallen: set[int] = set()
        self._pilots_since_s: dict[int, float] = {}
        self._parsers: dict[int, mavlink.MAVLink] = {}

    def report(self, kind: str, text: str) -> None:
        self.violations.setdefault(kind, Violation(kind, self._now_s(), text))

    # --- what faults tell it ------------------------------------------------------------------------------------------

    def note_fall(self, vehicle_id: int) -> None:
        """Expect nothing more of a vehicle whose motors have stopped in the air."""
        self._fallen.add(vehicle_id)

    def has_fallen(self, vehicle_id: int) -> bool:
        return vehicle_id in self._fallen

    @contextmanager
    def piloted(self, vehicle_id: int) -> Iterator[None]:
        """A pilot flies this vehicle: the station leaves it alone."""
        self._pilots_since_s[vehicle_id] = self._now_s()
        try:
            yield
        finally:
            self._pilots_since_s.pop(vehicle_id, None)

    def is_piloted(self, vehicle_id: int | None) -> bool:
        return vehicle_id in self._pilots_since_s

    # --- the truth ----------------------------------------------------------------------------------------------------

    def update(self, vehicle_ids: Sequence[int], position_enu_m: NDArray[np.float64]) -> None:
        """Take in the true positions, shape (N, 3), after each step of the simulation."""
        before_enu_m = position_enu_m if self._before_enu_m is None else self._before_enu_m
        self._before_enu_m = position_enu_m.copy()
        now_m, before_m = position_enu_m.tolist(), before_enu_m.tolist()
        height_m = dict(zip(vehicle_ids, position_enu_m[:, 2].tolist(), strict=True))
        for first, second in combinations(range(len(vehicle_ids)), 2):
            pair = vehicle_ids[first], vehicle_ids[second]
            if not self._fallen.intersection(pair) and max(height_m[pair[0]], height_m[pair[1]]) > AIRBORNE_M:
                distance_m = _closest_m(before_m[first], before_m[second], now_m[first], now_m[second])
                self._check_pair(pair, distance_m, height_m)
        for vehicle_id in self._landed_ids():
            if height_m.get(vehicle_id, 0.0) > AIRBORNE_M and vehicle_id not in self._fallen:
                self.report("landed in the air", f"vehicle {vehicle_id} at {height_m[vehicle_id]:.1f} m")
        self.on_step(position_enu_m)

    def _check_pair(self, pair: tuple[int, int], distance_m: float, height_m: Mapping[int, float]) -> None:
        if self.smallest_m is not None and distance_m >= self.smallest_m:
            return
        self.smallest_m, self.pair = distance_m, pair
        if distance_m < self._separation_m:
            heights = " and ".join(f"{height_m[vehicle_id]:.1f}" for vehicle_id in pair)
            first = self.violations.get("separation")
            text = f"{distance_m:.2f} m between vehicles {pair[0]} and {pair[1]}, {heights} m high"
            at_s = self._now_s() if first is None else first.at_s
            self.violations["separation"] = Violation("separation", at_s, text)

    # --- what the station sends ---------------------------------------------------------------------------------------

    def sent(self, data: bytes, receiver: Address, vehicle_ids: Mapping[int, int]) -> None:
        """Look at a datagram of the station; ``vehicle_ids`` are those of the vehicles by their index."""
        parser = self._parsers.setdefault(receiver[1], mavlink.MAVLink(None))
        parser.robust_parsing = True
        owner = vehicle_ids.get(receiver[1] - FIRST_PORT)
        for message in parser.parse_buffer(data) or []:
            is_moving = getattr(message, "command", None) in MOVING
            target = getattr(message, "target_system", 0)
            if (owner is not None and target not in (0, owner)) or (owner is None and is_moving):
                self.report("wrong address", f"{message.get_type()} for {target} sent to {receiver}, owner {owner}")
            since_s = self._pilots_since_s.get(owner or 0)
            if is_moving and since_s is not None and self._now_s() - since_s > PILOT_GRACE_S:
                command = mavlink.enums["MAV_CMD"][message.command].name
                self.report(
                    "pilot overruled", f"{command} sent to vehicle {owner}, flown by a pilot since {since_s:.1f} s"
                )

    # --- the log ------------------------------------------------------------------------------------------------------

    def emit(self, record: logging.LogRecord) -> None:
        """Report what should never be logged."""
        text = record.getMessage()
        if record.exc_info or record.name == "asyncio" or "nternal error" in text or "has failed" in text:
            error = record.exc_info[1] if record.exc_info else None
            self.report("exception", f"{text} {error!r}" if error else text)


def _closest_m(
    before_one_m: Sequence[float], before_other_m: Sequence[float], one_m: Sequence[float], other_m: Sequence[float]
) -> float:
    """Return the smallest distance of two vehicles that fly straight from one position to the next."""
    start_m = [a - b for a, b in zip(before_one_m, before_other_m, strict=True)]
    way_m = [a - b - c for a, b, c in zip(one_m, other_m, start_m, strict=True)]
    length_m2 = sum(part * part for part in way_m)
    share = -sum(a * b for a, b in zip(start_m, way_m, strict=True)) / length_m2 if length_m2 > 0.0 else 0.0
    share = min(1.0, max(0.0, share))
    return math.hypot(*(a + share * b for a, b in zip(start_m, way_m, strict=True)))
