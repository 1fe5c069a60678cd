"""Vetting of segments against the ground: none meets the floor above it, whatever the relief."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.limits import UNLIMITED, GroundLimits
from aos_gcs.airspace.terrain import GroundRaster, Polynomials
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from tests.fakes.waypoints import request

CELL_M = 2.0
COUNT = 60
REACH_M = CELL_M * COUNT / 2.0
ABOVE = GroundLimits(floor_m=20.0, ceiling_m=120.0, offsets_m=(0.0, 0.0))
LIMITS = replace(UNLIMITED, above_ground=ABOVE)


def raster(heights_m: NDArray[np.float64]) -> GroundRaster:
    """Return a raster of flat cells about the origin; rows go north, columns east."""
    nodes_m = np.array([(east, north) for east in np.linspace(-1, 1, 5) for north in np.linspace(-1, 1, 5)]) * REACH_M
    cells = (nodes_m[:, ::-1] + REACH_M) / CELL_M
    to_cells = Polynomials.fitted(nodes_m, np.column_stack((cells, np.zeros(len(nodes_m)))))
    heights = heights_m.astype(np.float32)
    return GroundRaster(heights, heights, to_cells, Polynomials.fitted(cells, nodes_m))


def vet(
    start_m: tuple[float, float, float], end_m: tuple[float, float, float], ground: GroundRaster | None
) -> WaypointRecord:
    (record,) = vet_waypoints([request(1, start_m, end_m)], [], LIMITS, ground)
    return record


def bumpy(seed: int, relief_m: float, holes: float) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    coarse = rng.uniform(-relief_m, relief_m, (COUNT // 5, COUNT // 5))
    heights_m = np.kron(coarse, np.ones((5, 5))) + rng.normal(scale=1.0, size=(COUNT, COUNT))
    return np.where(rng.uniform(size=heights_m.shape) < holes, np.nan, heights_m)


sides_m = st.integers(-500, 500).map(lambda number: (number + 0.137) / 10.3)  # never on a border of two cells
places = st.tuples(sides_m, sides_m, st.floats(0.0, 90.0))


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    relief_m=st.floats(0.0, 60.0),
    start=places,
    end=places,
    holes=st.sampled_from([0.0, 0.02]),
)
def test_no_vetted_segment_meets_the_floor(
    seed: int,
    relief_m: float,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    holes: float,
) -> None:
    heights_m = bumpy(seed, relief_m, holes)
    record = vet(start, end, raster(heights_m))
    if record.sent_enu_m is not None:
        along = np.linspace(0.0, 1.0, 2001)[:, None]
        path_m = np.array(start) + along * (np.array(record.sent_enu_m) - np.array(start))
        row, column = np.floor((path_m[:, 1] + REACH_M) / CELL_M), np.floor((path_m[:, 0] + REACH_M) / CELL_M)
        above_m = path_m[:, 2] - heights_m[row.astype(int), column.astype(int)]
        known = np.isfinite(above_m)
        if known[0]:
            assert known.all(), "it does not enter ground that is not known"
            assert above_m.min() >= min(ABOVE.floor_m, above_m[0]) - 1e-3
            assert above_m.max() <= max(ABOVE.ceiling_m, above_m[0]) + 1e-3
        else:
            assert np.nanmin(above_m, initial=np.inf) >= ABOVE.floor_m - 1e-3
    if record.verdict is not WaypointVerdict.SENT:
        assert re.search(r"the ground (at|is not known at) -?\d+ m east, -?\d+ m north", record.reason)
        assert "not known" in record.reason or re.search(
            r"\d+\.\d m (below the floor|beyond the ceiling)", record.reason
        )


def test_a_ridge_stops_a_segment_before_it() -> None:
    heights_m = np.zeros((COUNT, COUNT))
    heights_m[:, 40:42] = 20.0  # from 20 to 24 m east
    record = vet((0.0, 0.0, 35.0), (50.0, 0.0, 35.0), raster(heights_m))
    assert record.verdict is WaypointVerdict.SHORTENED
    assert record.sent_enu_m is not None
    assert 17.5 < record.sent_enu_m[0] < 20.0
    assert "15.0 m above the ground at" in record.reason
    assert "5.0 m below the floor above ground" in record.reason
    assert vet((0.0, 0.0, 40.5), (50.0, 0.0, 40.5), raster(heights_m)).verdict is WaypointVerdict.SENT


def test_a_vehicle_on_the_ground_may_climb_but_not_drive_off() -> None:
    ground = raster(np.zeros((COUNT, COUNT)))
    assert vet((0.0, 0.0, 0.0), (0.0, 0.0, 35.0), ground).verdict is WaypointVerdict.SENT
    descent = vet((0.0, 0.0, 35.0), (0.0, 0.0, 5.0), ground)
    assert descent.sent_enu_m is not None
    assert 20.0 <= descent.sent_enu_m[2] < 21.5


def test_a_valley_stops_a_segment_where_the_ceiling_above_ground_is_left() -> None:
    heights_m = np.zeros((COUNT, COUNT))
    heights_m[:, 40:] = -100.0
    record = vet((0.0, 0.0, 35.0), (50.0, 0.0, 35.0), raster(heights_m))
    assert "135.0 m above the ground" in record.reason
    assert "15.0 m beyond the ceiling above ground" in record.reason


def test_beyond_the_model_nothing_is_sent() -> None:
    ground = raster(np.zeros((COUNT, COUNT)))
    record = vet((0.0, 0.0, 35.0), (100.0, 0.0, 35.0), ground)
    assert record.sent_enu_m is not None
    assert record.sent_enu_m[0] < REACH_M
    assert "the ground is not known at 6" in record.reason or "the ground is not known at 5" in record.reason


def test_limits_above_ground_without_the_ground_hold() -> None:
    record = vet((0.0, 0.0, 35.0), (10.0, 0.0, 35.0), None)
    assert record.verdict is WaypointVerdict.HELD
    assert "elevation model" in record.reason


def test_launch_points_that_report_too_much_raise_the_ground() -> None:
    ground = raster(np.zeros((COUNT, COUNT)))
    assert vet((0.0, 0.0, 25.0), (10.0, 0.0, 25.0), ground).verdict is WaypointVerdict.SENT
    raised = replace(ground, offsets_m=(0.0, 8.0))
    assert vet((0.0, 0.0, 35.0), (0.0, 0.0, 25.0), raised).verdict is WaypointVerdict.SHORTENED


def test_without_limits_above_ground_nothing_changes() -> None:
    ground = raster(np.full((COUNT, COUNT), 30.0))
    (record,) = vet_waypoints([request(1, (0.0, 0.0, 35.0), (9.0, 0.0, 35.0))], [], UNLIMITED, ground)
    assert record.verdict is WaypointVerdict.SENT
