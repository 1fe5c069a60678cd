"""XML that every parser reads, whatever texts it holds."""

from __future__ import annotations

import re
from typing import Final
from xml.etree import ElementTree as ET

_NOT_IN_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold, even escaped. Comments have them where they were pasted from other programs."""


def readable(text: str) -> str:
    """Return a text with replacements for the characters that XML cannot hold."""
    return _NOT_IN_XML.sub("\ufffd", text)


def xml_document(root: ET.Element) -> str:
    """Return an indented document; characters that XML cannot hold are replaced."""
    ET.indent(root)
    text = readable(ET.tostring(root, encoding="unicode"))
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'
