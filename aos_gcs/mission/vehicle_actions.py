"""Operators' actions on one vehicle: those of a pilot or taken over are left out, and each has a result."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final

from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.actions import ActionResult, Refusal

PILOTED: Final = Refusal("flown by its pilot")

VehicleAction = Callable[[Member], Awaitable[Refusal | None]]
"""Has a vehicle do something; returns why it does not."""


def unless_piloted(act: VehicleAction) -> VehicleAction:
    """Have an action skip vehicles that their pilots fly."""

    async def checked(member: Member) -> Refusal | None:
        return PILOTED if member.has_pilot else await act(member)

    return checked


def unless_taken_over(act: VehicleAction) -> VehicleAction:
    """Have an action on all skip vehicles that were taken over: they are given back one by one."""

    async def checked(member: Member) -> Refusal | None:
        taken_over = member.taken_over
        return Refusal(f"was taken over: {taken_over}. Resume this vehicle alone") if taken_over else await act(member)

    return checked


def result(vehicle_id: int, refusal: Refusal | None, done: str) -> ActionResult:
    """Return the result of an action: what it has done, or why it was refused."""
    return ActionResult(vehicle_id, accepted=refusal is None, text=done if refusal is None else refusal.text)
