"""The flat ground: litter and moss under the trees, meadow elsewhere, as tiling textures in world coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_sim.world.mesh import FloatArray

TILE_CELLS = 256
CELL_M = 0.1
GROUND_TEMPERATURE_CELSIUS = 10.8

_LITTER = np.array([98, 78, 56], np.float32)
_MOSS = np.array([72, 82, 46], np.float32)
_MEADOW = np.array([92, 112, 58], np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """Textures of the plane z = 0; each tile covers ``TILE_CELLS * CELL_M`` metres and repeats without a seam."""

    forest_tile: FloatArray
    """Red, green, blue (0 to 255 in white light) and temperature in °C, shape (TILE_CELLS, TILE_CELLS, 4)."""
    meadow_tile: FloatArray
    west_m: float
    """Western edge of the forest square."""
    south_m: float
    side_m: float

    def sample(self, east_m: NDArray[np.floating], north_m: NDArray[np.floating]) -> FloatArray:
        """Return red, green, blue and °C at points of the plane, shape (n, 4)."""
        row, column = _tile_index(north_m), _tile_index(east_m)
        under_trees = (np.abs(east_m - (self.west_m + self.side_m / 2)) < self.side_m / 2) & (
            np.abs(north_m - (self.south_m + self.side_m / 2)) < self.side_m / 2
        )
        samples = self.forest_tile[row, column]
        outside = np.flatnonzero(~under_trees)
        samples[outside] = self.meadow_tile[row[outside], column[outside]]
        return samples


def make_ground(rng: np.random.Generator, west_m: float, south_m: float, side_m: float) -> Ground:
    """Draw the textures."""
    moss = np.clip(0.3 + 0.4 * _periodic_noise(rng, exponent=1.5), 0.0, 1.0)[..., None]
    litter = (_LITTER * (1 - moss) + _MOSS * moss) * (1 + 0.16 * _periodic_noise(rng, exponent=0.6)[..., None])
    meadow = _MEADOW * (1 + 0.1 * _periodic_noise(rng, exponent=0.8)[..., None])
    return Ground(_tile(rng, litter), _tile(rng, meadow), west_m, south_m, side_m)


def _tile(rng: np.random.Generator, albedo_rgb: NDArray[np.floating]) -> FloatArray:
    celsius = GROUND_TEMPERATURE_CELSIUS + 0.5 * _periodic_noise(rng, exponent=1.0)
    return np.dstack([np.clip(albedo_rgb, 0, 255), celsius]).astype(np.float32)


def _periodic_noise(rng: np.random.Generator, exponent: float) -> FloatArray:
    """Noise whose amplitude falls with frequency to the power of ``exponent``; mean 0, deviation 1, tiling."""
    frequency = np.hypot(np.fft.fftfreq(TILE_CELLS)[:, None], np.fft.rfftfreq(TILE_CELLS)[None])
    frequency[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.standard_normal((TILE_CELLS, TILE_CELLS))) / frequency**exponent
    noise = np.fft.irfft2(spectrum, s=(TILE_CELLS, TILE_CELLS))
    return np.asarray(noise / noise.std(), dtype=np.float32)


def _tile_index(coordinate_m: NDArray[np.floating]) -> NDArray[np.intp]:
    return np.asarray(np.floor(coordinate_m / CELL_M).astype(np.intp) % TILE_CELLS)
