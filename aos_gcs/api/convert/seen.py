"""Name of a state of the mission, which clients return with a command that is based on it."""

from __future__ import annotations

import re
from typing import Final
from urllib.parse import quote, unquote

from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.actions import Seen

_FORM: Final = re.compile(r"(?P<mission>[\w.%~-]{1,300})/(?P<count>\d{1,9})/(?P<at_ms>\d{1,15})", re.ASCII)


def seen_text(seen: Seen) -> str:
    """Return the text that stands for a state: ASCII without blanks and quotes, for a header."""
    return f"{quote(seen.mission_id, safe='')}/{seen.command_count}/{round(seen.at_s * 1000)}"


def parse_seen(text: str) -> Seen:
    """Return the state that a text stands for.

    Raises:
        InputDataError: it stands for none.
    """
    found = _FORM.fullmatch(text)
    if found is None:
        raise InputDataError("X-Seen: this is not a state of a mission. Send what GET /api/mission has returned in it.")
    return Seen(unquote(found["mission"]), int(found["count"]), int(found["at_ms"]) / 1000)
