"""What is to be changed on a map of CalTopo, one request after the other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from aos_gcs.sharing.caltopo.objects import MapObject, uid_of

CHANGED_S = 10.0
"""Shortest time between two requests for the same marker, which moves by centimetres all the time."""
SHAPE_S = 60.0
"""The same for a shape: tracks grow all the time."""


@dataclass(slots=True)
class _Known:
    kind: str
    feature_id: str
    payload: Mapping[str, Any] | None
    """What it was last set to; None where that is not known."""
    at_s: float = -math.inf


@dataclass(frozen=True, slots=True)
class Change:
    """One request: an object is made (no id), set, or removed (no payload)."""

    uid: str
    kind: str
    feature_id: str | None
    payload: Mapping[str, Any] | None


class MapBoard:
    """Remembers what is on the map, by our names. What others have made, another station too, is left alone."""

    def __init__(self) -> None:
        self._known: dict[str, _Known] = {}

    def read(self, features: Iterable[object]) -> None:
        """Take what the service lists as what there is: also of an earlier run, or by a request without an answer."""
        former, self._known = self._known, {}
        for feature in features:
            if not isinstance(feature, Mapping):
                continue
            uid, feature_id = uid_of(feature), feature.get("id")
            kind = feature.get("properties", {}).get("class")
            if uid is None or kind not in {"Marker", "Shape"}:
                continue
            if isinstance(feature_id, str) and feature_id:
                known = former.get(uid)
                payload = known.payload if known is not None and known.feature_id == feature_id else None
                self._known[uid] = _Known(kind, feature_id, payload)

    def next_change(self, wanted: Mapping[str, MapObject], withdrawn: Iterable[str], now_s: float) -> Change | None:
        """Return the next change that is due: findings that are none any more first, then markers, then shapes.

        Args:
            wanted: what is to be on the map.
            withdrawn: names of findings that must not be on it; what else is there of earlier sorties stays.
            now_s: real seconds of a steady clock.
        """
        for uid in withdrawn:
            known = self._known.get(uid)
            if known is not None:
                return Change(uid, known.kind, known.feature_id, None)
        for one in sorted(wanted.values(), key=lambda one: one.kind):
            known = self._known.get(one.uid)
            if known is None:
                return Change(one.uid, one.kind, None, one.payload)
            pause_s = CHANGED_S if one.kind == "Marker" else SHAPE_S
            if known.payload != one.payload and now_s - known.at_s >= pause_s:
                return Change(one.uid, one.kind, known.feature_id, one.payload)
        return None

    def made(self, change: Change, feature_id: str | None, now_s: float) -> None:
        """Note that a change was made; ``feature_id`` is the new object's."""
        if change.payload is None:
            self._known.pop(change.uid, None)
        elif (found := feature_id or change.feature_id) is not None:
            self._known[change.uid] = _Known(change.kind, found, change.payload, now_s)
