"""A recorded mission judged by the simulator's truth."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.walks import Walk
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase, Suspension
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import Task, VehicleSnapshot
from aos_gcs.ports import Capture, VehicleState
from aos_gcs.runtime.simulated.evaluation import Score, score_mission
from aos_gcs.runtime.simulated.truth_file import check_world, read_world
from aos_gcs.store.recorder import MissionRecorder
from aos_sim.truth import unoccluded_areas_m2
from aos_sim.world.scene import SceneParameters, build_scene
from aos_sim.world_file import Target, World, write_world_file

ORIGIN = GeodeticPosition(48.3, 14.3, 260.0)
SEED, TREES_PER_HA = 3, 20.0
START_UTC_S = 0.0
"""The frames of a step are of as many seconds later."""
CAMERA = CameraModel.from_fov(64, 64, math.radians(50.0))


@pytest.fixture(scope="module")
def person_enu_m() -> np.ndarray:
    (person,) = build_scene(SceneParameters(seed=SEED, trees_per_ha=TREES_PER_HA)).persons
    return np.array(person.position_enu_m)


def claim(finding_id: int, position_enu_m: EnuPoint, kind: FindingKind = FindingKind.PERSON) -> Finding:
    return Finding(
        finding_id, FindingStatus.NEW, position_enu_m, 70.5, 90.0, 2, track_id=1, person_confidence=0.8, kind=kind
    )


def snapshot(target_enu_m: EnuPoint | None, tasks: tuple[Task, ...], outcome: Outcome) -> MissionSnapshot:
    vehicles = [
        VehicleSnapshot(VehicleState(number + 1), task, None, None, None, None, None)
        for number, task in enumerate(tasks)
    ]
    return MissionSnapshot(
        mission_id="m",
        strategy="aos-apso",
        phase=Phase.DONE,
        suspension=Suspension.NONE,
        outcome=outcome,
        message="",
        elapsed_s=100.0,
        step=2,
        origin=ORIGIN,
        area_enu_m=(),
        fence_enu_m=(),
        vehicles=tuple(vehicles),
        preflight=(),
        target=None,
        findings=() if target_enu_m is None else (claim(1, target_enu_m),),
        min_separation_m=9.0,
    )


def step(number: int, visibility_m2: float, target_enu_m: EnuPoint | None) -> StepRecord:
    return StepRecord(
        step=number,
        elapsed_s=float(number),
        phase=Phase.CONVERGE,
        visibility_m2=visibility_m2,
        threshold_m2=0.1,
        branch="pso",
        evolutionary_factor=None,
        evolutionary_state=None,
        c_s_m=None,
        c_c_m=None,
        leader_id=1,
        target_enu_m=target_enu_m,
        fitness={1: visibility_m2},
        missing={},
        waypoints=(),
        imaging_ms=1.0,
        work_ms=1.0,
        loop_lag_p99_ms=1.0,
    )


@dataclass
class Recorded:
    """A mission of two steps, with one camera above the person."""

    folder: Path
    person_enu_m: np.ndarray
    pictured_m2: float
    """What that camera would see of the person without a forest."""
    walk: Walk | None = None

    def score(self, of: MissionSnapshot, report: bool = True, origin: GeodeticPosition = ORIGIN) -> Score:
        """``origin`` is the world's."""
        offset_enu_m = LocalFrame(origin).to_enu(ORIGIN)
        world, truth = self.folder.parent / "world.json", self.folder.parent / "report.json"
        targets = (Target("person", tuple(map(float, self.person_enu_m + offset_enu_m)), 1.8, self.walk),)
        write_world_file(world, World((), targets, SEED, TREES_PER_HA), origin, {}, START_UTC_S)
        if report:
            truth.write_text(json.dumps({"min_separation_m": 2.5, "min_height_above_ground_m": 31.5}), encoding="utf-8")
        return score_mission(of, self.folder, world, truth)


