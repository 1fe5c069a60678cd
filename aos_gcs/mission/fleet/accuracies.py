"""Accuracies that vehicles report of their positions, as separation takes them into account."""

from __future__ import annotations

from typing import Final

from aos_gcs.airspace.accuracy import CONFIDENCE, Accuracy, greatest_accuracy_m
from aos_gcs.mission.fleet.datum import RTK_FIXED
from aos_gcs.mission.fleet.member import Member
from aos_gcs.ports import VehicleState

_WITH_RTK: Final = Accuracy(0.03, 0.06)
_WITHOUT_RTK: Final = Accuracy(1.5, 3.0)
"""Accuracies of vehicles that report none."""


def accuracy_of(state: VehicleState) -> Accuracy:
    """Return the accuracy of a vehicle's position: as reported, else what receivers like its own reach."""
    usual = _WITH_RTK if state.gps_fix == RTK_FIXED else _WITHOUT_RTK
    horizontal_m, vertical_m = state.horizontal_accuracy_m, state.vertical_accuracy_m
    return Accuracy(
        usual.horizontal_m if horizontal_m is None else horizontal_m,
        usual.vertical_m if vertical_m is None else vertical_m,
    )


def accuracy_on_paths(member: Member, separation_m: float, layer_spacing_m: float) -> Accuracy:
    """Return the accuracy of a vehicle's position that new paths take into account.

    Its vertical part is not more than the layers bear: preflight has found it so, or an operator has overridden that,
    and vehicles in neighbouring layers would block each other. Of a vehicle that was found inaccurate in flight, and
    leaves, it is taken as reported. What a vehicle's altitude was found to be wrong by in flight, and what its reports
    have jumped by, is added whole.
    """
    accuracy = accuracy_of(member.state)
    borne_m = max(0.0, greatest_accuracy_m(separation_m, layer_spacing_m))
    vertical_m = accuracy.vertical_m if member.is_inaccurate else min(accuracy.vertical_m, borne_m)
    return Accuracy(
        accuracy.horizontal_m + member.position_doubt_m / CONFIDENCE, vertical_m + member.altitude_doubt_m / CONFIDENCE
    )
