"""The parts of the archive strategy: raster, body, target, looks, exploration, plan, moves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.distance import cdist, pdist

from aos_gcs.swarm.archive.body import learnt_body, voxel_cells
from aos_gcs.swarm.archive.exploration import NEGLIGIBLE, expected_masks, kernel, lattice, likeness
from aos_gcs.swarm.archive.looks import Canopy, no_looks, with_looks
from aos_gcs.swarm.archive.moves import assigned, kept_apart, random_ways, stepped
from aos_gcs.swarm.archive.parameters import ArchiveParameters
from aos_gcs.swarm.archive.plan import choose_lines, goals_along
from aos_gcs.swarm.archive.raster import (
    CELL_M,
    CELLS,
    FINE_CELL_M,
    FINE_CELLS,
    FINE_SIDE,
    SIDE,
    anchor_of,
    packed,
    quarters,
    resampled,
    shares,
    shifted,
    unpacked,
)
from aos_gcs.swarm.archive.target import after_sighting, first_sighting, ground_point, is_elsewhere, out_of_view
from aos_gcs.swarm.model import TargetMasks
from tests.fakes.silhouettes import footprints, on_fine_cells

CANOPY = Canopy(height_m=14.0, half_depth_m=4.0)
SEEDS = st.integers(0, 2**32 - 1)


def random_masks(rng: np.random.Generator, count: int) -> NDArray[np.bool_]:
    return rng.random((count, FINE_CELLS)) < 0.1


class TestRaster:
    @given(SEEDS, st.integers(0, 5))
    @settings(max_examples=20)
    def test_packing_is_reversible(self, seed: int, count: int) -> None:
        masks = random_masks(np.random.default_rng(seed), count)
        assert np.array_equal(unpacked(packed(masks), count), masks)

    def test_a_mask_of_the_same_raster_is_copied(self) -> None:
        masks, anchor = random_masks(np.random.default_rng(1), 3), anchor_of(np.array([12.34, -5.67]))
        told = TargetMasks(
            masks.reshape(-1, FINE_SIDE, FINE_SIDE),
            west_m=(anchor[0] - FINE_SIDE // 2) * FINE_CELL_M,
            north_m=(anchor[1] + FINE_SIDE // 2) * FINE_CELL_M,
            resolution_m=FINE_CELL_M,
        )
        assert np.array_equal(resampled(told, anchor), masks)

    @pytest.mark.parametrize("resolution_m", [0.05, 0.1, 0.25])
    def test_a_square_keeps_its_place_at_any_resolution(self, resolution_m: float) -> None:
        """The square reaches 0.5 m east and north from the middle."""
        cells = round(2.0 / resolution_m)
        marked = np.zeros((1, cells, cells), dtype=np.bool_)
        marked[0, cells // 4 : cells // 2, cells // 2 : 3 * cells // 4] = True
        told = TargetMasks(marked, west_m=-1.0, north_m=1.0, resolution_m=resolution_m)
        rows, columns = np.nonzero(resampled(told, np.zeros(2, np.int64)).reshape(FINE_SIDE, FINE_SIDE))
        assert len(rows) == 100
        assert (rows.max(), columns.min()) == (FINE_SIDE // 2 - 1, FINE_SIDE // 2)

    @given(SEEDS, st.tuples(st.integers(-4, 4), st.integers(-4, 4)))
    @settings(max_examples=20)
    def test_shifting_back_and_forth_keeps_the_inside(self, seed: int, offset: tuple[int, int]) -> None:
        masks, offsets = random_masks(np.random.default_rng(seed), 2), np.tile(offset, (2, 1))
        inside = np.zeros((FINE_SIDE, FINE_SIDE), dtype=np.bool_)
        inside[4:-4, 4:-4] = True
        back = shifted(shifted(masks, offsets), -offsets)
        assert np.array_equal(back[:, inside.ravel()], masks[:, inside.ravel()])

    def test_east_is_right_and_north_is_up(self) -> None:
        masks = np.zeros((1, FINE_CELLS), dtype=np.bool_)
        masks[0, 10 * FINE_SIDE + 10] = True
        row, column = divmod(int(np.flatnonzero(shifted(masks, np.array([[3, 2]]))[0])[0]), FINE_SIDE)
        assert (row, column) == (8, 13)

    def test_a_coarse_cell_is_the_share_of_its_four_fine_ones(self) -> None:
        masks = np.zeros((2, FINE_SIDE, FINE_SIDE), dtype=np.bool_)
        masks[0, 4:7, 10:12] = True
        seen = shares(masks.reshape(2, FINE_CELLS)).reshape(2, SIDE, SIDE)
        assert seen[0, 2, 5] == 1.0
        assert seen[0, 3, 5] == 0.5
        assert seen.sum() == 1.5
        assert np.array_equal(quarters(masks.reshape(2, FINE_CELLS)).mean(axis=2), seen.reshape(2, CELLS))


def body_learnt_from(shown: NDArray[np.bool_], slopes: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the footprints under the same slopes, as the looks let one expect them."""
    cells = voxel_cells(slopes, 40.0, np.zeros(2))
    return learnt_body(shown.astype(np.float32), cells, prior_height_m=1.75, prior_radius_m=0.15).footprints(cells)


