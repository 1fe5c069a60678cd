"""Whole missions over bad radio links: found, no vehicle too near to another, no command to a wrong vehicle."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.phase import Outcome
from tests.fakes.air import Air, Faults
from tests.fakes.air_flight import flying_over

pytestmark = [pytest.mark.looptime, pytest.mark.slow, pytest.mark.timeout(900)]


@pytest.mark.parametrize(
    "faults",
    [
        pytest.param(Faults(loss=0.2), id="a fifth is lost"),
        pytest.param(Faults(loss=0.05), id="a twentieth is lost"),
        pytest.param(Faults(burst=0.002, burst_length=60.0), id="bursts are lost"),
        pytest.param(Faults(duplicate=0.3), id="copies arrive"),
        pytest.param(Faults(reorder=0.3), id="others overtake"),
        pytest.param(Faults(latency_s=0.5), id="half a second late"),
        pytest.param(Faults(corrupt=0.1), id="bytes are changed"),
        pytest.param(
            Faults(loss=0.1, duplicate=0.1, reorder=0.1, latency_s=0.25, corrupt=0.05),
            id="everything at once",
        ),
    ],
)
async def test_a_bad_radio_link_does_not_keep_a_mission_from_its_end(
    monkeypatch: pytest.MonkeyPatch, faults: Faults
) -> None:
    # A changed length makes a vehicle's parser swallow up to twelve heartbeats, and two in a row more than twenty:
    # longer than the failsafe's usual 5 s.
    patience = {"FS_GCS_TIMEOUT": 60.0}
    async with flying_over(monkeypatch, Air(faults), vehicles=2, parameters=patience) as flight:
        assert await flight.run is Outcome.FOUND
        assert flight.swarm.report().landed == 2
        flight.assert_nobody_was_endangered()


@pytest.mark.parametrize("seed", range(4))
async def test_px4_flies_through_loss_and_disorder(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    faults = Faults(loss=0.2, duplicate=0.1, reorder=0.1, latency_s=0.2)
    async with flying_over(monkeypatch, Air(faults, seed), vehicles=3, autopilot="px4") as flight:
        assert await flight.run is Outcome.FOUND
        assert flight.swarm.report().landed == 3
        flight.assert_nobody_was_endangered()