async def record(
    folder: Path, person_enu_m: np.ndarray, shares: tuple[float, float], blobs: list[EnuPoint]
) -> Recorded:
    pose = nadir_pose(person_enu_m + np.array([2.0, 0.0, 40.0]))
    (pictured_m2,) = unoccluded_areas_m2({"seed": SEED, "trees_per_ha": TREES_PER_HA}, [[(pose, CAMERA)]])
    async with MissionRecorder.create(folder, "m", {}, notify=lambda _: None) as recorder:
        for number, (share, blob_enu_m) in enumerate(zip(shares, blobs, strict=True), start=1):
            capture = Capture(
                vehicle_id=1,
                image_index=number,
                utc_s=float(number),
                image=np.zeros((64, 64, 3), np.uint8),
                bands=("red", "green", "blue"),
                position=LocalFrame(ORIGIN).to_geodetic(pose.position_enu_m),
                R_cam2enu=pose.R_cam2enu,
                camera=CAMERA,
            )
            await recorder.record_frame(number, capture)
            await recorder.record_step(step(number, share * pictured_m2, blob_enu_m), {"state": 1})
        await recorder.record_outcome(OutcomeRecord(100.0, Outcome.FOUND, {"time_to_detection_s": 70.5}))
    return Recorded(folder / "m", person_enu_m, pictured_m2)


def beside(person_enu_m: np.ndarray, east_m: float) -> EnuPoint:
    east, north, _ = (float(value) for value in person_enu_m)
    return (east + east_m, north, 0.0)


async def test_a_found_person_is_measured_against_the_truth(tmp_path: Path, person_enu_m: np.ndarray) -> None:
    blobs = [beside(person_enu_m, 1.0), beside(person_enu_m, 0.0)]
    recorded = await record(tmp_path, person_enu_m, (0.75, 0.25), blobs)
    tasks = (Task.LANDED, Task.LANDED, Task.LOST)
    score = recorded.score(snapshot(beside(person_enu_m, 0.6), tasks, Outcome.FOUND))
    assert score.found
    assert score.person_found
    assert (score.claims, score.false_claims, score.person_probability) == (1, 0, 0.8)
    assert score.target_error_m == pytest.approx(0.6)
    assert score.target_height_error_m == pytest.approx(0.0, abs=1e-6)
    assert score.time_to_detection_s == 70.5
    assert score.visibility_max == pytest.approx(0.75, abs=1e-3)
    assert score.visibility_final == pytest.approx(0.25, abs=1e-3)
    assert (score.steps, score.vehicles, score.landed) == (2, 3, 2)
    assert (score.min_separation_m, score.min_height_above_ground_m) == (2.5, 31.5)
    assert score.mission_dir == str(recorded.folder)


@pytest.mark.parametrize(("east_m", "error_m"), [(4.0, 0.0), (1.5, 2.5), (0.0, None)])
async def test_a_claim_is_compared_with_where_a_walking_person_was(
    tmp_path: Path, person_enu_m: np.ndarray, east_m: float, error_m: float | None
) -> None:
    blobs = [beside(person_enu_m, 2.0), beside(person_enu_m, 4.0)]
    recorded = await record(tmp_path, person_enu_m, (0.75, 0.25), blobs)
    recorded.walk = Walk(speed_mps=2.0, length_m=8.0, heading_rad=math.pi / 2)
    score = recorded.score(snapshot(beside(person_enu_m, east_m), (Task.LANDED,), Outcome.FOUND))
    assert score.person_found is (error_m is not None)
    assert score.target_error_m == pytest.approx(4.0 if error_m is None else error_m, abs=1e-6)


async def test_blobs_of_something_else_show_nothing_of_the_person(tmp_path: Path, person_enu_m: np.ndarray) -> None:
    recorded = await record(tmp_path, person_enu_m, (5.0, 0.5), [beside(person_enu_m, 2.9), beside(person_enu_m, 3.1)])
    score = recorded.score(snapshot(None, (Task.LANDED,), Outcome.NOT_FOUND), report=False)
    assert not score.found
    assert score.target_error_m is None
    assert score.visibility_max == 1.0
    assert score.visibility_final == 0.0
    assert score.min_separation_m is None


