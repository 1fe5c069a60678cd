"""Likely causes of heights that are far from an altitude which is known: another unit, or another vertical datum."""

from __future__ import annotations

from typing import Final

_FEET_PER_M: Final = 1.0 / 0.3048
_NEAR_M: Final = 10.0
"""Difference that remains where the cause is the right one."""
_LEAST_UNDULATION_M: Final = 15.0
"""Height of the geoid from which on it is told from an altitude that errs by a few metres."""


def likely_cause(model_m: float, known_m: float, undulation_m: float | None) -> str:
    """Return why the heights of an elevation model may be wrong, or the altitude; empty where nothing is likely.

    Args:
        model_m: height of a place by the model, above mean sea level as far as its datum is right.
        known_m: altitude of the same place above mean sea level, as far as it is right.
        undulation_m: height of the geoid above the ellipsoid there; None: not known.
    """
    for factor, unit in ((_FEET_PER_M, "feet"), (10.0, "decimetres"), (100.0, "centimetres")):
        if abs(model_m / factor - known_m) <= _NEAR_M:
            return f"the model's heights look like {unit}"
    if abs(known_m / _FEET_PER_M - model_m) <= _NEAR_M:
        return "the altitude looks like feet"
    if undulation_m is not None and abs(undulation_m) >= _LEAST_UNDULATION_M:
        geoid = (
            f"the geoid is {abs(undulation_m):.1f} m {'above' if undulation_m > 0.0 else 'below'} the ellipsoid here"
        )
        if abs(model_m - known_m - undulation_m) <= _NEAR_M:
            return f"the model's heights look like those above the ellipsoid ({geoid})"
        if abs(known_m - model_m - undulation_m) <= _NEAR_M:
            return (
                f"the altitude looks like one above the ellipsoid, or the geoid was taken off the model twice ({geoid})"
            )
    return ""
