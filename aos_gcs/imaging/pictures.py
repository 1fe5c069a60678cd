"""Rasters of a step as pictures for operators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.indexed import IndexedPicture
from aos_gcs.imaging.model import Frame, StepAnalysis
from aos_gcs.imaging.step.integration import integrate
from aos_gcs.imaging.workers import parallel_map

COLOUR_BANDS = ("red", "green", "blue")

CONTRAST_PERCENTILES = (1.0, 99.0)
"""Percentiles of the covered cells that are stretched to black and white; the rest saturates: one hot cell must not dim
a picture."""

THERMAL_CONTRAST_PERCENTILES = (1.0, 99.98)
"""A person is a few cells among many, and what the eye must find: it must not saturate with the warmer leaves."""

CONTRAST_SAMPLES = 20_000
"""Cells that the percentiles are estimated from; more cost time and change no visible shade."""

MAX_CELLS = 250_000
"""Largest number of cells of a picture; larger rasters are reduced, because encoding takes longer than all else."""

KINDS = ("integral", "thermal", "anomaly", "coverage")
"""Colours or grey; temperatures; number of frames that mark a cell; number of frames that see it."""

_PNG_OPTIONS = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE]
"""Run lengths are faster than the default search for matches, which finds next to none in noise."""
if hasattr(cv2, "IMWRITE_PNG_FILTER"):
    # One filter for all rows, where OpenCV lets it be chosen: to try five for each takes as long as the compression.
    _PNG_OPTIONS += [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_SUB]

_JPEG_OPTIONS = [cv2.IMWRITE_JPEG_QUALITY, 85]


@dataclass(frozen=True, slots=True)
class RasterPicture:
    """A north-up RGBA picture of the focal plane, transparent where nothing covers."""

    kind: str
    """One of :data:`KINDS`."""
    png: bytes = field(repr=False)
    west_m: float
    south_m: float
    east_m: float
    north_m: float


def render_pictures(frames: Sequence[Frame], analysis: StepAnalysis) -> tuple[RasterPicture, ...]:
    """Return pictures of a step, one of temperatures only where there is such a band.

    Args:
        frames: the step's frames that took part in the analysis.
        analysis: analysis of the step.
    """
    mean = integrate(frames, analysis.grid, picture_shape(*analysis.coverage.shape)).mean
    images = _shade(analysis, mean, frames[0].bands, KINDS[:3])
    encoded = parallel_map(_encode, images.values())
    grid = analysis.grid
    return tuple(
        RasterPicture(
            kind=kind,
            png=png,
            west_m=grid.west_m,
            south_m=grid.north_m - grid.rows * grid.resolution_m,
            east_m=grid.west_m + grid.columns * grid.resolution_m,
            north_m=grid.north_m,
        )
        for kind, png in zip(images, encoded, strict=True)
    )


def shade_step(
    analysis: StepAnalysis, integral: NDArray[np.float32] | None, bands: tuple[str, ...], kinds: Sequence[str]
) -> dict[str, NDArray[np.uint8]]:
    """Return a step as RGBA by kind, shape (H, W, 4), reduced to :data:`MAX_CELLS`.

    Args:
        analysis: analysis of the step.
        integral: mean of its frames, shape (rows, columns, C) of the analysis or of the pictures, NaN where nothing
            covers; None: not among the kinds.
        bands: bands of the frames.
        kinds: some of :data:`KINDS`.
    """
    images = _shade(analysis, integral, bands, kinds)
    return {kind: image.rgba() if isinstance(image, IndexedPicture) else image for kind, image in images.items()}


def _shade(
    analysis: StepAnalysis, integral: NDArray[np.float32] | None, bands: tuple[str, ...], kinds: Sequence[str]
) -> dict[str, NDArray[np.uint8] | IndexedPicture]:
    """Return what :func:`shade_step` does, of few colours as such."""
    size = picture_shape(*analysis.coverage.shape)[::-1]
    # Nearest keeps counts whole.
    coverage = np.asarray(cv2.resize(analysis.coverage, size, interpolation=cv2.INTER_NEAREST), dtype=np.uint16)
    # Where few frames overlap, leaves and noise are not averaged away; they must not set the contrast.
    well_covered = coverage >= max(1, int(analysis.coverage.max()) // 2)
    images: dict[str, NDArray[np.uint8] | IndexedPicture] = {}
    if integral is not None:
        reduced = _reduce_integral(integral, size)
        if "integral" in kinds:
            images["integral"] = shade_integral(reduced, bands, well_covered)
        if "thermal" in kinds and "thermal" in bands:
            images["thermal"] = _index_thermal(reduced[:, :, bands.index("thermal")], well_covered)
    if "anomaly" in kinds:
        images["anomaly"] = _index_counts(_reduce_counts(analysis.anomaly_count, size), coverage > 0)
    if "coverage" in kinds:
        images["coverage"] = _index_counts(coverage, coverage > 0)
    return images


def shade_integral(
    integral: NDArray[np.float32], bands: tuple[str, ...], contrast_from: NDArray[np.bool] | None = None
) -> NDArray[np.uint8]:
    """Return an integral, shape (H, W, C), as RGBA, shape (H, W, 4), with robust contrast.

    In colour where there are red, green and blue, else the first band in grey; transparent where it is NaN.

    Args:
        integral: NaN where nothing covers.
        bands: one per channel.
        contrast_from: cells that set the contrast, shape (H, W); None: all of them.
    """
    colour = all(band in bands for band in COLOUR_BANDS)
    chosen = [bands.index(band) for band in COLOUR_BANDS] if colour else [0, 0, 0]
    # One stretch for all three bands: hues stay as they are.
    distinct = integral[:, :, chosen] if colour else integral[:, :, :1]
    shades = _stretch(distinct, contrast_from, CONTRAST_PERCENTILES)
    rgba = cv2.cvtColor(shades, cv2.COLOR_RGB2RGBA if colour else cv2.COLOR_GRAY2RGBA)
    rgba[:, :, 3] = _alpha(~np.isnan(distinct[:, :, 0]))
    return np.asarray(rgba, dtype=np.uint8)


def encode_png(rgba: NDArray[np.uint8]) -> bytes:
    """Return an RGBA image, shape (H, W, 4), as a PNG file."""
    bgra = cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGRA)
    return cv2.imencode(".png", bgra, _PNG_OPTIONS)[1].tobytes()


def encode_jpeg(rgba: NDArray[np.uint8]) -> bytes:
    """Return an RGBA image, shape (H, W, 4), as a JPEG file: fast and small, not exact; black where transparent."""
    bgr = cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR)
    bgr[rgba[:, :, 3] == 0] = 0
    return cv2.imencode(".jpg", bgr, _JPEG_OPTIONS)[1].tobytes()


def shade_thermal(band: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return temperatures, shape (H, W), as RGBA, shape (H, W, 4), from black to yellow; transparent where NaN.

    Args:
        band: in any unit.
    """
    return _index_thermal(band, None).rgba()