async def test_a_claim_somewhere_else_is_false_and_what_was_not_announced_is_no_claim(
    tmp_path: Path, person_enu_m: np.ndarray
) -> None:
    recorded = await record(tmp_path, person_enu_m, (0.5, 0.5), [beside(person_enu_m, 25.7)] * 2)
    wrong = snapshot(beside(person_enu_m, 25.7), (Task.LANDED,), Outcome.FOUND)
    score = recorded.score(wrong)
    assert not score.found
    assert not score.person_found
    assert (score.claims, score.false_claims, score.person_probability) == (1, 1, 0.8)
    assert score.target_error_m == pytest.approx(25.7)
    deer = claim(2, beside(person_enu_m, 0.1), FindingKind.ANIMAL)
    rejected = replace(claim(3, beside(person_enu_m, 9.0)), status=FindingStatus.REJECTED)
    assert not recorded.score(replace(wrong, findings=(*wrong.findings, deer, rejected))).person_found
    right = replace(wrong, findings=(*wrong.findings, deer, rejected, claim(4, beside(person_enu_m, 2.9))))
    assert (recorded.score(right).person_found, recorded.score(right).false_claims) == (True, 1)


async def test_a_mission_without_steps_has_nothing_to_measure(tmp_path: Path, person_enu_m: np.ndarray) -> None:
    async with MissionRecorder.create(tmp_path, "m", {}, notify=lambda _: None):
        pass
    recorded = Recorded(tmp_path / "m", person_enu_m, 0.0)
    score = recorded.score(replace(snapshot(None, (Task.LOST,), Outcome.FAILED), step=0))
    assert (score.visibility_max, score.visibility_final, score.time_to_detection_s) == (None, None, None)
    assert (score.steps, score.landed) == (0, 0)


async def test_a_claim_on_a_hillside_is_judged_by_its_place_and_its_height(
    tmp_path: Path, person_enu_m: np.ndarray
) -> None:
    recorded = await record(tmp_path, person_enu_m, (0.5, 0.5), [beside(person_enu_m, 0.0)] * 2)
    recorded.person_enu_m = person_enu_m + np.array([0.0, 0.0, 7.0])
    score = recorded.score(snapshot(beside(person_enu_m, 0.5), (Task.LANDED,), Outcome.FOUND))
    assert score.target_error_m == pytest.approx(0.5, abs=1e-3)
    assert score.target_height_error_m == pytest.approx(-7.0, abs=1e-3)


async def test_mission_and_world_may_have_origins_of_their_own(tmp_path: Path, person_enu_m: np.ndarray) -> None:
    recorded = await record(tmp_path, person_enu_m, (0.5, 0.5), [beside(person_enu_m, 0.0)] * 2)
    world_origin = LocalFrame(ORIGIN).to_geodetic((30.0, -20.0, 2.0))
    score = recorded.score(snapshot(beside(person_enu_m, 0.6), (Task.LANDED,), Outcome.FOUND), origin=world_origin)
    assert score.target_error_m == pytest.approx(0.6, abs=1e-3)


@pytest.mark.parametrize("content", ["{", "[]", '{"origin": {}}'])
async def test_what_is_no_world_file_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "other.json"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputDataError, match=r"other.json is not a world file"):
        score_mission(snapshot(None, (), Outcome.FAILED), tmp_path, path, None)


PLACE = '"origin": {"latitude_deg": 48.3, "longitude_deg": 14.3, "altitude_amsl_m": 260}'


