"""Verification of a recorded mission: every step is computed again from the record, and compared."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Final

from aos_gcs.errors import ImagingError, InputDataError
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.search.decisions.retrace import Retrace, Retraced
from aos_gcs.ports import Capture
from aos_gcs.store.codec import encode
from aos_gcs.store.frame_files import frame_digest
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.upgrade import FIRST_WITH_DECISIONS

TOLERANCE: Final = 1e-6
"""Difference up to which two numbers are the same, relative to the larger one where that exceeds 1: other processors
round differently in the last digits."""

_PER_VEHICLE: Final = ("fitness",)
_NOT_COMPARED: Final = frozenset(
    {"missing", "imaging_ms", "work_ms", "loop_lag_p99_ms", "focal_height_m", "waypoints", *_PER_VEHICLE}
)
"""Fields of a step that depend on more than frames and states, or are compared vehicle by vehicle."""
_LONGEST_TEXT: Final = 160


@dataclass(frozen=True, slots=True)
class Difference:
    """The first value of a record that comes out differently."""

    step: int
    vehicle_id: int | None
    what: str
    recorded: object
    computed: object

    def __str__(self) -> str:
        vehicle = "" if self.vehicle_id is None else f", vehicle {self.vehicle_id}"
        values = f"recorded {_short(self.recorded)}, computed {_short(self.computed)}"
        return f"step {self.step}{vehicle}, {self.what}: {values}"


@dataclass(frozen=True, slots=True)
class Verification:
    """Result of a verification."""

    steps: int
    """Number of steps that were computed again."""
    difference: Difference | None
    """None: everything is identical."""


@dataclass(frozen=True, slots=True)
class _Fact:
    what: str
    vehicle_id: int | None
    recorded: object
    computed: object


def verify_mission(reader: MissionReader) -> Verification:
    """Compute every step of a mission again, up to the first difference.

    Raises:
        InputDataError: the record is damaged, or holds no steps, or not what they depended on.
    """
    if not reader.has_decisions:
        raise InputDataError(
            f"{reader.folder} cannot be verified: it was recorded by an older version (layout below "
            f"{FIRST_WITH_DECISIONS}) and does not hold what its decisions depended on"
        )
    steps, search = reader.steps(), reader.search()
    if steps and _is_torn(reader, steps[-1]):
        steps = steps[:-1]
    if not steps or search is None:
        raise InputDataError(f"{reader.folder} cannot be verified: it holds no step of a search")
    retrace, pending = Retrace(search), _Pending()
    for number, step in enumerate(steps, start=1):
        for about, fact in _facts(reader, retrace, step, pending):
            if _differ(fact.recorded, fact.computed):
                return Verification(number, _difference(about, fact))
    for about, fact in pending.conclude(retrace):
        if _differ(fact.recorded, fact.computed):
            return Verification(len(steps), _difference(about, fact))
    return Verification(len(steps), None)


def _is_torn(reader: MissionReader, last: StepRecord) -> bool:
    """Return whether the station died before the frames of its last step, for which no decision waits, were written."""
    known = reader.decision(last.step)
    if reader.outcome() is not None or known is None:
        return False
    return not known[0].marks.keys() <= {entry.vehicle_id for entry in reader.frames(last.step)}


@dataclass(slots=True)
class _Pending:
    """Conclusion of the latest step that has one; in a split swarm others may have decided before it."""

    conclusion: ConclusionRecord | None = None

    def conclude(self, retrace: Retrace) -> Iterator[tuple[int, _Fact]]:
        """Make it again, if it is still to be made; yield its step with each fact."""
        conclusion, self.conclusion = self.conclusion, None
        if conclusion is not None:
            for fact in _conclusion_facts(conclusion, retrace.conclude(conclusion)):
                yield conclusion.step, fact


def _difference(step: int, fact: _Fact) -> Difference:
    """Return a difference as that of the innermost field."""
    what, recorded, computed = fact.what, fact.recorded, fact.computed
    while isinstance(recorded, dict) and isinstance(computed, dict) and recorded.keys() == computed.keys():
        name = next(key for key in recorded if _differ(recorded[key], computed[key]))
        what, recorded, computed = f"{what}, {_words(name)}", recorded[name], computed[name]
    return Difference(step, fact.vehicle_id, what, recorded, computed)


def _facts(reader: MissionReader, retrace: Retrace, step: StepRecord, pending: _Pending) -> Iterator[tuple[int, _Fact]]:
    """Compute a step again, and what was concluded before it; yield its number with each fact."""
    known = reader.decision(step.step)
    if known is None:
        raise InputDataError(f"{reader.folder} cannot be verified: what step {step.step} depended on is not recorded")
    decision, conclusion = known
    if decision.concluded > retrace.concluded:
        yield from pending.conclude(retrace)
    if (decision.decided, decision.concluded) != (retrace.decided, retrace.concluded):
        raise InputDataError(
            f"{reader.folder} cannot be verified: steps before step {step.step} are missing in the record "
            f"({decision.decided} decisions and {decision.concluded} conclusions were made before it, "
            f"{retrace.decided} and {retrace.concluded} are recorded)"
        )
    captures: list[Capture] = []
    for entry in reader.frames(step.step):
        captures.append(entry.load())
        digest = frame_digest(captures[-1])
        yield step.step, _Fact("frame (digest of pixels and pose)", entry.vehicle_id, entry.digest, digest)
    try:
        retraced = retrace.decide(decision, captures)
    except ImagingError as error:
        yield step.step, _Fact("frames", None, "usable", str(error))
        return
    for fact in _decision_facts(step, decision, retraced, reader.strategy_state(step.step)):
        yield step.step, fact
    if conclusion is not None:
        pending.conclusion = conclusion


def _decision_facts(
    step: StepRecord, decision: DecisionRecord, retraced: Retraced, strategy_state: Mapping[str, object]
) -> Iterator[_Fact]:
    again = retraced.record
    yield from _by_vehicle("mask (digest of its marks)", decision.marks, retraced.marks)
    yield _Fact("settled places", None, encode(decision.settled_enu_m), encode(retraced.settled_enu_m))
    for name in _PER_VEHICLE:
        yield from _by_vehicle(_words(name), getattr(step, name), getattr(again, name))
    for field in fields(StepRecord):
        if field.name not in _NOT_COMPARED:
            yield _Fact(_words(field.name), None, encode(getattr(step, field.name)), encode(getattr(again, field.name)))
    yield _Fact("phase that follows", None, encode(decision.following), encode(retraced.following))
    recorded = {waypoint.vehicle_id: encode(waypoint) for waypoint in step.waypoints}
    computed = {waypoint.vehicle_id: encode(waypoint) for waypoint in again.waypoints}
    yield from _by_vehicle("waypoint", recorded, computed)
    yield _Fact("state of the strategy", None, strategy_state, encode(retraced.strategy_state))


def _conclusion_facts(recorded: ConclusionRecord, computed: ConclusionRecord) -> Iterator[_Fact]:
    targets = [{target.track_id: encode(target) for target in one.targets} for one in (recorded, computed)]
    for track_id in sorted(targets[0].keys() | targets[1].keys()):
        yield _Fact(f"target {track_id}", None, targets[0].get(track_id), targets[1].get(track_id))
    yield _Fact("phase that was concluded", None, encode(recorded.following), encode(computed.following))


def _by_vehicle(what: str, recorded: Mapping[int, object], computed: Mapping[int, object]) -> Iterator[_Fact]:
    for vehicle_id in sorted(recorded.keys() | computed.keys()):
        yield _Fact(what, vehicle_id, recorded.get(vehicle_id), computed.get(vehicle_id))


def _differ(recorded: object, computed: object) -> bool:
    """Return whether two values of plain data differ by more than the rounding of numbers."""
    match recorded, computed:
        case (bool(), _) | (_, bool()):
            return recorded is not computed
        case int(), int():
            return recorded != computed
        case (int() | float(), int() | float()):
            scale = max(1.0, abs(recorded), abs(computed))
            return not (recorded == computed or math.fabs(recorded - computed) <= TOLERANCE * scale)
        case dict(), dict():
            return recorded.keys() != computed.keys() or any(_differ(recorded[key], computed[key]) for key in recorded)
        case list(), list():
            return len(recorded) != len(computed) or any(map(_differ, recorded, computed))
    return recorded != computed


def _words(name: str) -> str:
    return name.replace("_", " ")


def _short(value: object) -> str:
    """Return a value as text, floats with at most nine digits, and what is too long cut."""
    text = _text(value)
    return text if len(text) <= _LONGEST_TEXT else f"{text[: _LONGEST_TEXT - 1]}…"


def _text(value: object) -> str:
    match value:
        case float():
            return f"{value:.9g}"
        case dict():
            return "{" + ", ".join(f"{key}: {_text(item)}" for key, item in value.items()) + "}"
        case list():
            return "[" + ", ".join(map(_text, value)) + "]"
    return str(value)
