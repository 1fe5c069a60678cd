"""Typeface and styles of a hand-over, readable in black and white."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import reportlab
from reportlab.lib import colors
from reportlab.lib.pagesizes import A4, letter
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFError, TTFont
from reportlab.platypus import Flowable, Paragraph, Table, TableStyle

from aos_gcs.handover.model import Paper
from aos_gcs.handover.texts import markup

MARGIN: Final = 15 * mm
HEAD: Final = 9 * mm
"""Height of the line above and below the content."""
FONT: Final = "Handover"
BOLD: Final = "Handover-Bold"
SIZES: Final[dict[Paper, tuple[float, float]]] = {Paper.A4: A4, Paper.LETTER: letter}
LINE: Final = colors.black
SHADE: Final = colors.Color(0.9, 0.9, 0.9)

_FOLDERS: Final = (
    "/usr/share/fonts/truetype/dejavu",
    "/usr/share/fonts/dejavu-sans-fonts",
    "/usr/share/fonts/TTF",
    "/usr/local/share/fonts/dejavu",
    "/opt/homebrew/share/fonts",
    "/System/Library/Fonts/Supplemental",
    str(Path(reportlab.__file__).parent / "fonts"),
)
_PAIRS: Final = (("DejaVuSans.ttf", "DejaVuSans-Bold.ttf"), ("Arial.ttf", "Arial Bold.ttf"), ("Vera.ttf", "VeraBd.ttf"))
"""Regular and bold typefaces, the one with the most letters first. Vera comes with the library: Western Europe's."""


@dataclass(frozen=True, slots=True)
class Styles:
    """Styles of paragraphs."""

    title: ParagraphStyle
    heading: ParagraphStyle
    text: ParagraphStyle
    small: ParagraphStyle
    label: ParagraphStyle
    bold: ParagraphStyle


@cache
def register_fonts() -> frozenset[int]:
    """Make the best typeface of this machine known to the library, and return the characters that it has."""
    for regular, bold in _PAIRS:
        for folder in map(Path, _FOLDERS):
            if (folder / regular).is_file() and (folder / bold).is_file():
                try:
                    face, heavy = TTFont(FONT, str(folder / regular)), TTFont(BOLD, str(folder / bold))
                except TTFError:
                    continue
                pdfmetrics.registerFont(face)
                pdfmetrics.registerFont(heavy)
                pdfmetrics.registerFontFamily(FONT, normal=FONT, bold=BOLD, italic=FONT, boldItalic=BOLD)
                return frozenset(face.face.charToGlyph) & frozenset(heavy.face.charToGlyph)
    raise AssertionError("the library's own typeface is part of it")


@cache
def styles() -> Styles:
    """Return the styles."""
    register_fonts()
    text = ParagraphStyle("text", fontName=FONT, fontSize=8.5, leading=11, splitLongWords=1)
    return Styles(
        title=ParagraphStyle("title", text, fontName=BOLD, fontSize=16, leading=20, spaceAfter=2 * mm),
        heading=ParagraphStyle(
            "heading", text, fontName=BOLD, fontSize=11, leading=14, spaceBefore=4 * mm, spaceAfter=1.5 * mm
        ),
        text=text,
        small=ParagraphStyle("small", text, fontSize=7, leading=9, spaceBefore=1 * mm),
        label=ParagraphStyle("label", text, fontSize=6.5, leading=8),
        bold=ParagraphStyle("bold", text, fontName=BOLD),
    )


def paragraph(text: str, style: ParagraphStyle | None = None, most: int = 2000) -> Paragraph:
    """Return a paragraph that shows a text as it is, shortened; characters that the typeface lacks become ``?``."""
    known = register_fonts()
    shown = "".join(one if ord(one) in known else "?" for one in markup(text, most))
    return Paragraph(shown, style or styles().text)


def box(number: int | None, title: str, *content: Flowable | str) -> list[Flowable]:
    """Return a box of a form: its small title with the number, and what is in it."""
    label = title if number is None else f"{number}. {title}"
    return [
        paragraph(label, styles().label),
        *(paragraph(one) if isinstance(one, str) else one for one in content),
    ]


def boxes(rows: Sequence[Sequence[Any]], widths: Sequence[float]) -> Table:
    """Return the boxes of a form, one cell each."""
    table = Table([list(row) for row in rows], colWidths=list(widths), splitInRow=1)
    table.setStyle(
        TableStyle(
            [
                ("GRID", (0, 0), (-1, -1), 0.7, LINE),
                ("VALIGN", (0, 0), (-1, -1), "TOP"),
                ("LEFTPADDING", (0, 0), (-1, -1), 4),
                ("RIGHTPADDING", (0, 0), (-1, -1), 4),
                ("TOPPADDING", (0, 0), (-1, -1), 2),
                ("BOTTOMPADDING", (0, 0), (-1, -1), 4),
            ]
        )
    )
    return table


def listing(columns: Sequence[str], rows: Sequence[Sequence[str]], widths: Sequence[float]) -> Table:
    """Return a table with a head that is repeated on each page."""
    head = [paragraph(column, styles().label) for column in columns]
    table = Table(
        [head, *([paragraph(cell, styles().small, 600) for cell in row] for row in rows)],
        colWidths=list(widths),
        repeatRows=1,
        splitInRow=1,
    )
    table.setStyle(
        TableStyle(
            [
                ("GRID", (0, 0), (-1, -1), 0.3, LINE),
                ("BACKGROUND", (0, 0), (-1, 0), SHADE),
                ("VALIGN", (0, 0), (-1, -1), "TOP"),
                ("LEFTPADDING", (0, 0), (-1, -1), 3),
                ("RIGHTPADDING", (0, 0), (-1, -1), 3),
                ("TOPPADDING", (0, 0), (-1, -1), 1.5),
                ("BOTTOMPADDING", (0, 0), (-1, -1), 2.5),
            ]
        )
    )
    return table