@pytest.mark.parametrize(
    ("fields", "name"),
    [
        ('"origin": {"latitude_deg": 48.3}, "seed": 1, "trees_per_ha": 1, "targets": []', "origin"),
        (f'{PLACE}, "seed": "one", "trees_per_ha": 1, "targets": []', "seed"),
        (f'{PLACE}, "seed": 1, "trees_per_ha": null, "targets": []', "trees_per_ha"),
        (f'{PLACE}, "seed": 1, "trees_per_ha": 1, "targets": [{{"position_enu_m": [1, 2]}}]', "targets"),
        (f'{PLACE}, "seed": 1, "trees_per_ha": 1, "targets": [], "start_utc_s": "noon"', "start_utc_s"),
        (
            f'{PLACE}, "seed": 1, "trees_per_ha": 1, "targets": [{{"position_enu_m": [1, 2, 3], "walk": {{"x": 1}}}}]',
            "targets",
        ),
        (f'{PLACE}, "seed": 1, "trees_per_ha": 1, "targets": [], "area_enu_m": [[1, "x"]]', "area_enu_m"),
        (f'{PLACE}, "seed": 1, "trees_per_ha": 1, "targets": [], "vehicles": [{{"board_id": "a1"}}]', "vehicles"),
    ],
)
def test_a_field_that_cannot_be_read_is_named(tmp_path: Path, fields: str, name: str) -> None:
    path = tmp_path / "world.json"
    path.write_text(f"{{{fields}}}", encoding="utf-8")
    with pytest.raises(
        InputDataError, match=rf"world\.json is not a world file of the simulator: {name} cannot be read"
    ):
        read_world(path)


def test_the_truth_about_another_world_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "world.json"
    area_m = ((-50.0, 8.0), (50.0, 8.0), (50.0, 108.0), (-50.0, 108.0))
    searched = replace(snapshot(None, (), Outcome.NOT_FOUND), area_enu_m=((-25.0, 8.0), (25.0, 8.0), (25.0, 88.0)))
    for offset_m, is_other in (((0.0, 0.0, 0.0), False), ((60.0, 0.0, 0.0), False), ((0.0, 1000.0, 0.0), True)):
        write_world_file(path, World(area_m), LocalFrame(ORIGIN).to_geodetic(offset_m), {}, START_UTC_S)
        if is_other:
            with pytest.raises(InputDataError, match=r"another world: its area_enu_m lies 920 m outside"):
                check_world(path, read_world(path), searched)
        else:
            check_world(path, read_world(path), searched)


def test_the_truth_about_a_world_that_began_after_the_mission_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "world.json"
    last = replace(snapshot(None, (), Outcome.NOT_FOUND), started_utc_s=START_UTC_S + 200.0)
    for later_s, is_other in ((0.0, False), (330.0, False), (480.0, True)):
        write_world_file(path, World(()), ORIGIN, {}, START_UTC_S + later_s)
        if is_other:
            with pytest.raises(InputDataError, match=r"another world: its start_utc_s is 180 s after"):
                check_world(path, read_world(path), last)
        else:
            check_world(path, read_world(path), last)


def test_the_truth_about_a_world_with_other_flight_controllers_is_refused(tmp_path: Path) -> None:
    path, homes_enu_m = tmp_path / "world.json", {1: (0.0, 0.0, 0.0)}
    last = snapshot(None, (Task.LANDED,), Outcome.NOT_FOUND)
    (vehicle,) = last.vehicles
    cases = (({1: "a1"}, "a1", False), ({1: "a1"}, "b2", True), ({1: "a1"}, "", False), (None, "b2", False))
    for boards, of_mission, is_other in cases:
        write_world_file(path, World(()), ORIGIN, homes_enu_m, START_UTC_S, board_ids=boards)
        heard = replace(vehicle, telemetry=replace(vehicle.telemetry, board_id=of_mission))
        searched = replace(last, vehicles=(heard,))
        if is_other:
            with pytest.raises(InputDataError, match=r"by its vehicles, the flight controller of vehicle 1 is a1"):
                check_world(path, read_world(path), searched)
        else:
            check_world(path, read_world(path), searched)