def agreement(first: NDArray[np.bool_], second: NDArray[np.bool_]) -> float:
    """Return the area that footprints have in common, as a share of that of either."""
    return float((first & second).sum() / (first | second).sum())


class TestBody:
    def test_at_first_it_is_upright(self) -> None:
        slopes = lattice(13.0, 4.0) / 40.0
        upright = footprints(slopes, 40.0, body_height_m=1.75, body_radius_m=0.15)
        cells = voxel_cells(slopes, 40.0, np.zeros(2))
        body = learnt_body(np.zeros((0, CELLS), np.float32), cells[:0], prior_height_m=1.75, prior_radius_m=0.15)
        assert agreement(body.footprints(cells), upright) > 0.6

    def test_voxels_beyond_the_raster_cover_nothing(self) -> None:
        cells = voxel_cells(np.array([[0.0, 0.0], [3.0, 0.0], [0.0, -3.0]]), 40.0, np.zeros(2))
        assert cells[0].max() < CELLS
        assert (cells[1:] == CELLS).any()
        assert cells.min() >= 0

    def test_it_lies_away_from_the_camera_and_longer_the_more_oblique(self) -> None:
        slopes = np.array([[0.0, 0.0], [0.2, 0.0], [0.35, 0.0]])
        prints = body_learnt_from(np.zeros((3, CELLS), np.bool_), slopes)
        assert (np.diff(prints.sum(axis=1)) > 0).all()
        columns = np.nonzero(prints[2].reshape(SIDE, SIDE))[1]
        assert columns.mean() < SIDE / 2 - 2

    @pytest.mark.parametrize("height_m", [0.5, 1.75])
    def test_it_is_learnt_although_every_look_shows_a_part_only(self, height_m: float) -> None:
        """Leaves leave stripes free, in another place in each look; a low broad body is told from a high one."""
        rng, slopes = np.random.default_rng(6), lattice(13.0, 1.5) / 40.0
        truth = footprints(slopes, 40.0, body_height_m=height_m, body_radius_m=0.35)
        row, column = np.divmod(np.arange(CELLS), SIDE)
        stripes = (row + column + rng.integers(0, SIDE, (len(slopes), 1))) % 12 < 4
        before = body_learnt_from(np.zeros_like(truth), slopes)
        learnt = body_learnt_from(truth & stripes, slopes)
        assert agreement(learnt, truth) > 0.75
        assert agreement(learnt, truth) > agreement(before, truth) + 0.2


class TestTarget:
    def test_a_still_one_is_the_mean_of_noisy_sightings(self) -> None:
        rng = np.random.default_rng(2)
        estimate = first_sighting(rng.normal(0.0, 0.1, 2))
        for _ in range(30):
            estimate = after_sighting(estimate, rng.normal(0.0, 0.1, 2))
        assert not estimate.is_moving
        assert np.linalg.norm(estimate.position_enu_m) < 0.08
        assert estimate.drift_enu_m == (0.0, 0.0)

    @pytest.mark.parametrize("way_m", [0.5, 1.6])
    def test_a_walker_is_expected_where_it_goes(self, way_m: float) -> None:
        estimate = first_sighting(np.zeros(2))
        for step in range(1, 25):
            estimate = after_sighting(estimate, np.array([way_m * step, 0.0]))
        assert estimate.is_moving
        assert np.allclose(estimate.position_enu_m + estimate.next_way_m, [way_m * 25, 0.0], atol=0.1)

    def test_one_that_stops_counts_as_still_again(self) -> None:
        estimate = first_sighting(np.zeros(2))
        for step in range(1, 40):
            estimate = after_sighting(estimate, np.array([min(step, 12), 0.0]))
        assert not estimate.is_moving
        assert np.allclose(estimate.position_enu_m, [12.0, 0.0], atol=0.3)

    def test_another_blob_far_away_is_told_from_a_walk(self) -> None:
        estimate = first_sighting(np.zeros(2))
        assert is_elsewhere(estimate, np.array([50.0, 0.0]))
        assert not is_elsewhere(estimate, np.array([2.0, 0.0]))

    def test_a_walker_out_of_view_goes_on_ever_more_slowly(self) -> None:
        estimate = first_sighting(np.zeros(2))
        for step in range(1, 12):
            estimate = after_sighting(estimate, np.array([float(step), 0.0]))
        easts = [estimate.position_enu_m[0]]
        for _ in range(4):
            estimate = out_of_view(estimate)
            easts.append(estimate.position_enu_m[0])
        ways = np.diff(easts)
        assert (ways > 0.0).all()
        assert (np.diff(ways) < 0.0).all()

    def test_the_foot_is_found_from_one_side(self) -> None:
        """All drones stand in the east and see the body west of its foot."""
        slopes = np.array([[0.2, 0.0], [0.3, 0.0], [0.25, 0.1]])
        heights = np.full(3, 40.0)
        prints = footprints(slopes, 40.0, body_height_m=1.75, body_radius_m=0.2)
        edge_m = SIDE * CELL_M / 2
        masks = TargetMasks(prints.reshape(-1, SIDE, SIDE), -edge_m, edge_m, CELL_M)
        ground = ground_point(masks, slopes * 40.0, heights, np.zeros(2), body_height_m=1.75)
        assert np.linalg.norm(ground) < 0.05


