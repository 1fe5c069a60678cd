"""Likely causes of heights that do not fit: feet, decimetres, the ellipsoid."""

from __future__ import annotations

import pytest

from aos_gcs.elevation.likely_cause import likely_cause


@pytest.mark.parametrize(
    ("model_m", "known_m", "undulation_m", "cause"),
    [
        (1968.7, 600.0, 47.5, "the model's heights look like feet"),
        (6000.5, 600.0, None, "the model's heights look like decimetres"),
        (60005.0, 600.0, None, "the model's heights look like centimetres"),
        (600.0, 1965.0, None, "the altitude looks like feet"),
        (647.5, 600.0, 47.5, "the model's heights look like those above the ellipsoid (the geoid is 47.5 m above the"),
        (600.0, 647.5, 47.5, "the altitude looks like one above the ellipsoid, or the geoid was taken off"),
        (500.0, 600.0, -98.0, "the model's heights look like those above the ellipsoid (the geoid is 98.0 m below the"),
        (631.0, 600.0, 47.5, ""),
        (647.5, 600.0, None, ""),
        (608.0, 600.0, 3.0, ""),
    ],
)
def test_units_and_datums_are_recognised(
    model_m: float, known_m: float, undulation_m: float | None, cause: str
) -> None:
    found = likely_cause(model_m, known_m, undulation_m)
    assert found.startswith(cause)
    assert bool(found) == bool(cause)
