"""Statistics of the synthetic aperture: useful spacing and number of cameras.

Model: occluders of one size stand at random in the canopy, and a ray to the ground meets one with probability D (the
occlusion). After Kurmi, Schedl and Bimber, *A Statistical View on Synthetic Aperture Imaging for Occlusion Removal*,
IEEE Sensors Journal 19(20), 2019: samples whose disparity is below the projected size of an occluder repeat each other,
and the gain of further samples fades as 1 / N. docs/research/imaging.md compares the model with forests.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aos_gcs.errors import ConfigurationError

MAX_DRONES = 250
DISC_PACKING = math.pi / math.sqrt(12.0)
"""Share of an area that equal discs in the densest packing cover."""


def smallest_spacing_m(altitude_m: float, occluder_height_m: float, occluder_size_m: float) -> float:
    """Return the spacing of cameras whose disparity on the focal plane equals an occluder's projected size.

    Seen from altitude h, an occluder of size o at height z covers o h / (h - z) of the plane, and a step d of the
    camera moves that by d z / (h - z): they are equal for d = o h / z. Closer samples share occluders; wider ones gain
    nothing.

    Args:
        altitude_m: height of the cameras above the focal plane.
        occluder_height_m: height of the occluders above the focal plane, below the cameras.
        occluder_size_m: their diameter.

    Raises:
        ConfigurationError: if a number is out of its range.
    """
    _require_positive("occluder_height_m", occluder_height_m)
    _require_positive("occluder_size_m", occluder_size_m)
    if not (math.isfinite(altitude_m) and altitude_m > occluder_height_m):
        raise ConfigurationError(
            f"altitude_m must be finite and above the occluders ({occluder_height_m:g} m), got {altitude_m:g}."
        )
    return occluder_size_m * altitude_m / occluder_height_m


def integral_visibility(occlusion: float, samples: float, correlation: float = 0.0) -> float:
    """Return how well an integral of N samples shows the ground: 1 - E[x²], x the occluded share of the samples.

    x has the mean D and the variance D (1 - D) (1 + (N - 1) r) / N, so that V = 1 - D² - D (1 - D) (1 + (N - 1) r) / N.
    It rises from 1 - D for a single image towards 1 - D² for many independent ones.

    Args:
        occlusion: D, 0 to 1.
        samples: N, at least 1; may be infinite.
        correlation: mean r of the occlusion of two samples, 0 to 1; 0 at the smallest useful spacing and beyond.

    Raises:
        ConfigurationError: if a number is out of its range.
    """
    _require_share("occlusion", occlusion)
    _require_share("correlation", correlation)
    if not samples >= 1.0:
        raise ConfigurationError(f"samples must be 1 or more, got {samples}.")
    share = correlation + (1.0 - correlation) / samples
    return 1.0 - occlusion**2 - occlusion * (1.0 - occlusion) * share


def seen_at_least_once(occlusion: float, samples: float) -> float:
    """Return the share of the ground that at least one of N independent samples sees: 1 - D^N.

    It is what the union of anomaly masks can reach (spec, section 2).

    Raises:
        ConfigurationError: if a number is out of its range.
    """
    _require_share("occlusion", occlusion)
    if not samples >= 1.0:
        raise ConfigurationError(f"samples must be 1 or more, got {samples}.")
    return 1.0 - float(occlusion**samples)


def samples_for(occlusion: float, saturation: float) -> int:
    """Return the fewest samples whose integral visibility is this share of what infinitely many would reach.

    V(N) / V(∞) = 1 - D / ((1 + D) N): ten samples reach 95 % whatever D is.

    Args:
        occlusion: D, 0 to 1.
        saturation: wanted share, at least 0 and below 1.

    Raises:
        ConfigurationError: if a number is out of its range.
    """
    _require_share("occlusion", occlusion)
    if not 0.0 <= saturation < 1.0:
        raise ConfigurationError(f"saturation must be at least 0 and below 1, got {saturation}.")
    # Rounding must not ask for an eleventh sample where ten do exactly.
    return max(1, math.ceil(occlusion / ((1.0 + occlusion) * (1.0 - saturation)) - 1e-9))


def footprint_m(altitude_m: float, fov_rad: float) -> float:
    """Return the width that a nadir camera sees of a plane below it.

    Raises:
        ConfigurationError: if a number is out of its range.
    """
    _require_positive("altitude_m", altitude_m)
    if not 0.0 < fov_rad < math.pi:
        raise ConfigurationError(
            f"The field of view must lie between 0 and 180 degrees, got {math.degrees(fov_rad):g}."
        )
    return 2.0 * altitude_m * math.tan(fov_rad / 2.0)


@dataclass(frozen=True, slots=True)
class AperturePlan:
    """A proposal for a mission."""

    spacing_m: float
    """c4: the smallest useful spacing at the highest layer, so that no layer is too dense."""
    drones: int
    layers_m: tuple[float, ...]
    """Heights above the focal plane, one per drone."""
    samples_in_view: int
    """Drones of the aperture, packed over a target, whose cameras have the target in view."""
    visibility: float
    """Visibility of the integral, see :func:`integral_visibility`."""
    single_visibility: float
    """Visibility of one image."""
    saturation: float
    """Share of the visibility that infinitely many samples would reach."""
    seen_at_least_once: float
    reasons: tuple[str, ...]
    """Origin and limits of each number, in whole sentences."""


def plan_aperture(
    *,
    altitude_m: float,
    fov_rad: float,
    canopy_height_m: float,
    crown_base_m: float,
    occluder_size_m: float,
    occlusion: float,
    saturation: float = 0.95,
    layer_spacing_m: float = 2.0,
    drones: int | None = None,
) -> AperturePlan:
    """Propose spacing, number and layers of drones.

    Args:
        altitude_m: height of the lowest layer above the ground.
        fov_rad: field of view of the cameras, the smaller of both axes.
        canopy_height_m: height of the tree tops above the ground.
        crown_base_m: height at which crowns begin.
        occluder_size_m: diameter of what hides the ground as a whole: twigs with their leaves rather than one leaf.
        occlusion: share of rays to the ground that meet the canopy, 0 to 1.
        saturation: share of the reachable visibility that the number of drones is chosen for.
        layer_spacing_m: between the heights of two drones; 0 if all fly at one height.
        drones: to be used instead of the proposed number.

    Raises:
        ConfigurationError: if a number is out of its range; the text names it.
    """
    _check_forest(altitude_m, canopy_height_m, crown_base_m, layer_spacing_m)
    needed = max(2, samples_for(occlusion, saturation))
    count = needed if drones is None else drones
    if not 1 <= count <= MAX_DRONES:
        raise ConfigurationError(
            f"A mission has 1 to {MAX_DRONES} drones, got {count}: give another number, or a lower saturation."
        )
    layers_m = tuple(altitude_m + layer_spacing_m * layer for layer in range(count))
    occluder_height_m = (crown_base_m + canopy_height_m) / 2.0
    spacing_m = smallest_spacing_m(layers_m[-1], occluder_height_m, occluder_size_m)
    packed_m = packed_aperture_m(count, spacing_m)
    # The lowest camera sees the least; a target in the middle needs the disc within half a footprint.
    view_m = footprint_m(altitude_m, fov_rad)
    in_view = count if packed_m <= view_m else max(1, math.floor(count * (view_m / packed_m) ** 2))
    visibility = integral_visibility(occlusion, in_view)
    return AperturePlan(
        spacing_m=spacing_m,
        drones=count,
        layers_m=layers_m,
        samples_in_view=in_view,
        visibility=visibility,
        single_visibility=1.0 - occlusion,
        saturation=visibility / integral_visibility(occlusion, math.inf) if occlusion < 1.0 else 0.0,
        seen_at_least_once=seen_at_least_once(occlusion, in_view),
        reasons=(
            _spacing_reason(spacing_m, layers_m[-1], occluder_size_m, occluder_height_m),
            _number_reason(needed, saturation, occlusion, drones),
            _aperture_reason(packed_m, spacing_m * (count - 1), view_m, in_view, count),
        ),
    )


def packed_aperture_m(count: int, spacing_m: float) -> float:
    """Return the diameter of a disc that holds so many cameras at this spacing, packed as densely as discs can be."""
    return spacing_m * math.sqrt(count / DISC_PACKING)


def _spacing_reason(spacing_m: float, highest_m: float, occluder_size_m: float, occluder_height_m: float) -> str:
    return (
        f"Spacing {spacing_m:.1f} m: from {highest_m:g} m, the highest layer, this moves occluders of "
        f"{occluder_size_m:g} m at {occluder_height_m:.1f} m height by their own projected size; closer cameras share "
        "occluders, wider ones gain nothing."
    )


def _number_reason(needed: int, saturation: float, occlusion: float, given: int | None) -> str:
    choice = "" if given is None else f"; {given} were given"
    return (
        f"Drones: {needed} reach {saturation:.0%} of the visibility of infinitely many where the canopy hides "
        f"{occlusion:.0%} of the ground{choice}."
    )


def _aperture_reason(packed_m: float, line_m: float, view_m: float, in_view: int, count: int) -> str:
    return (
        f"Aperture {packed_m:.1f} m over a target, {line_m:.1f} m in line: the lowest camera sees "
        f"{view_m:.1f} m of the ground, so that {in_view} of {count} have a target below the middle in view."
    )


def _check_forest(altitude_m: float, canopy_height_m: float, crown_base_m: float, layer_spacing_m: float) -> None:
    _require_positive("altitude_m", altitude_m)
    if not 0.0 <= crown_base_m < canopy_height_m:
        raise ConfigurationError(
            f"crown_base_m must be at least 0 and below canopy_height_m ({canopy_height_m:g}), got {crown_base_m:g}."
        )
    if not altitude_m > canopy_height_m:
        raise ConfigurationError(
            f"altitude_m must be above the tree tops ({canopy_height_m:g} m), got {altitude_m:g}: fly higher."
        )
    if not 0.0 <= layer_spacing_m < math.inf:
        raise ConfigurationError(f"layer_spacing_m must be a finite number not below 0, but is {layer_spacing_m}.")


def _require_positive(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ConfigurationError(f"{name} must be finite and above 0, got {value}.")


def _require_share(name: str, value: float) -> None:
    if not 0.0 <= value <= 1.0:
        raise ConfigurationError(f"{name} must lie within 0 and 1, got {value}.")
