"""Translations of what the station says, against its sources: a text that has changed has lost its translation."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = sorted(path.parent for path in (ROOT / "web" / "src" / "texts").glob("*/station"))
"""Folders of languages other than that of the sources."""
PACKAGES = ("mission", "planning", "airspace", "api", "store", "runtime", "workers", "imaging/persons")
"""Packages of ``aos_gcs`` that speak to operators, beside the drivers."""
PAIR = re.compile(r'\[\s*("(?:[^"\\]|\\.)*"),\s*"(?:[^"\\]|\\.)*",?\s*\]')
PLACEHOLDER = re.compile(r"\{\w+\}")
SEAM = re.compile(r'"\s*\n\s*f?"')
SHORTEST_PART = 4
CHECK_RESULTS = {"passed", "failed", "warned"}
"""Functions that make results of preflight checks, of texts and remedies."""
OF_OTHERS_WORDS = {"7: 7", "it is 7"}
"""Texts that consist of what another part of the station says, which is translated there."""
LOUD = {"CRITICAL", "NEWS"}
"""Severities that are always announced in the operator's language."""


def templates(language: Path) -> list[str]:
    """English texts for which a language has translations."""
    parts = [path.read_text(encoding="utf-8") for path in sorted((language / "station").glob("*.ts"))]
    return [json.loads(english) for part in parts for english in PAIR.findall(part)]


def fixed_parts(text: str) -> list[str]:
    """Parts of a text between what is filled in, without what may join one text to another."""
    parts = [part.strip(" :;,.()%") for between in PLACEHOLDER.split(text) for part in between.split(": ")]
    return [part for part in parts if len(part) >= SHORTEST_PART]


@pytest.fixture(scope="module")
def sources() -> list[str]:
    """Sources of the packages, with strings that stand one below the other joined as Python joins them."""
    folders = [*(ROOT / "aos_gcs" / package for package in PACKAGES), ROOT / "drivers" / "aos_drivers"]
    paths = [path for folder in folders for path in folder.rglob("*.py")]
    return [SEAM.sub("", path.read_text(encoding="utf-8")) for path in paths]


def text_of(node: ast.expr | None) -> str | None:
    """Text of a literal, with a 7 for everything that is filled in; None for anything else."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "7" for part in node.values)
    return None


def loud_notices(tree: ast.Module) -> Iterator[str]:
    """Texts of critical notices and of news that stand in the function that reports them."""
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        named = {
            target.id: text
            for node in ast.walk(function)
            if isinstance(node, ast.Assign) and (text := text_of(node.value)) is not None
            for target in node.targets
            if isinstance(target, ast.Name)
        }
        for node in ast.walk(function):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "notice"):
                continue
            severity, words, *_ = [*node.args, None, None]
            if not (isinstance(severity, ast.Attribute) and severity.attr in LOUD):
                continue
            text = named.get(words.id) if isinstance(words, ast.Name) else text_of(words)
            if text is not None:
                yield text


def quiet_texts(tree: ast.Module) -> Iterator[str]:
    """Texts of notices of any severity, and results and remedies of preflight checks, as far as they are literals."""
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call):
            continue
        name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        if name == "notice":
            candidates = call.args[1:2]
        elif name in CHECK_RESULTS:
            candidates = [*call.args, *(keyword.value for keyword in call.keywords)]
        else:
            continue
        yield from (text for node in candidates if (text := text_of(node)) is not None and len(text) >= SHORTEST_PART)


@pytest.mark.parametrize("language", LANGUAGES, ids=lambda path: path.stem)
def test_texts_of_the_station_that_are_translated_are_said(language: Path, sources: list[str]) -> None:
    said = "\n".join(sources)
    assert len(templates(language)) > 100
    outdated = [text for text in templates(language) if not all(part in said for part in fixed_parts(text))]
    assert outdated == [], f"the station no longer says this: correct it in {language.name}"


@pytest.mark.parametrize("language", LANGUAGES, ids=lambda path: path.stem)
def test_critical_notices_and_news_are_translated(language: Path, sources: list[str]) -> None:
    patterns = [
        re.compile(".*?".join(map(re.escape, PLACEHOLDER.split(text))), re.DOTALL) for text in templates(language)
    ]
    loud = [source for source in sources if any(f"Severity.{severity}" in source for severity in LOUD)]
    texts = {text for source in loud for text in loud_notices(ast.parse(source))}
    assert len(texts) > 10
    untranslated = sorted(text for text in texts if not any(pattern.fullmatch(text) for pattern in patterns))
    assert untranslated == [], f"add their translation to {language.name}"


@pytest.mark.parametrize("language", LANGUAGES, ids=lambda path: path.stem)
def test_notices_and_results_of_checks_are_translated(language: Path, sources: list[str]) -> None:
    patterns = [
        re.compile(".*?".join(map(re.escape, PLACEHOLDER.split(text))), re.DOTALL) for text in templates(language)
    ]
    speaking = re.compile(r"\.notice\(|\b(?:passed|failed|warned)\(")
    trees = [ast.parse(source) for source in sources if speaking.search(source)]
    texts = {text for tree in trees for text in quiet_texts(tree)} - OF_OTHERS_WORDS
    assert len(texts) > 60
    untranslated = sorted(text for text in texts if not any(pattern.fullmatch(text) for pattern in patterns))
    assert untranslated == [], f"add their translation to {language.name}"
