"""Libraries that not every installation has: named when they are missing."""

from __future__ import annotations

import importlib
from types import ModuleType

from aos_gcs.errors import ConfigurationError


def load_extra(module: str, extra: str, purpose: str) -> ModuleType:
    """Import a module of an optional extra.

    Args:
        module: dotted name.
        extra: extra of this distribution that installs it.
        purpose: subject of the error's sentence, e.g. ``Reading a GeoTIFF``.

    Raises:
        ConfigurationError: if it is not installed; the text says how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        library = module.partition(".")[0]
        raise ConfigurationError(
            f"{purpose} needs {library}, which is not installed: pip install 'aos-gcs[{extra}]'."
        ) from error
