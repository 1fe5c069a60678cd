"""Links between the project's documents lead somewhere, and the map names every page."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


def documents() -> list[Path]:
    folders = (ROOT / "docs", ROOT / "examples", ROOT / "web" / "src")
    return [
        *ROOT.glob("*.md"),
        ROOT / "web" / "README.md",
        *(path for folder in folders for path in folder.rglob("*.md")),
    ]


def anchors(document: Path) -> set[str]:
    """Anchors of the headings as repository hosts make them."""
    headings = HEADING.findall(document.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_links(document: Path) -> list[str]:
    broken = []
    for link in LINK.findall(document.read_text(encoding="utf-8")):
        if re.match(r"[a-z]+:", link):
            continue
        target, _, anchor = link.partition("#")
        path = (document.parent / target).resolve() if target else document
        if not path.exists() or (anchor and path.suffix == ".md" and anchor not in anchors(path)):
            broken.append(f"{document.relative_to(ROOT)}: {link}")
    return broken


def test_every_link_between_documents_leads_somewhere() -> None:
    assert [link for document in documents() for link in broken_links(document)] == []


def test_the_map_names_every_page() -> None:
    text = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    pages = {path.name for path in (ROOT / "docs").glob("*.md")} - {"README.md"}
    assert {page for page in pages if f"({page})" not in text} == set()


def test_a_dead_link_and_a_dead_anchor_are_seen(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("tests.unit.test_documents.ROOT", tmp_path)
    page = tmp_path / "page.md"
    page.write_text("# One heading\n[a](other.md) [b](#none) [c](#one-heading) [d](https://example.org/x)\n")
    assert broken_links(page) == ["page.md: other.md", "page.md: #none"]