class TestLooks:
    def test_the_same_line_from_another_height_is_the_same_look(self) -> None:
        low, high = (
            CANOPY.lines_of_slopes(np.zeros(2), place / height)
            for place, height in ((np.array([[7.0, 0.0]]), 35.0), (np.array([[8.8, 0.0]]), 44.0))
        )
        assert CANOPY.distances_m(low, high)[0, 0] == pytest.approx(0.0)

    def test_looks_replace_older_ones_along_the_same_line(self) -> None:
        rng, anchor, drift = np.random.default_rng(3), np.zeros(2, np.int64), np.zeros(2)
        lines = CANOPY.lines_of_slopes(np.zeros(2), rng.uniform(-0.3, 0.3, (5, 2)))
        first, second = random_masks(rng, 5), random_masks(rng, 5)
        looks = with_looks(no_looks(), CANOPY, lines, masks=first, anchor=anchor, drift_enu_m=drift)
        looks = with_looks(looks, CANOPY, lines, masks=second, anchor=anchor, drift_enu_m=drift)
        assert np.array_equal(looks.masks_at(anchor, drift), second)

    def test_the_oldest_looks_are_forgotten_first(self) -> None:
        anchor, drift = np.zeros(2, np.int64), np.zeros(2)
        lines = CANOPY.lines_of_slopes(np.zeros(2), np.array([[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]]))
        masks = random_masks(np.random.default_rng(7), 3)
        looks = with_looks(no_looks(), CANOPY, lines, masks=masks, anchor=anchor, drift_enu_m=drift, at_most=2)
        assert np.array_equal(looks.masks_at(anchor, drift), masks[1:])
        assert np.array_equal(looks.lines.slopes, lines.slopes[1:])

    def test_masks_move_with_the_target(self) -> None:
        masks, anchor = random_masks(np.random.default_rng(4), 1), np.zeros(2, np.int64)
        lines = CANOPY.lines_of_slopes(np.zeros(2), np.zeros((1, 2)))
        looks = with_looks(no_looks(), CANOPY, lines, masks=masks, anchor=anchor, drift_enu_m=np.zeros(2))
        walked_m = np.array([2.0, -1.0])
        assert np.array_equal(looks.masks_at(anchor_of(walked_m), walked_m), masks)


class TestExploration:
    def test_the_lattice_fills_the_circle(self) -> None:
        points = lattice(10.0, 1.0)
        assert np.linalg.norm(points, axis=1).max() <= 10.0
        assert pdist(points).min() == pytest.approx(1.0)
        assert len(points) == pytest.approx(np.pi * 100.0 / np.sqrt(0.75), rel=0.03)

    def test_unknown_lines_promise_what_is_hoped_for_and_known_ones_what_was_seen(self) -> None:
        masks, footprint = np.array([[1.0, 0.0]], dtype=np.float32), np.ones((2, 2), np.bool_)
        weights = np.array([[0.0], [100.0]], dtype=np.float32)
        far, near = expected_masks(weights, masks, footprint, 0.2)
        assert np.allclose(far, 0.2)
        assert np.allclose(near, [1.0, 0.0], atol=0.01)

    def test_the_fast_kernel_is_the_kernel(self) -> None:
        rng = np.random.default_rng(5)
        # Far from the origin, where multiplying out costs most digits.
        first, second = (rng.uniform(500.0, 505.0, (count, 4)) for count in (30, 20))
        expected = kernel(cdist(first, second), 0.5)
        weights = likeness(first, second, 0.5)
        assert np.abs(weights - expected).max() < 2 * NEGLIGIBLE
        assert weights[weights > 0.0].min() >= NEGLIGIBLE


