"""A station that was killed in flight, and the one that follows it."""

from __future__ import annotations

from aos_gcs.mission.former_flight import FormerFlight
from aos_gcs.mission.model.snapshot import MissionSnapshot
from tests.fakes.fleet import FRAME
from tests.fakes.mission_flight import Flight, flying, prepare


async def killed_while_searching(flight: Flight, steps: int) -> MissionSnapshot:
    """Fly until so many steps are made, and return the last state on record."""
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == steps)
        last = flight.view.snapshot()
        run.cancel()
    return last


def restarted(last: MissionSnapshot, **changes: object) -> Flight:
    """Return the station that follows, its vehicles where they were, without any command of it so far.

    ``changes`` are those of :func:`prepare`.
    """
    flight = prepare(len(last.vehicles), **{"former": FormerFlight(last, None, 0.0), **changes})
    for former in last.vehicles:
        vehicle = flight.fleet.members[former.telemetry.vehicle_id]
        assert former.telemetry.position is not None
        vehicle.armed = True
        vehicle.start_enu_m = vehicle.goal_enu_m = FRAME.to_enu(former.telemetry.position)
    return flight
