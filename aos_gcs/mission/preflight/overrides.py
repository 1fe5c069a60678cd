"""Overrides of failed checks: by whom, why and for how long; every one is on record."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from aos_gcs.errors import MissionError
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.journal import Recorder
from aos_gcs.mission.model.actions import Action, ActionRecord
from aos_gcs.mission.model.checks import CheckOverride, CheckStatus, PreflightCheck
from aos_gcs.ports import Severity

BY_CONFIGURATION = "configuration"


@dataclass(frozen=True, slots=True)
class _Grant:
    """Override and the finding that it was granted for."""

    override: CheckOverride
    finding: tuple[CheckStatus, str]


class Overrides:
    """The overrides of one mission. Each holds for one check of one vehicle, for as long as that finds the same.

    "The same" is status and remedy: a battery that goes on draining is the same problem, a fence that turns out to be
    another one after it was missing is not.
    """

    def __init__(self, context: FlightContext, recorder: Recorder) -> None:
        self._context = context
        self._recorder = recorder
        self.checks: tuple[PreflightCheck, ...] = ()
        """The matrix vehicle x check as it was reviewed last."""
        self._grants: dict[tuple[int, str], _Grant] = {}

    async def review(self, checks: Iterable[PreflightCheck]) -> tuple[PreflightCheck, ...]:
        """Apply the overrides to the whole matrix, and keep it."""
        self.checks = await self.apply(checks)
        return self.checks

    async def apply(self, checks: Iterable[PreflightCheck]) -> tuple[PreflightCheck, ...]:
        """Return the checks with the overrides in force; those of the configuration are granted here, on record."""
        return tuple([await self._apply(check) for check in checks])

    async def decide(self, vehicle_id: int, name: str, reason: str | None, operator: str) -> PreflightCheck:
        """Decide on a check; see ``MissionCommands.override_check``. Refused decisions are in the audit log, too."""
        try:
            check = self._failed(vehicle_id, name)
            override = self._override(reason, operator) if reason is not None else None
        except MissionError as error:
            await self._record(vehicle_id, name, reason, operator, str(error))
            raise
        await self._settle(check, override, operator)
        decided = replace(check, overridden=override)
        self.checks = tuple(decided if one is check else one for one in self.checks)
        return decided

    async def _apply(self, check: PreflightCheck) -> PreflightCheck:
        key = (check.vehicle_id, check.name)
        grant = self._grants.get(key)
        if grant is not None and grant.finding != _finding(check):
            del self._grants[key]
            text = f"{check.name}: override ended, the result of the check has changed"
            self._context.journal.notice(Severity.INFO, text, check.vehicle_id or None)
            grant = None
        if grant is not None:
            return replace(check, overridden=grant.override)
        reason = self._context.settings.preflight.overrides.get(check.name)
        if reason is None or not check.overridable or check.status is not CheckStatus.FAIL:
            return check
        override = self._override(reason, BY_CONFIGURATION)
        await self._settle(check, override, BY_CONFIGURATION)
        return replace(check, overridden=override)

    def _failed(self, vehicle_id: int, name: str) -> PreflightCheck:
        """Return a failed check that may be overridden."""
        checks = [check for check in self.checks if check.vehicle_id == vehicle_id]
        check = next((check for check in checks if check.name == name), None)
        if check is None:
            known = ", ".join(check.name for check in checks) or "none"
            raise MissionError(f"No check {name!r} of vehicle {vehicle_id}; its checks are: {known}.")
        if check.status is not CheckStatus.FAIL:
            raise MissionError(f"Nothing to override: {name} of vehicle {vehicle_id} has not failed ({check.text}).")
        if not check.overridable:
            raise MissionError(f"{name} of vehicle {vehicle_id} cannot be overridden: {check.remedy}.")
        return check

    def _override(self, reason: str, by: str) -> CheckOverride:
        if not reason.strip():
            raise MissionError("An override needs a reason: it is kept in the record of the mission.")
        return CheckOverride(reason.strip(), by, self._context.clock.utc_s())

    async def _settle(self, check: PreflightCheck, override: CheckOverride | None, by: str) -> None:
        key, journal = (check.vehicle_id, check.name), self._context.journal
        if override is None:
            self._grants.pop(key, None)
            journal.notice(
                Severity.INFO, f"{check.name}: override withdrawn by {by or 'the operator'}", check.vehicle_id or None
            )
            await self._record(*key, None, by)
            return
        self._grants[key] = _Grant(override, _finding(check))
        text = f"{check.name} ({check.text}) overridden by {by or 'the operator'}: {override.reason}"
        journal.notice(Severity.WARNING, text, check.vehicle_id or None)
        await self._record(*key, override.reason, by)

    async def _record(
        self, vehicle_id: int, name: str, reason: str | None, by: str, refusal: str | None = None
    ) -> None:
        context = self._context
        record = ActionRecord(
            context.clock.utc_s(),
            Action.OVERRIDE,
            (vehicle_id,),
            (),
            refusal,
            operator=by,
            check=name,
            reason=reason,
        )
        async with context.journal.with_disk_timeout(f"the override of {name}"):
            await self._recorder.record_action(record)


def _finding(check: PreflightCheck) -> tuple[CheckStatus, str]:
    return check.status, check.remedy
