"""``aos-gcs demo`` from its start to its result, as a process of its own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.imaging.persons.decision import DECISION
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.runtime.simulated.demo_terrain import FLOOR_ABOVE_GROUND_M
from aos_gcs.store.reader import MissionReader
from tests.fakes.command_line import exit_status
from tests.fakes.program import Program, running

KEYS = {
    "found",
    "person_found",
    "claims",
    "false_claims",
    "person_probability",
    "target_error_m",
    "target_height_error_m",
    "time_to_detection_s",
    "visibility_max",
    "visibility_final",
    "steps",
    "vehicles",
    "landed",
    "min_separation_m",
    "min_height_above_ground_m",
    "mission_dir",
}
SEPARATION_M = UNLIMITED.separation_m
SMALL = (
    *("--vehicles", "4", "--image-size", "128", "--trees-per-ha", "30", "--seed", "2", "--speed", "6"),
    *("--errors", "none", "--animals", "0", "--stones", "0"),
)
"""Few trees, so that the person is seen whatever way the swarm takes."""


def check_result(program: Program, vehicles: int) -> None:
    result = program.result()
    assert set(result) == KEYS
    assert result["found"] is result["person_found"] is True
    assert (result["claims"], result["false_claims"]) == (1, 0)
    assert result["person_probability"] >= DECISION
    assert result["vehicles"] == result["landed"] == vehicles
    assert result["target_error_m"] <= 1.0
    assert result["time_to_detection_s"] > 0.0
    # Leaves may hide the person from the last step, of vehicles that fly by the machine's clock.
    assert 0.0 <= result["visibility_final"] <= result["visibility_max"]
    assert 0.0 < result["visibility_max"] <= 1.0
    assert result["min_separation_m"] >= SEPARATION_M
    assert Path(result["mission_dir"]) == program.mission_folder


def inspect(folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert exit_status(["inspect", str(folder), "--json"]) == 0
    report: dict[str, object] = json.loads(capsys.readouterr().out)
    return report


async def test_a_small_demo_finds_the_person_lands_all_and_is_recorded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async with running(tmp_path, "demo", *SMALL, "--headless", "--json") as program:
        code = await program.ended(100)
    assert code == 0, program.log
    check_result(program, vehicles=4)
    result = program.result()
    with MissionReader(program.mission_folder) as reader:
        steps, outcome, final = reader.steps(), reader.outcome(), reader.last_snapshot()
        frames = reader.frames(steps[-1].step)
        assert frames[0].load().image.shape == (128, 128, 4)
        assert reader.manifest()["configuration"]["mission"]["seed"] == 2
    assert len(steps) == result["steps"]
    assert outcome is not None
    assert outcome.outcome is Outcome.FOUND
    assert final is not None
    assert final.phase is Phase.DONE
    assert [vehicle.task for vehicle in final.vehicles] == [Task.LANDED] * 4
    (traffic,) = program.mission_folder.rglob("*.tlog")
    assert traffic.stat().st_size > 10_000
    status = exit_status(["replay", str(program.mission_folder), "--verify"])
    assert capsys.readouterr().out == f"identical: {result['steps']} steps computed again\n"
    assert status == 0
    report = inspect(program.mission_folder, capsys)
    assert len(report["steps"]) == result["steps"]
    assert [span["phase"] for span in report["phases"]][-1] == "done"


@pytest.mark.slow
async def test_px4_vehicles_fly_the_same_mission(tmp_path: Path) -> None:
    async with running(tmp_path, "demo", *SMALL, "--autopilot", "px4", "--headless", "--json") as program:
        code = await program.ended(100)
    assert code == 0, program.log
    check_result(program, vehicles=4)


@pytest.mark.slow
async def test_a_demo_over_a_slope_knows_its_ground(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rasterio")
    async with running(tmp_path, "demo", *SMALL, "--terrain", "slope:20", "--headless", "--json") as program:
        code = await program.ended(100)
    assert code == 0, program.log
    check_result(program, vehicles=4)
    assert program.result()["min_height_above_ground_m"] >= FLOOR_ABOVE_GROUND_M
    status = exit_status(["replay", str(program.mission_folder), "--verify"])
    assert capsys.readouterr().out.startswith("identical")
    assert status == 0


async def fly_default_mission(folder: Path, seed: int) -> dict[str, object]:
    async with running(folder, "demo", "--headless", "--exit-when-done", "--json", "--seed", str(seed)) as program:
        await program.ended(900)
    return program.result()


def check_default_results(results: list[dict[str, object]]) -> None:
    assert all(result["found"] for result in results)
    assert all(result["landed"] == result["vehicles"] == 10 for result in results)
    assert all(result["min_separation_m"] >= SEPARATION_M for result in results)
    misses = [result["target_error_m"] for result in results if result["target_error_m"] > 1.0]
    assert len(misses) <= len(results) // 10


@pytest.mark.slow
@pytest.mark.timeout(10 * 900)
async def test_the_person_is_found_on_ten_seeds(tmp_path: Path) -> None:
    check_default_results([await fly_default_mission(tmp_path / str(seed), seed) for seed in range(1, 11)])
