"""Temperatures of DJI's radiometric JPEG files, by DJI's Thermal SDK in a process of its own.

The SDK is no part of aos-gcs. It reads files from outside, and one that makes it fail costs this file's temperatures
alone.
"""

from __future__ import annotations

import atexit
import os
from functools import cache
from pathlib import Path
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import AosError, ConfigurationError, InputDataError, WorkerError
from aos_gcs.surveys.radiometric.dji_library import measure
from aos_gcs.surveys.radiometric.settings import Scene
from aos_gcs.workers.process import Child, WorkerSettings

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
    """DJI's Thermal SDK in a process, which begins with the first photograph; for any thread.

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
        self._child: Child | None = None
        self._lock = Lock()

    def celsius(self, content: bytes, scene: Scene) -> NDArray[np.float32]:
        """Return the temperatures of objects, degrees Celsius, shape (H, W).

        Raises:
            InputDataError: with the reason alone, if the file has none, or the SDK refuses it or the conditions.
            ConfigurationError: if the library cannot be used.
        """
        with self._lock:
            try:
                self._child = self._child or Child(self._settings)
                has_returned, result = self._child.call(measure, (str(self._library), content, scene), {})
            except (WorkerError, OSError) as error:
                self._end()
                raise InputDataError(f"{error}: the file is damaged, or of a camera newer than the SDK") from error
        if not has_returned:
            raise result if isinstance(result, AosError) else InputDataError(f"DJI's Thermal SDK failed: {result}")
        celsius: NDArray[np.float32] = result
        if not (np.isfinite(celsius) & (celsius > _COLDEST_C)).all():
            raise InputDataError("DJI's Thermal SDK gives no temperatures for some of its pixels")
        return celsius

    def close(self) -> None:
        """End the process."""
        with self._lock:
            self._end()

    def _end(self) -> None:
        if self._child is not None:
            self._child.kill()
            self._child.release()
            self._child = None
