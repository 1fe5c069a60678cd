"""``aos-gcs lab missions``: tiny missions over an open meadow, in virtual time."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.cluster import MAX_JOBS
from aos_gcs.lab.flights import FlightParameters, build_flight
from aos_gcs.lab.missions.store import MISSIONS_FILE
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.search_settings import LookOrder, SearchSettings
from aos_gcs.runtime.simulated.virtual_mission import fly, mission_settings
from tests.fakes.command_line import exit_status

SMALL = ("--densities", "20", "--vehicles", "3", "--side", "25", "--image-size", "128", "--errors", "none")
STUDY = ("--missions", "1", "--no-person", "1", "--seed", "11")
"""A seed with short missions: how often such missions are right is measured by the command, not by its test."""


def command(*arguments: str) -> int:
    return exit_status(["--log-level", "info", "lab", "missions", *arguments])


@pytest.mark.timeout(600)
def test_missions_are_flown_judged_and_written_down(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, document = tmp_path / "study", tmp_path / "missions.md"
    options = ("--out", str(out), "--document", str(document), "--jobs", "1", *SMALL, *STUDY)
    assert command(*options) == 0
    table, said = capsys.readouterr()
    assert "Taking off" not in said
    lines = (out / MISSIONS_FILE).read_text(encoding="utf-8").splitlines()
    found, empty = sorted(map(json.loads, lines), key=lambda line: line["key"]["has_person"], reverse=True)
    for result in (found, empty):
        assert result["landed"] == 3
        assert result["coverage"] > 0.95
        assert result["min_separation_m"] >= UNLIMITED.separation_m
        assert result["duration_s"] > 60.0
    assert (found["persons_found"], found["claims"], empty["claims"]) == (1, 1, 0)
    assert found["errors_m"][0] < 0.5
    assert 0.0 < found["claimed_after_s"][0] < found["duration_s"]
    stated = list(zip(found["probabilities"], found["is_person"], strict=True))
    assert max(probability for probability, is_person in stated if is_person) > 0.5
    assert not any(empty["is_person"])
    assert len(empty["probabilities"]) == len(empty["is_person"]) > 0, "of animals and stones, too"
    assert "| 20 | cool | none | 1, 1 | 1 of 1: 100 %" in table
    assert document.read_text(encoding="utf-8").endswith(f"{table.rstrip()}\n\n<!-- End of the written part -->\n")

    # What is there is not flown again.
    assert command(*options) == 0
    assert capsys.readouterr().out == table
    assert (out / MISSIONS_FILE).read_text(encoding="utf-8").splitlines() == lines

    # Compared with itself, pair by pair, it differs in nothing.
    assert command(*options, "--reference", str(out)) == 0
    assert "| persons found, share | 1 | 1.00 | 1.00 | +0.00 |" in capsys.readouterr().out
    assert "| persons found, share | 1 | 1.00 | 1.00 | +0.00 |" in document.read_text(encoding="utf-8")


def test_vehicles_without_corrections_take_off_and_keep_apart(tmp_path: Path) -> None:
    out = tmp_path / "study"
    alone = ("--missions", "1", "--no-person", "0", "--seed", "7", "--side", "20", "--vehicles", "2")
    assert command("--out", str(out), *SMALL, *alone, "--image-size", "64", "--errors", "gnss") == 0
    result = json.loads((out / MISSIONS_FILE).read_text(encoding="utf-8"))
    assert (result["landed"], result["coverage"] > 0.95) == (2, True)
    assert result["min_separation_m"] >= UNLIMITED.separation_m


def test_the_coordinator_flies_legs_that_are_given() -> None:
    flight = build_flight(
        FlightParameters(
            seed=3,
            vehicles=1,
            trees_per_ha=0.0,
            has_person=False,
            errors="none",
            conditions="cool",
            side_m=20.0,
            image_size_px=64,
        )
    )
    middle_m = np.mean(flight.area_enu_m, axis=0)
    side = math.sqrt(0.5)
    slanting = ScanLeg((float(middle_m[0]) - 8.0, float(middle_m[1]) - 8.0), (side, side), 16.0)
    legs = (slanting, replace(slanting.reversed, length_m=10.0))
    at_once = SearchSettings(looks=LookOrder.FIRST)  # else ways to what is left for later follow the last leg
    flown = fly(flight, mission_settings(flight, 1, "aos-apso", 3, search=at_once), legs=legs)
    assert flown.snapshot.legs_enu_m == tuple((leg.start_enu_m, leg.end_enu_m) for leg in legs)
    assert flown.snapshot.leg == len(legs)
    assert flight.landed == 1


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--errors", "perfect"), "--errors must be one of none, rtk, gnss, got 'perfect'"),
        (("--errors", "gnss", "--layer-spacing", "2"), "do not take off. Preflight did not pass"),
        (("--layer-spacing", "0"), "--layer-spacing must lie within 1 and 100"),
        (("--launch-spacing", "nan"), "--launch-spacing must lie within 1 and 20"),
        (("--conditions", "hail"), "conditions must be one of"),
        (("--vehicles", "0"), "vehicles must lie within 1 and 100"),
        (("--search", "hovering"), "--search must be one of continuous, stops, split, got 'hovering'"),
        (("--missions", "0", "--no-person", "0"), "--seed, --missions and --no-person"),
        (("--legs", "chosen"), "--legs chosen needs --pod"),
        (("--jobs", "0"), f"--jobs must lie within 1 and {MAX_JOBS}"),
        (("--reference", "nowhere"), "--reference nowhere holds no study of missions"),
        (("--densities", "many"), "--densities must be numbers"),
    ],
)
def test_wrong_options_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, str], expected: str
) -> None:
    assert command("--out", str(tmp_path / "study"), *SMALL, *STUDY, *options) == 2
    assert expected in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    "options", [("--conditions", "cool,hail"), ("--errors", "rtk,perfect"), ("--terrain", "slope:900")]
)
def test_what_the_simulator_cannot_build_is_refused_before_the_first_mission(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, str]
) -> None:
    assert command("--out", str(tmp_path / "study"), "--densities", "300", *STUDY, *options) == 2
    assert options[0][2:] in capsys.readouterr().err
    assert not (tmp_path / "study").exists()
