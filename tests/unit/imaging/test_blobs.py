import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.imaging.detection.marks import Marks, project_marks
from aos_gcs.imaging.focal_plane import choose_grid
from aos_gcs.imaging.model import FocalGrid, Frame
from aos_gcs.imaging.step.blobs import BlobCells, find_blobs
from aos_gcs.imaging.step.visibility import area_in_view_px, choose_leader, contribution_m2, distance_to_centre
from aos_gcs.imaging.views import grid_view

GRID = FocalGrid(west_m=10.0, north_m=50.0, resolution_m=0.5, rows=20, columns=30, height_m=2.0)
CAMERA = CameraModel.from_fov(64, 64, np.radians(50.0))


def counts(*cells: tuple[int, int], value: int = 1) -> np.ndarray:
    array = np.zeros((GRID.rows, GRID.columns), dtype=np.uint16)
    for row, column in cells:
        array[row, column] = value
    return array


def square(row: int, column: int, edge: int) -> BlobCells:
    rows, columns = np.mgrid[row : row + edge, column : column + edge].reshape(2, -1)
    return BlobCells(rows, columns, np.ones(rows.size, dtype=np.uint16))


def largest_blob(anomaly_count: np.ndarray, minimum_count: int = 1, gap_cells: int = 1) -> BlobCells | None:
    return next(iter(find_blobs(anomaly_count, minimum_count, gap_cells)), None)


def test_nothing_marked_is_no_blob() -> None:
    assert largest_blob(counts()) is None
    assert largest_blob(counts((3, 4)), minimum_count=2) is None


def test_the_largest_blob_wins_and_corners_connect() -> None:
    cells = largest_blob(counts((0, 0), (0, 1), (10, 10), (11, 11), (12, 10)), gap_cells=0)
    assert cells is not None
    assert sorted(zip(cells.rows, cells.columns, strict=True)) == [(10, 10), (11, 11), (12, 10)]
    assert cells.area_m2(GRID) == pytest.approx(0.75)


def test_all_blobs_come_in_falling_order_of_size() -> None:
    anomaly_count = counts((0, 0), (0, 1), (10, 10), (11, 11), (12, 10), (19, 29), value=2)
    blobs = find_blobs(anomaly_count)
    assert [blob.rows.size for blob in blobs] == [3, 2, 1]
    assert (blobs[2].rows[0], blobs[2].columns[0], blobs[2].counts[0]) == (19, 29, 2)
    assert [blob.rows.size for blob in find_blobs(anomaly_count, at_most=2)] == [3, 2]


@pytest.mark.parametrize(("gap_cells", "expected"), [(0, 2), (1, 3), (2, 4)])
@pytest.mark.parametrize("transposed", [False, True])
def test_gaps_up_to_the_limit_connect_and_count_no_area(gap_cells: int, expected: int, transposed: bool) -> None:
    row = np.zeros((9, 12), dtype=np.uint16)
    row[4, [1, 2, 4, 7]] = 1
    cells = largest_blob(np.ascontiguousarray(row.T) if transposed else row, gap_cells=gap_cells)
    assert cells is not None
    assert cells.rows.size == expected


@given(seed=st.integers(0, 2**32 - 1), density=st.floats(0.02, 0.5), minimum=st.integers(1, 3))
def test_without_gaps_blobs_are_those_of_an_independent_labelling(seed: int, density: float, minimum: int) -> None:
    rng = np.random.default_rng(seed)
    anomaly_count = (rng.integers(0, 4, (25, 31)) * (rng.random((25, 31)) < density)).astype(np.uint16)
    labels, number = ndimage.label(anomaly_count >= minimum, structure=np.ones((3, 3)))
    cells = largest_blob(anomaly_count, minimum, gap_cells=0)
    if number == 0:
        assert cells is None
        return
    assert cells is not None
    assert cells.rows.size == np.bincount(labels.ravel())[1:].max()
    assert len(set(labels[cells.rows, cells.columns])) == 1
    np.testing.assert_array_equal(cells.counts, anomaly_count[cells.rows, cells.columns])


def test_the_centroid_is_weighted_by_the_counts() -> None:
    anomaly_count = counts((4, 6))
    anomaly_count[4, 7] = 3
    cells = largest_blob(anomaly_count)
    assert cells is not None
    assert cells.centroid_enu_m(GRID) == pytest.approx((10 + (6.75 + 0.5) * 0.5, 50 - 4.5 * 0.5, 2.0))


