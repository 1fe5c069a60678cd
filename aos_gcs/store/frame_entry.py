"""Recorded frames, and values as the rows of a database hold them."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.ports import Capture
from aos_gcs.store.codec import decode
from aos_gcs.store.images import EncodedImage, StoredBands, decode_bands, decode_image

MAX_UTC_S: Final = 1e11
"""Latest time of a record that is believed: the year 5138."""
DAMAGE: Final = (ValueError, TypeError, OverflowError, RecursionError)
"""What reading damaged data raises; data that are nested too deeply exhaust the parser's recursion."""


@dataclass(frozen=True, slots=True)
class FrameEntry:
    """A recorded frame, its image still on the disk."""

    step: int
    vehicle_id: int
    path: Path
    time_sigma_s: float | None
    """Standard deviation of the pose's time; None where it was not reported, and in older recordings."""
    digest: str | None
    """Digest of the frame as it was recorded; None in older recordings."""
    _row: sqlite3.Row

    @property
    def utc_s(self) -> float:
        """Time of exposure.

        Raises:
            InputDataError: the row is damaged.
        """
        with _explained(self.path, "time"):
            return time_s(self._row)

    @property
    def number(self) -> int:
        """Number of the frame in the record; later frames have greater ones."""
        with _explained(self.path, "number"):
            return int(typed(self._row, "id", int))

    @property
    def image_index(self) -> int:
        """Number of the image at its vehicle, in a survey its index in the recording.

        Raises:
            InputDataError: the row is damaged.
        """
        with _explained(self.path, "image index"):
            return int(typed(self._row, "image_index", int))

    def bands(self) -> tuple[str, ...]:
        """Return what the channels of the image are.

        Raises:
            InputDataError: the row is damaged.
        """
        with _explained(self.path, "bands"):
            return decode(tuple[str, ...], json.loads(self._row["bands"]))

    def pose(self) -> tuple[GeodeticPosition, NDArray[np.float64]]:
        """Return position and orientation at the exposure, as of ``Capture``.

        Raises:
            InputDataError: the row is damaged.
        """
        with _explained(self.path, "pose"):
            rotation = np.array(json.loads(self._row["R_cam2enu"]), dtype=np.float64).reshape(3, 3)
            return self._position(), rotation

    def _position(self) -> GeodeticPosition:
        names = ("latitude_deg", "longitude_deg", "altitude_amsl_m")
        return GeodeticPosition(*(typed(self._row, name, int, float) for name in names))

    def load(self) -> Capture:
        """Return the frame as the mission has seen it.

        Raises:
            InputDataError: the image file is missing or damaged.
        """
        try:
            return self._load()
        except (OSError, InputDataError, *DAMAGE) as error:
            raise InputDataError(f"cannot read the frame {self.path}: {error}") from error

    def load_bands(self, wanted: Sequence[Sequence[str]]) -> tuple[StoredBands, ...]:
        """Return some bands of the image for each choice of them, thermal alone or others; its file is read once.

        Raises:
            InputDataError: the image file is missing or damaged, or the frame has no such band.
        """
        try:
            bands, encoded = self.bands(), self._encoded()
            return tuple(decode_bands(encoded, bands, self._row["dtype"], choice) for choice in wanted)
        except (OSError, InputDataError, *DAMAGE) as error:
            raise InputDataError(f"cannot read the frame {self.path}: {error}") from error

    def _encoded(self) -> EncodedImage:
        return EncodedImage(self.path.suffix, self.path.read_bytes())

    def _load(self) -> Capture:
        row = self._row
        bands = decode(tuple[str, ...], json.loads(row["bands"]))
        image = decode_image(self._encoded(), bands, row["dtype"])
        return Capture(
            vehicle_id=self.vehicle_id,
            image_index=typed(row, "image_index", int),
            utc_s=time_s(row),
            image=image,
            bands=bands,
            position=self._position(),
            R_cam2enu=np.array(json.loads(row["R_cam2enu"])),
            camera=decode(CameraModel, json.loads(row["camera"])),
            time_sigma_s=self.time_sigma_s,
        )


@contextmanager
def _explained(path: Path, what: str) -> Iterator[None]:
    """Turn what damaged rows raise into errors that name the frame."""
    try:
        yield
    except DAMAGE as error:
        raise InputDataError(f"cannot read the {what} of the frame {path}: {error}") from error


def typed(row: sqlite3.Row, column: str, *kinds: type) -> Any:
    """Return a value of one of these types; SQLite keeps any value in any column."""
    value = row[column]
    if type(value) not in kinds:
        raise ValueError(f"{column} is {str(value)[:40]!r}")
    return value


def time_s(row: sqlite3.Row) -> float:
    """Return the time of a row, if it is one."""
    utc_s: float = typed(row, "utc_s", int, float)
    if not 0.0 <= utc_s <= MAX_UTC_S:
        raise ValueError(f"{utc_s!r} is not a time")
    return utc_s
