"""The XMP packet of a photograph as a flat table.

Manufacturers use namespaces of their own for the same names, so that a name is looked up without its namespace.
Photographs come from outside: XML is parsed by defusedxml.
"""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element, ParseError

from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra

_RDF = "{http://www.w3.org/1999/02/22-rdf-syntax-ns#}"


def parse_xmp(packet: bytes) -> dict[str, str]:
    """Return the properties of an XMP packet by local name; members of structures as ``structure/member``.

    Where a name stands more than once, the first one counts.

    Raises:
        InputDataError: if the packet is no well-formed XML, or tries what XML of a photograph has no need of.
    """
    defusedxml: Any = load_extra("defusedxml.ElementTree", "geo", "Reading the position of a photograph")
    try:
        # Packets are padded with spaces, some with zeros.
        root: Element = defusedxml.fromstring(packet.strip(b"\0 \r\n\t"))
    except (ParseError, ValueError) as error:
        # What defusedxml forbids derives from ValueError.
        raise InputDataError(f"its XMP is not valid XML: {error}") from error
    table: dict[str, str] = {}
    try:
        for description in root.iter(f"{_RDF}Description"):
            for name, value in _properties(description):
                table.setdefault(name, value)
    except RecursionError as error:
        raise InputDataError("its XMP is nested too deeply") from error
    return table


def _properties(element: Element) -> list[tuple[str, str]]:
    found = [(_local(name), value.strip()) for name, value in element.attrib.items() if not name.startswith(_RDF)]
    for child in element:
        name = _local(child.tag)
        inner = [(f"{name}/{member}", value) for member, value in _properties(child)]
        found += inner or [(name, (child.text or "").strip())]
    return found


def _local(name: str) -> str:
    return name.rpartition("}")[2]