def _index_thermal(band: NDArray[np.float32], contrast_from: NDArray[np.bool] | None) -> IndexedPicture:
    shades = _stretch(band, contrast_from, THERMAL_CONTRAST_PERCENTILES)
    return IndexedPicture.of(np.arange(256, dtype=np.uint8), shades, ~np.isnan(band))


def shade_counts(counts: NDArray[np.uint16], covered: NDArray[np.bool]) -> NDArray[np.uint8]:
    """Return counts as RGBA, shape (H, W, 4): marked cells from orange to yellow-white on black.

    Args:
        counts: shape (H, W).
        covered: cells where the picture is not transparent, shape (H, W).
    """
    return _index_counts(counts, covered).rgba()


def _index_counts(counts: NDArray[np.uint16], covered: NDArray[np.bool]) -> IndexedPicture:
    # The upper half of the map: one marking frame must already stand out.
    numbers = np.arange(int(counts.max(initial=0)) + 1)
    shades = np.where(numbers > 0, 128 + numbers * np.float32(127.0 / max(int(numbers[-1]), 1)), 0.0)
    return IndexedPicture.of(shades.astype(np.uint8), counts, covered)


def _encode(image: NDArray[np.uint8] | IndexedPicture) -> bytes:
    return image.png() if isinstance(image, IndexedPicture) else encode_png(image)


def picture_shape(rows: int, columns: int) -> tuple[int, int]:
    """Return rows and columns of the picture of a raster: at most about :data:`MAX_CELLS`."""
    scale = min(1.0, (MAX_CELLS / (rows * columns)) ** 0.5)
    return max(1, round(rows * scale)), max(1, round(columns * scale))


def _reduce_integral(integral: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    """Average the cells that each pixel stands for, which also averages their noise; NaN takes no part."""
    known = ~np.isnan(integral[:, :, 0])
    if known.shape == size[::-1]:
        return integral
    total = cv2.resize(np.where(known[:, :, np.newaxis], integral, 0.0), size, interpolation=cv2.INTER_AREA)
    weight = cv2.resize(known.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    total = total.reshape(*size[::-1], integral.shape[2])
    return np.asarray(total / np.where(weight > 0.0, weight, np.nan)[:, :, np.newaxis], dtype=np.float32)


def _reduce_counts(counts: NDArray[np.uint16], size: tuple[int, int]) -> NDArray[np.uint16]:
    """Resize counts so that a single marked cell survives a reduction."""
    factor = int(np.ceil(counts.shape[1] / size[0] - 1e-6))
    if factor > 1:
        counts = cv2.dilate(counts, np.ones((factor, factor), dtype=np.uint8)).astype(np.uint16)
    return np.asarray(cv2.resize(counts, size, interpolation=cv2.INTER_NEAREST), dtype=np.uint16)


def _stretch(
    values: NDArray[np.float32], contrast_from: NDArray[np.bool] | None, percentiles: tuple[float, float]
) -> NDArray[np.uint8]:
    # Cells of all bands are chosen before their values are taken out: few are needed.
    cells = np.arange(values.shape[0] * values.shape[1]) if contrast_from is None else np.flatnonzero(contrast_from)
    bands = values.size // max(values.shape[0] * values.shape[1], 1)
    cells = cells[:: max(1, cells.size * bands // CONTRAST_SAMPLES)]
    samples = values.reshape(-1, bands)[cells].reshape(-1)
    samples = samples[~np.isnan(samples)]
    if not samples.size:
        samples = np.zeros(1, dtype=np.float32)
    low, high = np.percentile(samples, percentiles)
    gain = 255.0 / max(float(high - low), 1e-6)
    shades = np.subtract(values, np.float32(low), dtype=np.float32)
    shades *= np.float32(gain)
    # Of NaN and a number, fmax returns the number: what is unknown turns black, without a search for it.
    np.fmax(shades, np.float32(0.0), out=shades)
    return np.fmin(shades, np.float32(255.0), out=shades).astype(np.uint8)


def _alpha(covered: NDArray[np.bool]) -> NDArray[np.uint8]:
    return covered.astype(np.uint8) * np.uint8(255)
