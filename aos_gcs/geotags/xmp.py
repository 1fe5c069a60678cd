"""The XMP packet of a photograph as a flat table.

Manufacturers use namespaces of their own for the same names, so that a name is looked up without its namespace.
Photographs come from outside: XML is parsed by defusedxml.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, Final
from xml.etree.ElementTree import Element, ParseError

from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra

_MAX_DEPTH: Final = 64
"""Deepest nesting of elements; packets of cameras have up to about ten."""
_RDF = "{http://www.w3.org/1999/02/22-rdf-syntax-ns#}"
_END = b"</x:xmpmeta>"
_GDAL_DOMAIN = b"xml:XMP="
_REPEATED_NAMESPACE = re.compile(rb"""(\sxmlns:([\w.-]+)=("[^"]*"|'[^']*'))(?:\s+xmlns:\2=\3)+""")


def parse_xmp(packet: bytes) -> dict[str, str]:
    """Return the properties of an XMP packet by local name; members of structures as ``structure/member``.

    Where a name stands more than once, the first one counts.

    Raises:
        InputDataError: if the packet is no well-formed XML, or tries what XML of a photograph has no need of.
    """
    defusedxml: Any = load_extra("defusedxml.ElementTree", "geo", "Reading the position of a photograph")
    try:
        root: Element = defusedxml.fromstring(_well_formed(packet))
    except (ParseError, ValueError) as error:
        # What defusedxml forbids derives from ValueError.
        raise InputDataError(f"its XMP is not valid XML: {error}") from error
    if _is_deep(root):
        raise InputDataError("its XMP is nested too deeply")
    table: dict[str, str] = {}
    for description in root.iter(f"{_RDF}Description"):
        for name, value in _properties(description):
            table.setdefault(name, value)
    return table


def first_number(xmp: Mapping[str, str], *names: str) -> float | None:
    """Return the first of some properties that is a finite number, as a decimal or as a fraction; None without one."""
    for name in names:
        try:
            numerator, slash, denominator = xmp[name].partition("/")
            number = float(numerator) / (float(denominator) if slash else 1.0)
        except (KeyError, ValueError, ArithmeticError):
            continue
        if math.isfinite(number):
            return number
    return None


def _well_formed(packet: bytes) -> bytes:
    """Return a packet as its camera meant it.

    Packets are padded with spaces, some with zeros; the Zenmuse XT S declares a namespace twice, and leaves the
    instruction behind the document unfinished. GDAL puts the name of its domain before those that it copies.
    """
    document, end, _ = packet.rpartition(_END)
    return _REPEATED_NAMESPACE.sub(rb"\1", (document + end or packet).strip(b"\0 \r\n\t").removeprefix(_GDAL_DOMAIN))


def _is_deep(root: Element) -> bool:
    """Return whether elements are nested deeper than functions may call themselves, whatever Python's own limit is."""
    level = [root]
    for _ in range(_MAX_DEPTH):
        level = [child for element in level for child in element]
        if not level:
            return False
    return True


def _properties(element: Element) -> list[tuple[str, str]]:
    found = [(_local(name), value.strip()) for name, value in element.attrib.items() if not name.startswith(_RDF)]
    for child in element:
        name = _local(child.tag)
        inner = [(f"{name}/{member}", value) for member, value in _properties(child)]
        found += inner or [(name, (child.text or "").strip())]
    return found


def _local(name: str) -> str:
    return name.rpartition("}")[2]
