"""What the coordinator learns from its frames: the focal plane and the errors of poses. In virtual time."""

from __future__ import annotations

import math

import pytest

from aos_gcs.errors import MissionError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.steps import FocusSnapshot, FocusSource
from aos_gcs.planning.settings import AutofocusSettings, DetectionSettings, RegistrationSettings
from tests.fakes import fleet
from tests.fakes.mission_flight import TARGET, Flight, flying, prepare

pytestmark = pytest.mark.virtual


def focus_of(flight: Flight) -> FocusSnapshot:
    focus = flight.view.snapshot().focus
    assert focus is not None
    return focus


async def test_autofocus_repairs_a_plane_that_is_three_metres_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fleet, "CAMERA", CameraModel.from_fov(192, 192, math.radians(50.0)))
    flight = prepare(
        n=4,
        target=(0.0, 40.0),
        imaging=ImagingSettings(rx_quantile=0.998, plane_height_m=3.0),
        detection=DetectionSettings(threshold_m2=0.3, found_steps=40, look_steps=400),
        autofocus=AutofocusSettings(enabled=True, interval_steps=2),
    )
    async with flying(flight) as run:
        await flight.until(lambda: focus_of(flight).source is FocusSource.AUTOFOCUS)
        found_at = flight.view.snapshot().step
        await flight.until(lambda: flight.view.snapshot().step > found_at + 8)
        await flight.commands.act(Action.ABORT, None)
        await run
    heights_m = [step.focal_height_m for step in flight.view.steps()]
    assert heights_m[0] == 3.0
    assert heights_m[-1] == pytest.approx(0.0, abs=1.0)
    assert any("Autofocus: focal plane at" in text for text in flight.texts())


async def test_the_operators_height_wins_until_it_is_given_back() -> None:
    flight = prepare(n=4, target=None)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await flight.commands.act(Action.FOCUS, None, 2.0)
        focus = focus_of(flight)
        assert (focus.height_m, focus.source) == (2.0, FocusSource.OPERATOR)
        step = flight.view.snapshot().step
        await flight.until(lambda: flight.view.snapshot().step > step + 1)
        assert flight.view.steps()[-1].focal_height_m == 2.0
        await flight.commands.act(Action.FOCUS, None, None)
        focus = focus_of(flight)
        assert (focus.height_m, focus.source) == (0.0, FocusSource.CONFIGURED)
        await flight.commands.act(Action.ABORT, None)
        await run
    recorded = [(entry.action, entry.focal_height_m) for entry in flight.recorder.actions]
    assert recorded == [(Action.FOCUS, 2.0), (Action.FOCUS, None), (Action.ABORT, None)]


async def test_a_height_that_makes_no_sense_is_refused_and_logged() -> None:
    flight = prepare(n=4, target=None)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        with pytest.raises(MissionError, match="below the lowest layer, 35 m"):
            await flight.commands.act(Action.FOCUS, None, 40.0)
        with pytest.raises(MissionError, match="at least -50 m above the origin"):
            await flight.commands.act(Action.FOCUS, None, -100_000.0)
        with pytest.raises(MissionError, match="leave the vehicles out"):
            await flight.commands.act(Action.FOCUS, (1,), 2.0)
        with pytest.raises(MissionError, match="leave the height out"):
            await flight.commands.act(Action.HOLD, None, 2.0)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert [entry.refusal is not None for entry in flight.recorder.actions] == [True, True, True, True, False]


async def test_registration_that_is_not_sure_changes_nothing() -> None:
    """The fake frames have nothing but the target in common: no pose may be touched."""
    flight = prepare(n=4, registration=RegistrationSettings(enabled=True))
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    target = flight.view.snapshot().target
    assert target is not None
    assert target.position_enu_m[:2] == pytest.approx(TARGET, abs=0.5)
    assert not any("registration" in text for text in flight.texts())
