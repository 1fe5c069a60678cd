"""The mission's state as clients know it, and what changes in it.

Every snapshot of the mission makes a revision. A client is brought from the revision that it has to the latest one by
one message with the fields that differ, however many revisions lie between; clients that keep up share its text.
"""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass
from typing import Any, Final

from aos_gcs.api.models import MissionModel

REVISIONS_KEPT: Final = 32
"""Changes that can be merged; who is further behind gets the whole state."""

Fields = dict[str, Any]


@dataclass(frozen=True, slots=True)
class _Change:
    """From one revision to the next."""

    mission: Fields
    vehicles: dict[int, Fields]


class MissionState:
    """The latest state, with the changes that have led to it."""

    def __init__(self) -> None:
        self._mission: Fields = {}
        self._vehicles: dict[int, Fields] = {}
        self._changes: deque[_Change | None] = deque(maxlen=REVISIONS_KEPT)
        """None: a change that cannot be told by fields, because a vehicle is gone."""
        self._bodies: dict[int, str] = {}
        """Text behind kind and seq that leads from a revision to the present one."""
        self._utc_s = 0.0
        self.revision = 0

    def update(self, mission: MissionModel, utc_s: float) -> bool:
        """Take in the state of the mission; return whether anything has changed."""
        fields = mission.model_dump(mode="json")
        vehicles = {one["vehicle_id"]: one for one in fields.pop("vehicles")}
        change = _Change(
            mission=_changed(self._mission, fields),
            vehicles={
                vehicle_id: {"vehicle_id": vehicle_id} | changed
                for vehicle_id, one in vehicles.items()
                if (changed := _changed(self._vehicles.get(vehicle_id, {}), one))
            },
        )
        gone = not self._vehicles.keys() <= vehicles.keys()
        if not (change.mission or change.vehicles or gone):
            return False
        self._changes.append(None if gone else change)
        self._mission, self._vehicles = fields, vehicles
        self._bodies.clear()
        self._utc_s = utc_s
        self.revision += 1
        return True

    def message_since(self, revision: int, seq: int) -> str:
        """Return the text of the message that leads from a revision to the present one."""
        if revision not in self._bodies:
            self._bodies[revision] = self._body_since(revision)
        return f'{{"seq":{seq},{self._bodies[revision]}'

    def _body_since(self, revision: int) -> str:
        behind = self.revision - revision
        changes = list(self._changes)[-behind:] if behind <= len(self._changes) else [None]
        mission: Fields = {}
        vehicles: dict[int, Fields] = {}
        for change in changes:
            if change is None:
                whole = self._mission | {"vehicles": list(self._vehicles.values())}
                return self._body("snapshot", {"mission": whole})
            mission |= change.mission
            for vehicle_id, fields in change.vehicles.items():
                vehicles[vehicle_id] = vehicles.get(vehicle_id, {}) | fields
        return self._body("changes", {"mission": mission, "vehicles": list(vehicles.values())})

    def _body(self, kind: str, fields: Fields) -> str:
        return json.dumps({"kind": kind, "utc_s": self._utc_s, **fields}, separators=(",", ":"))[1:]


def _changed(before: Fields, now: Fields) -> Fields:
    """Return the fields with another value than before."""
    return {name: value for name, value in now.items() if name not in before or before[name] != value}
