"""Pictures of tiles from servers: what they are, and as one kind where a server mixes several."""

from __future__ import annotations

import io
from typing import Any, Final

from aos_gcs.basemaps.archive import TileFormat
from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra

_SIDES_PX: Final = (256, 512)
_FORMATS: Final = tuple(kind.value for kind in (TileFormat.PNG, TileFormat.JPEG, TileFormat.WEBP))
_QUALITY: Final = 85
_PURPOSE: Final = "Copying tiles"


def kind_of(content: bytes) -> TileFormat:
    """Return the kind of a tile, by its content alone. It is decoded once, when its size is known to be that of a tile.

    Raises:
        ConfigurationError: the library pillow is not installed.
        InputDataError: it is not one of the kinds that the page shows, not of the size of a tile, or damaged; the text
            is a clause without a subject.
    """
    picture = _opened(content)
    width, height = picture.size
    if width != height or width not in _SIDES_PX:
        raise InputDataError(f"has {width} x {height} pixels, not {_SIDES_PX[0]} or {_SIDES_PX[1]} on each side")
    try:
        picture.load()
    except (OSError, SyntaxError, ValueError) as error:
        raise InputDataError("is a damaged picture") from error
    return TileFormat(picture.format)


def as_webp(content: bytes) -> bytes:
    """Return a tile that :func:`kind_of` has accepted as WebP; one that is WebP stays as it is."""
    picture = _opened(content)
    if picture.format == TileFormat.WEBP:
        return content
    output = io.BytesIO()
    picture.convert("RGBA").save(output, "WEBP", quality=_QUALITY)
    return output.getvalue()


def _opened(content: bytes) -> Any:
    library: Any = load_extra("PIL.Image", "geo", _PURPOSE)
    try:
        return library.open(io.BytesIO(content), formats=_FORMATS)
    except (OSError, SyntaxError, ValueError, library.DecompressionBombError) as error:
        raise InputDataError("is no PNG, JPEG or WebP picture") from error
