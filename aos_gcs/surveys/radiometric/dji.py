"""Temperatures of DJI's radiometric JPEG files, by DJI's Thermal SDK in processes of its own.

The SDK is no part of aos-gcs. It reads files from outside, and one that makes it fail costs this file's temperatures
alone.
"""

from __future__ import annotations

import atexit
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from queue import LifoQueue
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import AosError, ConfigurationError, InputDataError, WorkerError
from aos_gcs.surveys.radiometric.dji_library import measure, picture_size
from aos_gcs.surveys.radiometric.settings import MeasurementConditions
from aos_gcs.workers.process import Child, WorkerSettings

T = TypeVar("T")

_LIBRARY = "libdirp.so"
_FOLDERS = (".", "linux/release_x64", "tsdk-core/lib/linux/release_x64")
"""Folders in which it is looked for, from the one that is given."""
_COLDEST_C = -100.0
"""Temperature below which the SDK says that it has none."""
_MEMORY_BYTES = 2 * 2**30
_TIMEOUT_S = 60.0


def find_library(folder: Path) -> Path:
    """Return the library in a folder, or in the unpacked SDK.

    Raises:
        ConfigurationError: if it is not there.
    """
    for place in _FOLDERS:
        library = folder / place / _LIBRARY
        if library.is_file():
            return library.resolve()
    raise ConfigurationError(
        f"--dji-sdk {folder} has no {_FOLDERS[-1]}/{_LIBRARY}: give the folder of DJI's Thermal SDK."
    )


@cache
def thermal_sdk(library: Path) -> ThermalSdk:
    """Return the one user of a library in this process."""
    sdk = ThermalSdk(library)
    atexit.register(sdk.close)
    return sdk


class ThermalSdk:
    """DJI's Thermal SDK in a process per processor core, each of which begins when it is needed; for any thread.

    Args:
        library: ``libdirp.so``, beside the libraries that it needs.
    """

    def __init__(self, library: Path) -> None:
        self._library = library
        folders = (str(library.parent), os.environ.get("LD_LIBRARY_PATH", ""))
        self._settings = WorkerSettings(
            name="DJI's Thermal SDK",
            memory_bytes=_MEMORY_BYTES,
            timeout_s=_TIMEOUT_S,
            modules=(measure.__module__,),
            environment={"LD_LIBRARY_PATH": os.pathsep.join(filter(None, folders))},
        )
        self._processes = os.cpu_count() or 1
        # The last one that was used comes first, so that one thread alone needs one process.
        self._idle: LifoQueue[Child | None] = LifoQueue()
        for _ in range(self._processes):
            self._idle.put(None)

    def celsius(self, content: bytes, conditions: MeasurementConditions) -> NDArray[np.float32]:
        """Return the temperatures of objects, degrees Celsius, shape (H, W).

        Raises:
            InputDataError: with the reason alone, if the file has none, or the SDK refuses it or the conditions.
            ConfigurationError: if the library cannot be used.
        """
        celsius = self._call(measure, content, conditions)
        if not (np.isfinite(celsius) & (celsius > _COLDEST_C)).all():
            raise InputDataError("DJI's Thermal SDK gives no temperatures for some of its pixels")
        return celsius

    def size_px(self, content: bytes, conditions: MeasurementConditions) -> tuple[int, int]:
        """Return height and width of the temperatures of a photograph, without measuring them.

        Raises:
            InputDataError: as of :meth:`celsius`.
            ConfigurationError: as of :meth:`celsius`.
        """
        return self._call(picture_size, content, conditions)

    def close(self) -> None:
        """End the processes, when each has done what it does."""
        for child in [self._idle.get() for _ in range(self._processes)]:
            _end(child)
            self._idle.put(None)

    def _call(
        self,
        function: Callable[[str, bytes, MeasurementConditions], T],
        content: bytes,
        conditions: MeasurementConditions,
    ) -> T:
        child = self._idle.get()
        try:
            child = child or Child(self._settings)
            has_returned, result = child.call(function, (str(self._library), content, conditions), {})
        except (WorkerError, OSError) as error:
            _end(child)
            child = None
            raise InputDataError(f"{error}: the file is damaged, or of a camera newer than the SDK") from error
        finally:
            self._idle.put(child)
        if not has_returned:
            raise result if isinstance(result, AosError) else InputDataError(f"DJI's Thermal SDK failed: {result}")
        returned: T = result
        return returned


def _end(child: Child | None) -> None:
    if child is not None:
        child.kill()
        child.release()
