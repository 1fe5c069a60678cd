import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.focal_plane import (
    MAX_DEPTH_RATIO,
    choose_grid,
    covered_spans,
    footprint,
    grid_to_image,
    grid_to_plane,
)
from aos_gcs.imaging.model import FocalGrid, Frame
from aos_gcs.imaging.views import grid_view

CAMERA = CameraModel.from_fov(32, 24, np.radians(50.0))


def frame(pose: Pose, camera: CameraModel = CAMERA) -> Frame:
    return Frame(1, np.zeros((camera.height_px, camera.width_px, 1), dtype=np.uint8), ("grey",), pose, camera)


def tilted(position_enu_m: list[float], tilt_rad: float, heading_rad: float = 0.0) -> Pose:
    nadir = nadir_pose(position_enu_m, heading_rad)
    return Pose(nadir.position_enu_m, nadir.R_cam2enu @ Rotation.from_euler("x", tilt_rad).as_matrix())


def cell_centres_m(grid: FocalGrid) -> np.ndarray:
    columns, rows = np.meshgrid(np.arange(grid.columns), np.arange(grid.rows))
    x, y, _ = grid_to_plane(grid) @ np.stack((columns.ravel(), rows.ravel(), np.ones(columns.size)))
    return np.stack((x, y, np.full_like(x, grid.height_m)), axis=1)


poses = st.builds(
    tilted,
    st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(5, 60)).map(list),
    st.floats(-1.5, 1.5),
    st.floats(-4, 4),
)


@settings(max_examples=60)
@given(pose=poses)
def test_coverage_equals_a_brute_force_projection_of_every_cell(pose: Pose) -> None:
    grid = FocalGrid(west_m=-60.0, north_m=55.0, resolution_m=1.7, rows=66, columns=70, height_m=1.0)
    centres = cell_centres_m(grid)
    pixel = project_points(centres, CAMERA, pose)
    depth_m = (centres - pose.position_enu_m) @ pose.R_cam2enu[:, 2]
    normalised = (pixel + 0.5) / [CAMERA.width_px, CAMERA.height_px]
    distance_to_limit = np.minimum(np.abs(normalised), np.abs(1 - normalised)).min(axis=1)
    expected = ((normalised >= 0) & (normalised <= 1)).all(axis=1)
    expected &= depth_m <= MAX_DEPTH_RATIO * abs(pose.position_enu_m[2] - 1.0)
    covered = np.zeros((grid.rows, grid.columns), dtype=np.uint8)
    projection = grid_view(grid).project(frame(pose))
    if projection is not None and (window := projection.window(0, grid.rows)) is not None:
        part = projection.covered(window)
        covered[window] = 1 if part is None else part
    decided = np.isnan(distance_to_limit) | (distance_to_limit > 1e-9)
    np.testing.assert_array_equal(covered.ravel()[decided], expected[decided])


@given(pose=poses, column=st.floats(-5, 5), row=st.floats(-5, 5))
def test_grid_homography_is_the_projection_of_its_cells(pose: Pose, column: float, row: float) -> None:
    grid = FocalGrid(west_m=3.0, north_m=7.0, resolution_m=0.5, rows=5, columns=5, height_m=0.5)
    u, v, depth_m = grid_to_image(grid, CAMERA, pose) @ [column, row, 1.0]
    point = [3.0 + (column + 0.5) * 0.5, 7.0 - (row + 0.5) * 0.5, 0.5]
    if depth_m > 0.1:
        np.testing.assert_allclose([u / depth_m, v / depth_m], project_points([point], CAMERA, pose)[0], atol=1e-6)


def test_row_zero_is_north_and_column_zero_west() -> None:
    grid = FocalGrid(west_m=100.0, north_m=200.0, resolution_m=2.0, rows=3, columns=4, height_m=0.0)
    np.testing.assert_allclose(cell_centres_m(grid)[[0, 11], :2], [[101.0, 199.0], [107.0, 195.0]])


def test_nadir_footprint_is_the_rectangle_of_the_field_of_view() -> None:
    outline = footprint(CAMERA, nadir_pose([10.0, 20.0, 31.0]), 1.0)
    half_width_m = 30.0 * np.tan(np.radians(25.0))
    np.testing.assert_allclose(outline.max(axis=0), [10 + half_width_m, 20 + half_width_m * 0.75])
    np.testing.assert_allclose(outline.min(axis=0), [10 - half_width_m, 20 - half_width_m * 0.75])


@given(pose=poses)
def test_footprints_are_finite_and_within_the_depth_limit(pose: Pose) -> None:
    outline = footprint(CAMERA, pose, 0.0)
    assert np.isfinite(outline).all()
    points = np.column_stack((outline, np.zeros(len(outline))))
    depth_m = (points - pose.position_enu_m) @ pose.R_cam2enu[:, 2]
    assert (depth_m <= MAX_DEPTH_RATIO * pose.position_enu_m[2] * (1 + 1e-9)).all()


@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(20, 60)).map(list), min_size=1, max_size=5))
def test_grid_bounds_all_footprints_at_the_finest_sampling(positions: list[list[float]]) -> None:
    frames = [frame(nadir_pose(position)) for position in positions]
    grid = choose_grid(frames, 0.0)
    assert grid.resolution_m == pytest.approx(min(p[2] for p in positions) / CAMERA.fx_px)
    outlines = np.concatenate([footprint(f.camera, f.pose, 0.0) for f in frames])
    east_m, south_m = grid.west_m + grid.columns * grid.resolution_m, grid.north_m - grid.rows * grid.resolution_m
    slack = 1e-9
    assert (outlines >= [grid.west_m - slack, south_m - slack]).all()
    assert (outlines <= [east_m + slack, grid.north_m + slack]).all()
    assert outlines[:, 0].min() - grid.west_m <= grid.resolution_m + slack


def test_a_large_area_coarsens_the_grid() -> None:
    frames = [frame(nadir_pose([x, 0.0, 35.0])) for x in (0.0, 1000.0)]
    grid = choose_grid(frames, 0.0, resolution_m=0.01, max_cells=10_000)
    assert 9_000 < grid.rows * grid.columns <= 10_000


def test_a_requested_resolution_is_kept() -> None:
    assert choose_grid([frame(nadir_pose([0, 0, 35.0]))], 0.0, resolution_m=0.25).resolution_m == 0.25


def test_a_plane_above_the_cameras_is_refused_with_the_reason() -> None:
    with pytest.raises(ImagingError, match=r"height of 40 m.*lowest camera is at 35\.0 m.*below the cameras"):
        choose_grid([frame(nadir_pose([0, 0, 35.0]))], 40.0)


def test_a_frame_that_sees_no_ground_does_not_widen_the_grid() -> None:
    down = frame(nadir_pose([0, 0, 35.0]))
    up = frame(tilted([500.0, 0.0, 35.0], np.pi))
    assert choose_grid([down, up], 0.0) == choose_grid([down], 0.0)
    assert grid_view(choose_grid([down], 0.0)).project(up) is None


def test_a_span_of_one_cell_and_an_empty_one() -> None:
    only_column_two = np.array([[1.0, 0.0, -2.0], [-1.0, 0.0, 2.0]])
    np.testing.assert_array_equal(covered_spans(only_column_two, 2, 5), [[2, 3], [2, 3]])
    nothing = np.array([[0.0, 0.0, -1.0]])
    spans = covered_spans(nothing, 2, 5)
    assert (spans[:, 1] <= spans[:, 0]).all()
