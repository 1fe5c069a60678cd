"""Translations of what the station says, against its sources: a text that has changed has lost its translation."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.unit.station_texts import FILLED_IN, said_texts

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = sorted(path.parent for path in (ROOT / "web" / "src" / "texts").glob("*/station"))
"""Folders of languages other than that of the sources."""
PACKAGES = ("mission", "planning", "airspace", "api", "store", "runtime", "workers", "imaging/persons", "examination")
PACKAGES += ("sharing", "swarm")
"""Packages of ``aos_gcs`` that speak to operators, beside the drivers."""
PAIR = re.compile(r'\[\s*("(?:[^"\\]|\\.)*"),\s*"(?:[^"\\]|\\.)*",?\s*\]')
PLACEHOLDER = re.compile(r"\{\w+\}")
SEAM = re.compile(r'"\s*\n\s*f?"')
WORD = re.compile(r"[A-Za-z]{3}")
SETTING = re.compile(r"[a-z]+(_[a-z0-9]+)+")
SHORTEST_PART = 4


def templates(language: Path) -> list[str]:
    """English texts for which a language has translations."""
    parts = [path.read_text(encoding="utf-8") for path in sorted((language / "station").glob("*.ts"))]
    return [json.loads(english) for part in parts for english in PAIR.findall(part)]


def pattern_of(text: str) -> str:
    """Regular expression of a text with placeholders, each of them a group."""
    return "(.*?)".join(map(re.escape, PLACEHOLDER.split(text)))


def fixed_parts(text: str) -> list[str]:
    """Parts of a text between what is filled in, without what may join one text to another."""
    parts = [part.strip(" :;,.()%") for between in PLACEHOLDER.split(text) for part in between.split(": ")]
    return [part for part in parts if len(part) >= SHORTEST_PART]


@pytest.fixture(scope="module")
def told() -> dict[str, set[str]]:
    """Return what the station says to operators, by source."""
    return said_texts(ROOT)


@pytest.fixture(scope="module")
def sources() -> list[str]:
    """Sources of the packages, with strings that stand one below the other joined as Python joins them."""
    folders = [*(ROOT / "aos_gcs" / package for package in PACKAGES), ROOT / "drivers" / "aos_drivers"]
    paths = [path for folder in folders for path in folder.rglob("*.py")]
    return [SEAM.sub("", path.read_text(encoding="utf-8")) for path in paths]


class Translator:
    """The page's own translator (``web/src/texts/station.ts``), as far as it tells what has a translation."""

    def __init__(self, english: list[str]) -> None:
        self._fixed = {text for text in english if "{" not in text}
        patterns = [text for text in english if "{" in text]
        patterns.sort(key=lambda text: len(PLACEHOLDER.sub("", text)), reverse=True)
        self._patterns = [re.compile(pattern_of(text), re.DOTALL) for text in patterns]

    def knows(self, text: str) -> bool:
        """Whether a text is translated with all that is filled in; names of settings and what has no word stay."""
        return WORD.search(text) is None or SETTING.fullmatch(text) is not None or self._finds(text)

    def _finds(self, text: str) -> bool:
        if text in self._fixed or self._knows_parts(text):
            return True
        found = next((match for pattern in self._patterns if (match := pattern.fullmatch(text))), None)
        return found is not None and all(map(self.knows, found.groups()))

    def _knows_parts(self, text: str) -> bool:
        for separator in (". ", "; ", ", "):
            parts = text.removesuffix(".").split(separator)
            if len(parts) > 1 and all(part == FILLED_IN or self._finds(part) for part in parts):
                return True
        return False


@pytest.mark.parametrize("language", LANGUAGES, ids=lambda path: path.stem)
def test_texts_of_the_station_that_are_translated_are_said(
    language: Path, sources: list[str], told: dict[str, set[str]]
) -> None:
    said = "\n".join(sources)
    assert len(templates(language)) > 100
    built = set().union(*told.values())
    outdated = [
        text
        for text in templates(language)
        if not all(part in said for part in fixed_parts(text))
        and not any(map(re.compile(pattern_of(text), re.DOTALL).fullmatch, built))
    ]
    assert outdated == [], f"the station no longer says this: correct it in {language.name}"


@pytest.mark.parametrize("language", LANGUAGES, ids=lambda path: path.stem)
def test_what_operators_are_told_is_translated(language: Path, told: dict[str, set[str]]) -> None:
    translator = Translator(templates(language))
    assert sum(map(len, told.values())) > 900
    untranslated = {
        name: wrong
        for name, texts in told.items()
        if (wrong := sorted(one for one in texts if not translator.knows(one)))
    }
    assert untranslated == {}, f"add their translation to {language.name}"


def test_texts_are_followed_to_where_they_are_made(tmp_path: Path) -> None:
    source = tmp_path / "aos_gcs" / "api" / "speaker.py"
    source.parent.mkdir(parents=True)
    source.write_text(
        """
def why(is_late):
    cause = "late" if is_late else f"lost {3}"
    return cause

def tell(text):
    journal.notice(WARNING, f"Link: {text}")

def act(vehicle):
    remedy = " Check it" if vehicle else ""
    tell(f"{why(True)}.{remedy}")
    text = "first"
    text += " and more"
    raise MissionError(text)

class MissionError(AosError): ...
"""
    )
    told = said_texts(tmp_path)["aos_gcs/api/speaker.py"]
    links = {f"Link: {cause}.{remedy}" for cause in ("late", "lost 7") for remedy in ("", " Check it")}
    assert told == {*links, "first and more"}


def test_errors_count_where_they_reach_the_page(tmp_path: Path) -> None:
    raising = 'def read(path):\n    raise GridError(f"{path} cannot be read.")\n'
    sources = {
        "errors.py": "class InputDataError(AosError): ...\nclass GridError(InputDataError): ...\n",
        "api/plans.py": "from aos_gcs.prior import grid\n",
        "prior/grid.py": raising,
        "surveys/photos.py": raising,  # no station imports it
        "api/tls.py": raising.replace("GridError", "InputDataError"),  # read before there is a page
        "api/listener.py": raising.replace("GridError", "LinkError"),  # no error of ours
    }
    for name, text in sources.items():
        source = tmp_path / "aos_gcs" / name
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_text(text)
    assert said_texts(tmp_path) == {"aos_gcs/prior/grid.py": {"7 cannot be read."}}