class TestPlan:
    def planned(
        self, slopes: NDArray[np.float64], shown: NDArray[np.bool_], optimism: float = 0.3
    ) -> NDArray[np.float64]:
        """Return the slopes of the lines that four drones are sent to, given looks at a target at the origin."""
        parameters = ArchiveParameters(optimism=optimism)
        anchor = np.zeros(2, np.int64)
        lines = parameters.canopy.lines_of_slopes(np.zeros(2), slopes)
        masks = on_fine_cells(shown)
        looks = with_looks(
            no_looks(), parameters.canopy, lines, masks=masks, anchor=anchor, drift_enu_m=np.zeros(2)
        )  # fmt: skip
        heights_m = np.full(4, 40.0)
        target = first_sighting(np.zeros(2))
        lines_m = choose_lines(looks, target, heights_m, None, parameters)
        goals_m = goals_along(lines_m, target, lattice(8.0, 4.0)[:4], heights_m, parameters.canopy)
        slopes_planned: NDArray[np.float64] = goals_m / heights_m[:, None]
        return slopes_planned

    def test_good_lines_are_held_and_bad_ones_left(self) -> None:
        slopes = lattice(13.0, 3.2) / 40.0
        whole = footprints(slopes, 40.0, body_height_m=1.75, body_radius_m=0.2)
        good = slopes[:, 0] > 0.2
        planned = self.planned(slopes, whole & good[:, None])
        assert good.sum() > 4
        assert (planned[:, 0] > 0.1).all()

    def test_where_nothing_was_seen_drones_look_elsewhere(self) -> None:
        slopes = lattice(13.0, 1.0) / 40.0
        west = slopes[slopes[:, 0] < 0.05]
        planned = self.planned(west, np.zeros((len(west), CELLS), np.bool_))
        assert (planned[:, 0] > 0.03).all()

    def test_hope_draws_drones_to_unknown_lines(self) -> None:
        slopes = lattice(13.0, 3.2) / 40.0
        west = slopes[slopes[:, 0] < -0.1]
        mediocre = footprints(west, 40.0, body_height_m=1.75, body_radius_m=0.2)
        mediocre &= np.arange(CELLS) % 3 == 0

        def away(optimism: float) -> int:
            return int((self.planned(west, mediocre, optimism)[:, 0] > -0.05).sum())

        assert away(0.05) == 0
        assert away(0.9) >= 2


class TestMoves:
    def test_random_ways_have_one_length_and_any_direction(self) -> None:
        ways = random_ways(np.random.default_rng(1), 200, 0.5)
        assert np.allclose(np.linalg.norm(ways, axis=1), 0.5)
        assert np.linalg.norm(ways.mean(axis=0)) < 0.1

    def test_ways_do_not_cross(self) -> None:
        places = np.array([[0.0, 0.0], [5.0, 0.0], [10.0, 0.0]])
        goals = np.broadcast_to(np.array([[9.0, 1.0], [1.0, 1.0]]), (3, 2, 2))
        assert assigned(places, goals).tolist() == [1, -1, 0]

    def test_steps_are_cut_and_short_ones_arrive(self) -> None:
        moved = stepped(np.zeros((2, 2)), np.array([[10.0, 0.0], [0.0, 0.5]]), 2.0)
        assert np.allclose(moved, [[2.0, 0.0], [0.0, 0.5]])

    @given(SEEDS)
    @settings(max_examples=30, deadline=None)
    def test_waypoints_keep_apart_wherever_they_were_wanted(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        places = lattice(12.0, 4.0)[rng.permutation(30)[:10]]
        holds = rng.random(10) < 0.5
        wanted = np.where(holds[:, None], places, places + rng.uniform(-4.0, 4.0, (10, 2)))
        apart = kept_apart(wanted, places, holds, 3.0, rng)
        assert pdist(apart).min() >= 3.0

    def test_one_that_holds_stays(self) -> None:
        wanted = np.array([[0.0, 0.0], [1.0, 0.0]])
        apart = kept_apart(
            wanted, np.array([[0.0, 0.0], [6.0, 0.0]]), np.array([True, False]), 3.0, np.random.default_rng(0)
        )
        assert np.array_equal(apart[0], wanted[0])
        assert apart[1, 0] == pytest.approx(3.01)

    def test_coincident_ones_part(self) -> None:
        apart = kept_apart(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros(2, np.bool_), 3.0, np.random.default_rng(0))
        assert pdist(apart).min() >= 3.0