def test_the_area_in_view_is_that_of_the_projected_square() -> None:
    blob = square(8, 12, 4)
    centre = blob.centroid_enu_m(GRID)
    above = nadir_pose([centre[0], centre[1], 32.0], heading_rad=0.7)
    assert area_in_view_px(blob, GRID, CAMERA, above) == pytest.approx((2.0 * CAMERA.fx_px / 30) ** 2, rel=1e-6)


def test_the_area_in_view_of_a_tilted_camera_is_that_of_the_projected_outline() -> None:
    blob = square(5, 10, 10)
    nadir = nadir_pose([16.0, 38.0, 32.0])
    tilt = cv2.Rodrigues(np.array([0.3, 0.1, 0.0]))[0]
    pose = Pose(nadir.position_enu_m, nadir.R_cam2enu @ tilt)
    corners_m = np.array([[15.0, 47.5, 2.0], [20.0, 47.5, 2.0], [20.0, 42.5, 2.0], [15.0, 42.5, 2.0]])
    points_cam = (corners_m - pose.position_enu_m) @ pose.R_cam2enu
    outline_px = (points_cam / points_cam[:, 2:]) @ CAMERA.K.T
    expected = cv2.contourArea(outline_px[:, :2].astype(np.float32))
    assert (np.abs(outline_px[:, :2] - 31.5) <= 32).all()
    assert area_in_view_px(blob, GRID, CAMERA, pose) == pytest.approx(expected, rel=1e-3)


def test_what_lies_out_of_view_or_behind_has_no_area() -> None:
    blob = square(0, 0, 3)
    assert area_in_view_px(blob, GRID, CAMERA, nadir_pose([500.0, 0.0, 32.0])) == 0.0
    assert area_in_view_px(blob, GRID, CAMERA, nadir_pose([10.0, 50.0, -32.0])) == 0.0
    assert distance_to_centre((10.0, 50.0, 2.0), CAMERA, nadir_pose([10.0, 50.0, -32.0])) == np.inf


def test_contribution_counts_only_the_own_cells_inside_the_blob() -> None:
    marks = Marks(np.array([0, 8, 8, 11]), np.array([0, 12, 14, 29]))
    assert contribution_m2(square(8, 12, 4), GRID, marks) == pytest.approx(0.5)
    assert contribution_m2(square(0, 20, 3), GRID, marks) == 0.0


def test_ties_go_to_the_view_whose_blob_is_nearest_to_the_centre() -> None:
    assert choose_leader(np.array([1.0, 3.0, 3.0 - 1e-12, 2.0]), [0.0, 0.3, 0.1, 0.0].__getitem__) == 2
    assert choose_leader(np.array([1.0, 3.0, 2.9]), [0.0, 0.3, 0.1].__getitem__) == 1
    assert choose_leader(np.zeros(2), [0.2, 0.1].__getitem__) == 1


@given(heading=st.floats(0, 6.3), height_m=st.floats(20.0, 40.0), resolution_m=st.sampled_from([None, 0.3, 0.7, 1.7]))
def test_a_line_of_pixels_stays_one_blob_on_any_grid(
    heading: float, height_m: float, resolution_m: float | None
) -> None:
    """Neither turning nor a coarser or finer raster tears apart what touches in the image, corners included."""
    mask = np.zeros((64, 64), dtype=np.uint8)
    mask[np.arange(20, 40), np.arange(20, 40)] = 1
    mask[40, 40:55] = 1
    image = np.zeros((64, 64, 1), dtype=np.uint8)
    frame = Frame(1, image, ("thermal",), nadir_pose([3.0, 4.0, height_m], heading), CAMERA)
    lower = Frame(2, image, ("thermal",), nadir_pose([0.0, 0.0, 19.0]), CAMERA)
    grid = choose_grid([frame, lower], 0.0, resolution_m)
    projection = grid_view(grid).project(frame)
    assert projection is not None
    marks = project_marks(mask, projection)
    marked = np.zeros((grid.rows, grid.columns), dtype=np.uint16)
    marked[marks.rows, marks.columns] += 1
    assert marked.sum() == marks.rows.size
    cells = largest_blob(marked)
    assert cells is not None
    assert cells.rows.size == np.count_nonzero(marked)
