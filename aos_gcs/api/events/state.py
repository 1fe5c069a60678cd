"""The mission's state as clients know it, and what changes in it.

Every snapshot of the mission makes a revision. A client is brought from the revision that it has to the latest one by
one message with the fields that differ, however many revisions lie between; clients that keep up share its text.

With a large fleet most of the work for clients is done here. Values are compared as they are, by identity first, since
conversion hands the same objects out again; only what has changed becomes JSON.
"""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

from aos_gcs.api.models.mission import MissionModel
from aos_gcs.api.models.preflight import PreflightCheckModel

REVISIONS_KEPT: Final = 32
"""Number of changes that can be merged; clients that are further behind get the whole state."""

Fields = dict[str, Any]
CheckKey = tuple[int, str]
KeyT = TypeVar("KeyT")


@dataclass(frozen=True, slots=True)
class _Change:
    """Changes from one revision to a later one."""

    mission: Fields = field(default_factory=dict)
    """Changed fields; ``preflight`` only where checks were added or removed."""
    vehicles: dict[int, Fields] = field(default_factory=dict)
    checks: dict[CheckKey, PreflightCheckModel] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.mission or self.vehicles or self.checks)

    def then(self, later: _Change) -> _Change:
        """Return both changes in one."""
        vehicles = dict(self.vehicles)
        for vehicle_id, fields in later.vehicles.items():
            vehicles[vehicle_id] = vehicles.get(vehicle_id, {}) | fields
        checks = later.checks if "preflight" in later.mission else self.checks | later.checks
        return _Change(self.mission | later.mission, vehicles, checks)


class MissionState:
    """The latest state, with the changes that have led to it."""

    def __init__(self) -> None:
        self._mission: Fields = {}
        self._vehicles: dict[int, Fields] = {}
        self._checks: dict[CheckKey, PreflightCheckModel] = {}
        self._preflight: list[PreflightCheckModel] = []
        self._changes: deque[_Change | None] = deque(maxlen=REVISIONS_KEPT)
        """None: a change that fields cannot express, because a vehicle is gone."""
        self._bodies: dict[int, str] = {}
        """Text after seq, age and name that leads from a revision to the present one."""
        self._utc_s = 0.0
        self.revision = 0

    @property
    def utc_s(self) -> float:
        """Time of the latest state."""
        return self._utc_s

    def update(self, mission: MissionModel, utc_s: float) -> bool:
        """Take in the state of the mission; return whether anything has changed."""
        fields = {name: value for name, value in vars(mission).items() if name not in {"vehicles", "preflight"}}
        vehicles = {one.vehicle_id: vars(one) for one in mission.vehicles}
        change = _Change(
            mission=_changed(self._mission, fields),
            vehicles={
                vehicle_id: {"vehicle_id": vehicle_id} | changed
                for vehicle_id, one in vehicles.items()
                if (changed := _changed(self._vehicles.get(vehicle_id, {}), one))
            },
        )
        checks = self._checks
        if mission.preflight != self._preflight:
            checks = {(one.vehicle_id, one.name): one for one in mission.preflight}
            if list(checks) == list(self._checks):
                change = replace(change, checks=_changed(self._checks, checks))
            else:
                change = replace(change, mission=change.mission | {"preflight": mission.preflight})
        gone = not self._vehicles.keys() <= vehicles.keys()
        if not (change or gone):
            return False
        self._changes.append(None if gone else change)
        self._mission, self._vehicles = fields, vehicles
        self._checks, self._preflight = checks, mission.preflight
        self._bodies.clear()
        self._utc_s = utc_s
        self.revision += 1
        return True

    def message_since(self, revision: int, seq: int, mission_age_s: float, seen: str) -> str:
        """Return the text of the message that leads from a revision to the present one, whose name is ``seen``."""
        if revision not in self._bodies:
            self._bodies[revision] = self._body_since(revision)
        return f'{{"seq":{seq},"mission_age_s":{mission_age_s},"seen":"{seen}",{self._bodies[revision]}'

    def _body_since(self, revision: int) -> str:
        behind = self.revision - revision
        changes = list(self._changes)[-behind:] if behind <= len(self._changes) else [None]
        whole = _Change()
        for change in changes:
            if change is None:
                lists = {"vehicles": list(self._vehicles.values()), "preflight": self._preflight}
                return self._body("snapshot", {"mission": self._mission | lists})
            whole = whole.then(change)
        vehicles, checks = list(whole.vehicles.values()), list(whole.checks.values())
        return self._body("changes", {"mission": whole.mission, "vehicles": vehicles, "preflight": checks})

    def _body(self, kind: str, fields: Fields) -> str:
        # What JSON does not know is a wire model, whose fields are its attributes.
        return json.dumps({"kind": kind, "utc_s": self._utc_s, **fields}, separators=(",", ":"), default=vars)[1:]


def _changed(before: dict[KeyT, Any], now: dict[KeyT, Any]) -> dict[KeyT, Any]:
    """Return the entries with another value than before."""
    missing = object()
    return {
        name: value
        for name, value in now.items()
        if (old := before.get(name, missing)) is not value and (old is missing or old != value)
    }
