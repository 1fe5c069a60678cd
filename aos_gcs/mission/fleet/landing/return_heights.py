"""Failsafe return heights of the vehicles: their altitude layers during the mission, then their own again."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping

from aos_gcs.errors import CommandError
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity, VehicleFacts

PURPOSE = "return height"
_MAX_HEARD_AGO_S = 3.0
_DECIMALS = 2
"""Decimals of metres that autopilots store."""


class ReturnHeights:
    """Sets the vehicles' failsafe return heights to their layers before they start, and restores them at the end.

    Nothing is written unless ``preflight.set_return_height`` says so, and never while motors run.

    Args:
        context: context of the mission.
        settings: settings of the mission; those used here are no part of a plan.
        unrestored: settings that vehicles had before a former mission changed them and did not restore them, by id.
    """

    def __init__(
        self,
        context: MissionContext,
        settings: MissionSettings,
        unrestored: Mapping[int, Mapping[str, float]] | None = None,
    ) -> None:
        self._context = context
        self._is_wanted = settings.preflight.set_return_height
        self._command_s = settings.deadlines.command_s
        self._unrestored = dict(unrestored or {})
        self._former: dict[int, Mapping[str, float]] = {}
        """Settings before the mission, by vehicle."""

    def wanted_m(self, member: Member) -> AboveHomeM | None:
        """Return the failsafe return height above home that a vehicle is to have; None where it is left unchanged."""
        height_m = self._context.roster.layers.return_above_home_m(member) if self._is_wanted else None
        return None if height_m is None else AboveHomeM(round(height_m, _DECIMALS))

    async def adopt(self, member: Member, facts: VehicleFacts) -> None:
        """Take over the duty to restore settings that a former mission has left on a vehicle.

        What the vehicle has now is then not its own. Settings of other names are those of another vehicle.
        """
        former = self._unrestored.get(member.vehicle_id)
        if former is None or not self._is_wanted or member.vehicle_id in self._former:
            return
        if former.keys() != facts.return_settings.keys() or former == facts.return_settings:
            return
        self._former[member.vehicle_id] = former
        await self._record(member, former, is_restored=False)
        text = f"an earlier mission left its failsafe return height changed: this one restores {_in_words(former)}"
        self._context.journal.notice(Severity.WARNING, text, member.vehicle_id)

    async def set(self, member: Member, facts: VehicleFacts, height_m: AboveHomeM, deadline_s: float) -> None:
        """Set a vehicle's return height, after its former one was recorded.

        Raises:
            CommandError: the vehicle refuses or does not answer.
        """
        if member.vehicle_id not in self._former:
            self._former[member.vehicle_id] = facts.return_settings
            await self._record(member, facts.return_settings, is_restored=False)
        await member.vehicle.set_return_height(height_m, deadline_s)
        text = f"failsafe return height set to {height_m:g} m, its altitude layer, until it has landed"
        self._context.journal.notice(Severity.INFO, text, member.vehicle_id)

    async def restore(self) -> None:
        """Restore the settings of all vehicles on the ground, and report those that do not take them."""
        members = self._context.roster.select(self._former)
        await asyncio.gather(*[self._restore(member, self._former[member.vehicle_id]) for member in members])

    async def _restore(self, member: Member, former: Mapping[str, float]) -> None:
        context, link_age_s = self._context, self._context.roster.link_age_s(member)
        try:
            if link_age_s is None or link_age_s > _MAX_HEARD_AGO_S:
                raise CommandError("its link is lost")
            deadline_s = context.clock.now_s() + self._command_s
            await member.vehicle.restore_return(former, deadline_s)
        except CommandError as error:
            text = f"failsafe return height not restored ({error}). Set it by hand: {_in_words(former)}"
            context.journal.notice(Severity.WARNING, text, member.vehicle_id)
            return
        context.journal.notice(Severity.INFO, "failsafe return height restored", member.vehicle_id)
        await self._record(member, former, is_restored=True)

    async def _record(self, member: Member, former: Mapping[str, float], *, is_restored: bool) -> None:
        context = self._context
        record = SettingsRecord(context.clock.utc_s(), member.vehicle_id, PURPOSE, former, is_restored)
        async with context.journal.with_disk_timeout(f"{PURPOSE} of vehicle {member.vehicle_id}"):
            await context.recorder.record_settings(record)
            await context.recorder.flush()


def _in_words(settings: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in settings.items())
