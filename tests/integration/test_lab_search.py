"""``aos-gcs lab search``: whole searches for a person between few trees, by rays."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.lab.search.model import Conditions, Method, plan_for
from aos_gcs.lab.search.store import RESULTS_FILE
from aos_gcs.lab.search.study import search_flight
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.estimate import estimate_plan
from aos_gcs.planning.settings import MissionSettings
from tests.fakes.command_line import exit_status

SMALL = ("--searches", "2", "--densities", "150", "--hectares", "0.25", "--vehicles", "2", "--passes", "2")


def command(*arguments: str) -> int:
    return exit_status(["--log-level", "error", "lab", "search", *arguments])


def test_persons_are_searched_for_by_all_flights_and_written_down(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, document = tmp_path / "study", tmp_path / "searches.md"
    methods = ("--methods", ",".join(Method), "--spread", "0.1")
    options = ("--out", str(out), "--document", str(document), *SMALL, *methods)
    assert command(*options) == 0
    table = capsys.readouterr().out
    lines = (out / RESULTS_FILE).read_text(encoding="utf-8").splitlines()
    outcomes = [one for line in lines for one in json.loads(line)["outcomes"]]
    assert len(outcomes) == 2 * len(Method)
    for one in outcomes:
        assert one["views"] > 0
        assert 0.0 < one["predicted"] <= 1.0
        assert one["noticed"] <= (one["claimed_s"] is not None)
    assert "| 150 | 0.25 ha | 2 | planned |" in table
    assert table.rstrip() in document.read_text(encoding="utf-8")

    # What is there is not searched again.
    assert command(*options) == 0
    assert capsys.readouterr().out == table
    assert (out / RESULTS_FILE).read_text(encoding="utf-8").splitlines() == lines


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--methods", "planned,hover"), "--methods must be one of"),
        (("--posture", "prone"), "--posture must be one of"),
        (("--hectares", "many"), "--hectares must be numbers"),
        (("--hectares", "60"), "hectares must lie within"),
        (("--vehicles", "nan"), "--vehicles must be numbers"),
        (("--vehicles", "2.7"), "--vehicles must be whole numbers"),
        (("--vehicles", "2,2"), "--vehicles must be numbers separated by commas, each once"),
        (("--searches", "0"), "--searches must be at least 1"),
        (("--methods", "planned,prior"), "the method prior needs --spread"),
        (("--spread", "0"), "spread must lie within"),
        (("--rate", "0"), "rate must lie within"),
    ],
)
def test_what_cannot_be_searched_is_refused(
    tmp_path: Path, options: tuple[str, str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command("--out", str(tmp_path / "study"), *options) != 0
    assert words in " ".join(capsys.readouterr().err.split())


def test_flights_are_those_of_plans_that_can_be_flown_and_more_frames_make_them_faster() -> None:
    plans = [plan_for(0.9, Conditions(300.0, 10, 4.0, rate_hz)) for rate_hz in (2.0, 3.0)]
    settings = MissionSettings(vehicles=10, area_enu_m=plans[0].area_enu_m, imaging=ImagingSettings())
    assert not [problem for plan in plans for problem in check_plan(plan, settings) if problem.blocking]
    slow, fast = (search_flight(0.9, Conditions(300.0, 10, 4.0, plan.rate_hz), Method.PLANNED) for plan in plans)
    assert slow is not None
    assert fast is not None
    assert fast.duration_s < slow.duration_s


@pytest.mark.parametrize("method", Method)
def test_flights_stay_in_the_area_and_take_the_time_of_their_estimate(method: Method) -> None:
    conditions = Conditions(300.0, 2, 0.5)
    flight = search_flight(0.5, conditions, method)
    assert flight is not None
    half_m = math.sqrt(5000.0) / 2.0
    assert (np.diff(flight.times_s) >= 0.0).all()
    assert 0.0 < flight.times_s[0] < flight.times_s[-1] < flight.duration_s
    places_m = flight.cameras_enu_m[:, :2]
    if method is Method.CHOSEN_LEGS:
        # The middle of the line does: both vehicles expose in one front, a spacing apart, at the same time.
        pairs_m, times_s = places_m.reshape(-1, 2, 2), flight.times_s.reshape(-1, 2)
        assert (times_s[:, 0] == times_s[:, 1]).all()
        assert np.ptp(np.linalg.norm(pairs_m[:, 0] - pairs_m[:, 1], axis=1)) < 1e-6
        places_m = pairs_m.mean(axis=1)
    assert np.abs(places_m).max() <= half_m + 1e-6
    assert set(flight.cameras_enu_m[:, 2]) <= {35.0, 37.5}
    if method is Method.LINE:
        estimate = estimate_plan(plan_for(0.5, conditions), 0.0)
        assert flight.duration_s == pytest.approx(estimate.flight_s, rel=0.1)
        assert flight.path_m == pytest.approx(2.0 * estimate.path_m)
