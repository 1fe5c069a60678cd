"""The reference surface of altitude layers: above the ground, not too steep, and the same for all, over any relief."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.reference_surface import (
    LEVEL,
    RADIUS_M,
    STRAIGHT_M,
    ReferenceSurface,
    reference_surface,
)
from aos_gcs.airspace.terrain import GroundRaster, Polynomials

CELL_M = 3.0
COUNT = 80
REACH_M = CELL_M * COUNT / 2.0
BOUNDS = (-100.0, -90.0, 100.0, 95.0)
TURNS_RAD = st.floats(0.0, 1.5)
places = st.tuples(st.floats(-90.0, 90.0), st.floats(-85.0, 90.0)).map(np.array)


def raster(heights_m: NDArray[np.float64], turn_rad: float = 0.0) -> GroundRaster:
    """Return a raster about the origin whose rows go north and whose columns go east, turned."""
    nodes_m = np.array(list(itertools.product(np.linspace(-REACH_M, REACH_M, 6), repeat=2)))
    turn = np.array([[np.cos(turn_rad), -np.sin(turn_rad)], [np.sin(turn_rad), np.cos(turn_rad)]])
    cells = ((nodes_m @ turn)[:, ::-1] + REACH_M) / CELL_M
    to_cells = Polynomials.fitted(nodes_m, np.column_stack((cells, np.zeros(len(nodes_m)))))
    heights = heights_m.astype(np.float32)
    return GroundRaster(heights, heights, to_cells, Polynomials.fitted(cells, nodes_m), offsets_m=(0.0, 1.5))


@st.composite
def reliefs(draw: st.DrawFn) -> NDArray[np.float64]:
    """Hills, cliffs and noise, with holes."""
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    relief_m = draw(st.sampled_from([0.0, 5.0, 60.0, 300.0]))
    coarse = rng.uniform(-relief_m, relief_m, (COUNT // 10, COUNT // 10))
    heights_m = np.kron(coarse, np.ones((10, 10))) + draw(st.sampled_from([0.0, 3.0])) * rng.normal(size=(COUNT, COUNT))
    return np.where(rng.uniform(size=heights_m.shape) < draw(st.sampled_from([0.0, 0.3])), np.nan, heights_m)


slopes = st.sampled_from([0.05, 0.2, 1.0])


@given(heights_m=reliefs(), turn_rad=TURNS_RAD, slope=slopes, place_m=places)
def test_no_known_ground_nearby_is_above_the_surface(
    heights_m: NDArray[np.float64], turn_rad: float, slope: float, place_m: NDArray[np.float64]
) -> None:
    ground = raster(heights_m, turn_rad)
    surface = reference_surface(ground, BOUNDS, slope)
    around_m = place_m + np.random.default_rng(1).uniform(-RADIUS_M, RADIUS_M, (200, 2))
    _, highest_m = ground.bounds_at(np.vstack((place_m, around_m)))
    if np.isfinite(highest_m).any():
        assert surface.at(place_m) >= np.nanmax(highest_m) - 1e-3


@given(heights_m=reliefs(), slope=slopes, start_m=places, end_m=places)
def test_the_surface_is_nowhere_too_steep(
    heights_m: NDArray[np.float64], slope: float, start_m: NDArray[np.float64], end_m: NDArray[np.float64]
) -> None:
    surface = reference_surface(raster(heights_m), BOUNDS, slope)
    rise_m = abs(surface.at(end_m) - surface.at(start_m))
    assert rise_m <= slope * float(np.linalg.norm(end_m - start_m)) + 1e-3


@given(heights_m=reliefs(), slope=slopes, place_m=places, layers_m=st.lists(st.floats(20.0, 80.0), min_size=2))
def test_layers_are_as_far_apart_as_on_level_ground(
    heights_m: NDArray[np.float64], slope: float, place_m: NDArray[np.float64], layers_m: list[float]
) -> None:
    surface = reference_surface(raster(heights_m), BOUNDS, slope)
    flown_m = np.array(layers_m) + surface.at(place_m)
    assert np.diff(flown_m) == pytest.approx(np.diff(layers_m))


@given(height_m=st.floats(-50.0, 500.0), slope=slopes, place_m=places)
def test_level_ground_stays_level(height_m: float, slope: float, place_m: NDArray[np.float64]) -> None:
    surface = reference_surface(raster(np.full((COUNT, COUNT), height_m)), BOUNDS, slope)
    assert surface.at(place_m) == pytest.approx(np.float32(height_m) + 1.5)
    assert surface.at(place_m * 100.0) == pytest.approx(surface.at(place_m)), "beyond the outermost nodes"


def test_ground_that_is_nowhere_known_counts_as_level() -> None:
    surface = reference_surface(raster(np.full((COUNT, COUNT), np.nan)), BOUNDS, 0.2)
    assert surface.at(np.zeros(2)) == 0.0


def test_a_surface_of_one_node_has_its_height() -> None:
    surface = ReferenceSurface(0.0, 0.0, 4.0, np.array([[7.0]]))
    assert surface.at(np.array([50.0, -3.0])) == 7.0


@given(heights_m=reliefs(), slope=slopes, start_m=places, end_m=places)
def test_straight_pieces_of_a_way_stay_near_the_surface_and_get_on(
    heights_m: NDArray[np.float64], slope: float, start_m: NDArray[np.float64], end_m: NDArray[np.float64]
) -> None:
    surface = reference_surface(raster(heights_m), BOUNDS, slope)
    share = surface.straight_share(start_m, end_m)
    assert 0.0 < share <= 1.0
    flown_m = share * float(np.linalg.norm(end_m - start_m))
    assert share == 1.0 or flown_m >= 1.0
    along = np.linspace(0.0, 1.0, 200)
    surface_m = surface.height_m(start_m + share * along[:, None] * (end_m - start_m))
    straight_m = surface_m[0] + along * (surface_m[-1] - surface_m[0])
    # Between its samples, a step of the surface's nodes apart at most, it bends a little more.
    assert np.abs(surface_m - straight_m).max() <= STRAIGHT_M + 0.5 * slope


def test_a_way_along_an_even_slope_is_one_piece_and_one_over_a_ridge_is_not() -> None:
    east = np.arange(-100.0, 101.0, 4.0)
    even = ReferenceSurface(-100.0, -100.0, 4.0, np.tile(0.1 * east, (51, 1)))
    ridge = ReferenceSurface(-100.0, -100.0, 4.0, np.tile(-0.1 * np.abs(east), (51, 1)))
    start_m, end_m = np.array((-80.0, 0.0)), np.array((80.0, 30.0))
    assert even.straight_share(start_m, end_m) == 1.0
    assert LEVEL.straight_share(start_m, end_m) == 1.0
    assert 0.4 <= ridge.straight_share(start_m, end_m) <= 0.6
    assert ridge.straight_share(np.array((5.0, 0.0)), end_m) == 1.0
    assert (ridge.lowest_m, ridge.highest_m, ridge.is_level, LEVEL.is_level) == (-10.0, 0.0, False, True)
