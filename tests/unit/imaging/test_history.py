"""Views of earlier steps: kept while they add to a still target, dropped when it moves."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import intersect_plane, project_points
from aos_gcs.imaging.model import FocalGrid, Frame, KeptView, StepAnalysis
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.history import MIN_GAIN, marks_on
from aos_gcs.imaging.step.settings import ImagingSettings

CAMERA = CameraModel.from_fov(128, 128, math.radians(50.0))
SETTINGS = ImagingSettings(rx_quantile=0.99, resolution_m=0.25)
RADIUS_M = 1.5


def look(vehicle_id: int, step: int, target: tuple[float, float], shown: float = 0.4) -> Frame:
    """A frame of a warm disc on the ground of which leaves leave a strip of random direction."""
    rng = np.random.default_rng([vehicle_id, step])
    pose = nadir_pose([*rng.uniform(-4.0, 4.0, 2), 30.0])
    u, v = np.meshgrid(np.arange(128), np.arange(128))
    ground = intersect_plane(np.column_stack((u.ravel(), v.ravel())), CAMERA, pose, 0.0)[:, :2] - target
    angle = rng.uniform(0.0, 2 * np.pi)
    across = ground @ [np.cos(angle), np.sin(angle)] - rng.uniform(-1.0, 1.0) * RADIUS_M / 2
    seen = (np.linalg.norm(ground, axis=1) < RADIUS_M) & (np.abs(across) < shown * RADIUS_M)
    image = rng.normal(20.0, 1.0, (128, 128)) + 40.0 * seen.reshape(128, 128)
    return Frame(vehicle_id, image.astype(np.float32)[:, :, np.newaxis], ("thermal",), pose, CAMERA)


def fly(targets: list[tuple[float, float]], settings: ImagingSettings = SETTINGS) -> list[StepAnalysis]:
    """Two vehicles look at each place of a target in turn."""
    history: tuple[KeptView, ...] = ()
    steps = []
    for step, target in enumerate(targets):
        steps.append(analyse_step([look(1, step, target), look(2, step, target)], settings, history))
        history = steps[-1].history
    return steps


def test_history_enlarges_what_is_seen_of_a_still_target() -> None:
    steps = fly([(0.0, 0.0)] * 8)
    full_m2 = math.pi * RADIUS_M**2
    assert all(step.present_m2 < 0.85 * full_m2 for step in steps)
    assert steps[-1].visibility_m2 > 0.95 * full_m2
    areas_m2 = [step.visibility_m2 for step in steps]
    for before, after in itertools.pairwise(areas_m2):
        assert after >= (1.0 - MIN_GAIN * 3) * before
    assert all(step.visibility_m2 >= step.present_m2 for step in steps)


def test_leader_and_views_are_of_the_present() -> None:
    last = fly([(0.0, 0.0)] * 4)[-1]
    assert last.vehicle_ids == (1, 2)
    assert [view.vehicle_id for view in last.sightings[0].views] == [1, 2]
    assert last.fitness.sum() >= last.present_m2 > 0.0
    assert last.masks is not None
    assert last.masks.marked.shape[0] == 2


@pytest.mark.parametrize("step_m", [1.5, 4.0])
def test_views_of_where_a_walker_was_are_dropped(step_m: float) -> None:
    steps = fly([(-6.0 + step_m * step, 0.0) for step in range(4)])
    for number, step in enumerate(steps):
        assert step.blob is not None
        places = np.array([view.point_enu_m for view in step.sightings[0].views])
        np.testing.assert_allclose(places.mean(axis=0), [-6.0 + step_m * number, 0.0], atol=0.9)
        assert {view.pose.position_enu_m[0] for view in step.history} <= {
            frame.pose.position_enu_m[0] for frame in (look(1, number, (0, 0)), look(2, number, (0, 0)))
        }


def test_without_a_target_views_wait_and_make_no_blob() -> None:
    history = fly([(0.0, 0.0)])[0].history
    empty = analyse_step([look(1, 7, (500.0, 0.0)), look(2, 7, (500.0, 0.0))], SETTINGS, history)
    assert all(sighting.views for sighting in empty.sightings)
    assert empty.visibility_m2 < 0.5
    nothing = analyse_step([look(1, 7, (500.0, 0.0))], replace(SETTINGS, rx_min_score=1e6), history)
    assert nothing.blob is None
    assert nothing.history == history


def test_no_more_views_are_kept_than_allowed() -> None:
    assert max(len(step.history) for step in fly([(0.0, 0.0)] * 6)) > 2
    assert max(len(step.history) for step in fly([(0.0, 0.0)] * 6, replace(SETTINGS, history_frames=2))) == 2
    assert not any(step.history for step in fly([(0.0, 0.0)] * 3, replace(SETTINGS, history_frames=0)))
    with pytest.raises(ConfigurationError, match="history_frames"):
        ImagingSettings(history_frames=-1)


def kept(height_m: float = 0.0) -> KeptView:
    marked = np.zeros((20, 30), np.bool_)
    marked[4:16, 6:25] = True
    return KeptView(1, nadir_pose([5.0, -3.0, 35.0]), marked, -2.0, 3.0, 0.1, height_m)


@given(resolution_m=st.floats(0.05, 0.2), west_m=st.floats(-9.0, -8.0), north_m=st.floats(8.0, 9.0))
def test_marks_keep_their_place_and_area_on_another_raster(resolution_m: float, west_m: float, north_m: float) -> None:
    grid = FocalGrid(west_m, north_m, resolution_m, 400, 400, 0.0)
    marks = marks_on(kept(), grid)
    area_m2 = marks.rows.size * resolution_m**2
    assert area_m2 == pytest.approx(12 * 19 * 0.01, rel=2.5 * resolution_m)
    east_m = west_m + (marks.columns.mean() + 0.5) * resolution_m
    north = north_m - (marks.rows.mean() + 0.5) * resolution_m
    assert (east_m, north) == pytest.approx((-2.0 + 15.5 * 0.1, 3.0 - 10.0 * 0.1), abs=resolution_m)


def test_marks_follow_the_focal_plane_along_their_lines_of_sight() -> None:
    view = kept()
    grid = FocalGrid(-10.0, 10.0, 0.05, 400, 400, 4.0)
    marks = marks_on(view, grid)
    middle = np.array([-2.0 + 15.5 * 0.1, 3.0 - 10.0 * 0.1, 0.0])
    pixel = project_points([middle], CAMERA, view.pose)
    expected = intersect_plane(pixel, CAMERA, view.pose, 4.0)[0]
    east_m = -10.0 + (marks.columns.mean() + 0.5) * 0.05
    north_m = 10.0 - (marks.rows.mean() + 0.5) * 0.05
    assert (east_m, north_m) == pytest.approx(expected[:2], abs=0.06)


def test_marks_off_the_raster_are_left_out() -> None:
    assert marks_on(kept(), FocalGrid(50.0, 50.0, 0.1, 10, 10, 0.0)).rows.size == 0
