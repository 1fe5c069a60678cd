"""Masks of images as cells of a raster, against a brute-force look-up of every cell and pixel."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import intersect_plane, project_points
from aos_gcs.imaging.detection.marks import NO_MARKS, Marks, project_marks
from aos_gcs.imaging.model import FocalGrid, Frame
from aos_gcs.imaging.views import grid_view

PINHOLE = CameraModel.from_fov(64, 48, np.radians(50.0))
BARREL = dataclasses.replace(PINHOLE, distortion=LensDistortion(LensModel.BROWN_CONRADY, (-0.25, 0.08, 0, 0, 0)))
GRID = FocalGrid(west_m=-20.0, north_m=20.0, resolution_m=0.4, rows=100, columns=100, height_m=0.0)


TOLERANCE_PX = 1 / 32
"""OpenCV's warps place coordinates on a lattice of 1/32 pixel; the map of a lens is interpolated between pixels."""


def expected_cells(mask: np.ndarray, camera: CameraModel, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """Cells that are marked and cells that may be, where a centre lies within the tolerance of a pixel's edge.

    A cell is marked if the image covers it and its centre sees a marked pixel, or the centre of a marked pixel sees it.
    """
    columns, rows = np.meshgrid(np.arange(GRID.columns), np.arange(GRID.rows))
    x_m = GRID.west_m + (columns + 0.5) * GRID.resolution_m
    y_m = GRID.north_m - (rows + 0.5) * GRID.resolution_m
    pixels = project_points(np.stack((x_m, y_m, np.zeros_like(x_m)), axis=-1).reshape(-1, 3), camera, pose)
    u, v = np.nan_to_num(pixels, nan=-9.0).T
    around = [(u + du, v + dv) for du in (-TOLERANCE_PX, TOLERANCE_PX) for dv in (-TOLERANCE_PX, TOLERANCE_PX)]
    seen = np.array([_within(mask, *place) for place in around]).reshape(4, *rows.shape)
    shown = np.array([_shown(mask, *place) for place in around]).reshape(4, *rows.shape)
    v_px, u_px = np.nonzero(mask)
    points_m = intersect_plane(np.stack((u_px, v_px), axis=1), camera, pose, 0.0)
    own_columns = np.floor((points_m[:, 0] - GRID.west_m) / GRID.resolution_m)
    own_rows = np.floor((GRID.north_m - points_m[:, 1]) / GRID.resolution_m)
    inside = (own_rows >= 0) & (own_rows < GRID.rows) & (own_columns >= 0) & (own_columns < GRID.columns)
    own = np.zeros(rows.shape, dtype=bool)
    own[own_rows[inside].astype(int), own_columns[inside].astype(int)] = True
    # The outline of a lens is that of its ideal camera, so that pixels at its rim mark cells beyond the image.
    return (shown.all(axis=0) | own) & seen.all(axis=0), shown.any(axis=0) | own


def _within(mask: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return (u >= -0.5) & (u < mask.shape[1] - 0.5) & (v >= -0.5) & (v < mask.shape[0] - 0.5)


def _shown(mask: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    seen = _within(mask, u, v)
    shown = np.zeros(u.size, dtype=bool)
    shown[seen] = mask[np.rint(v[seen]).astype(int), np.rint(u[seen]).astype(int)] > 0
    return shown


def drawn(seed: int, count: int, clustered: bool) -> tuple[np.ndarray, Pose]:
    """A mask of at most ``count`` pixels, and the pose of a camera that looks almost straight down."""
    rng = np.random.default_rng(seed)
    nadir = nadir_pose([*rng.uniform(-6, 6, 2), rng.uniform(15, 30)], rng.uniform(-3, 3))
    pose = Pose(nadir.position_enu_m, nadir.R_cam2enu @ Rotation.from_rotvec(rng.uniform(-0.2, 0.2, 3)).as_matrix())
    mask = np.zeros((48, 64), dtype=np.uint8)
    spread = 6 if clustered else 48
    mask[rng.integers(0, spread, count), rng.integers(0, spread, count)] = 1
    return mask, pose


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(0, 30),
    camera=st.sampled_from([PINHOLE, BARREL]),
    clustered=st.booleans(),
)
def test_marks_are_those_of_a_brute_force_search(seed: int, count: int, camera: CameraModel, clustered: bool) -> None:
    mask, pose = drawn(seed, count, clustered)
    projection = grid_view(GRID).project(Frame(1, mask[:, :, np.newaxis], ("grey",), pose, camera))
    assert projection is not None
    marks = project_marks(mask, projection)
    found = np.zeros((GRID.rows, GRID.columns), dtype=bool)
    found[marks.rows, marks.columns] = True
    assert np.count_nonzero(found) == marks.rows.size
    certain, possible = expected_cells(mask, camera, pose)
    assert not (certain & ~found).any()
    assert not (found & ~possible).any()


@pytest.mark.parametrize("camera", [PINHOLE, BARREL])
@pytest.mark.parametrize("clustered", [False, True])
def test_the_tolerance_of_that_search_leaves_few_cells_open(camera: CameraModel, clustered: bool) -> None:
    """Or it would say nothing. Single masks may lie worse, where edges of pixels and centres of cells coincide."""
    counts = []
    for seed in range(40):
        mask, pose = drawn(seed, 1 + seed % 30, clustered)
        certain, possible = expected_cells(mask, camera, pose)
        counts.append((np.count_nonzero(possible & ~certain), np.count_nonzero(possible)))
    still_open, all_possible = np.sum(counts, axis=0)
    assert still_open <= 0.1 * all_possible


def test_membership_tells_cells_with_equal_sums_apart() -> None:
    marks = Marks(np.array([0, 2]), np.array([5, 3]))
    rows, columns = np.array([0, 1, 2, 3, 5]), np.array([5, 4, 3, 2, 0])
    np.testing.assert_array_equal(marks.among(rows, columns), [True, False, True, False, False])


def test_membership_holds_for_marks_all_around_the_cells_and_in_any_order() -> None:
    rng = np.random.default_rng(4)
    own = rng.permutation(60 * 50)[:900]
    marks, is_marked = Marks(*np.divmod(own, 50)), np.isin(np.arange(60 * 50), own).reshape(60, 50)
    rows, columns = rng.integers(20, 40, 300), rng.integers(10, 30, 300)
    np.testing.assert_array_equal(marks.among(rows, columns), is_marked[rows, columns])


def test_nothing_is_marked_among_no_cells_or_by_no_marks() -> None:
    nothing, some = np.empty(0, dtype=np.intp), np.array([3, 7])
    assert Marks(some, some).among(nothing, nothing).shape == (0,)
    assert not NO_MARKS.among(some, some).any()


def test_a_mask_that_the_raster_does_not_hold_has_no_cells() -> None:
    mask = np.zeros((48, 64), dtype=np.uint8)
    mask[:, -1] = 1
    pose = nadir_pose([-21.0 - 8.0, 0.0, 25.0])
    projection = grid_view(GRID).project(Frame(1, mask[:, :, np.newaxis], ("grey",), pose, PINHOLE))
    assert projection is not None
    assert project_marks(mask[:, ::-1].copy(), projection).rows.size == 0
    assert project_marks(np.zeros_like(mask), projection).rows.size == 0
    assert project_marks(mask, projection).columns.max(initial=0) <= 30


@pytest.mark.parametrize("camera", [PINHOLE, BARREL])
def test_every_mark_is_a_cell_that_the_frame_covers(camera: CameraModel) -> None:
    mask = np.ones((48, 64), dtype=np.uint8)
    pose = nadir_pose([0.0, 0.0, 25.0], 0.4)
    projection = grid_view(GRID).project(Frame(1, mask[:, :, np.newaxis], ("grey",), pose, camera))
    assert projection is not None
    marks = project_marks(mask, projection)
    window = projection.window(0, GRID.rows)
    assert window is not None
    covered = projection.covered(window)
    assert covered is not None
    assert (covered[marks.rows - window[0].start, marks.columns - window[1].start] == 1).all()
    if camera is PINHOLE:
        assert marks.rows.size == covered.sum()
