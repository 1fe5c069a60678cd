"""Links between documents lead somewhere, the map names every page, and the names in ARCHITECTURE.md exist."""

import ast
import re
from functools import cache
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
    docs = ROOT / "docs"
    pages = {path.relative_to(docs).as_posix() for path in docs.rglob("*.md")} - {"README.md"}
    assert {page for page in pages if f"({page})" not in text} == set()


def test_a_dead_link_and_a_dead_anchor_are_seen(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("tests.unit.test_documents.ROOT", tmp_path)
    page = tmp_path / "page.md"
    page.write_text("# One heading\n[a](other.md) [b](#none) [c](#one-heading) [d](https://example.org/x)\n")
    assert broken_links(page) == ["page.md: other.md", "page.md: #none"]


# --- names in ARCHITECTURE.md ---------------------------------------------------------------------------------------

LINKED_NAMES = re.compile(r"\[((?:`[\w.]+`(?:,? and |, )?)+)\]\((\w[\w/]*(?:\.py)?)\)")
METHOD = re.compile(r"`([A-Z]\w+)\.(\w+)`")


@cache
def definitions(path: Path) -> set[str]:
    """Classes, functions and methods (``Class.method``) that a module, or the modules of a package, define."""
    found = set()
    for module in [path] if path.is_file() else path.rglob("*.py"):
        for node in ast.parse(module.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                found.add(node.name)
                found |= {
                    f"{node.name}.{own.name}"
                    for own in node.body
                    if isinstance(node, ast.ClassDef) and isinstance(own, ast.FunctionDef | ast.AsyncFunctionDef)
                }
    return found


def undefined_names(text: str) -> list[str]:
    """Names in backticks that the module beside them does not define, and methods that no class has."""
    missing = []
    for names, target in LINKED_NAMES.findall(text):
        path = ROOT / target
        for name in re.findall(r"`([\w.]+)`", names):
            is_module = name in {path.stem, *path.parts} or re.match(r"[a-z]\w*\.", name)
            if not is_module and name not in definitions(path):
                missing.append(f"{name} in {target}")
    methods = METHOD.findall(text)
    owners = re.compile(rf"^class ({'|'.join(owner for owner, _ in methods)})\b", re.MULTILINE)
    modules = [path for folder in ("aos_gcs", "drivers") for path in (ROOT / folder).rglob("*.py")]
    found = set().union(*(definitions(path) for path in modules if owners.search(path.read_text(encoding="utf-8"))))
    return missing + [f"{owner}.{name}" for owner, name in methods if f"{owner}.{name}" not in found]


def test_the_names_in_the_description_of_the_architecture_exist() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    assert len(LINKED_NAMES.findall(text)) > 40
    assert len(METHOD.findall(text)) > 8
    assert undefined_names(text) == []


def test_names_that_do_not_exist_are_seen() -> None:
    text = "[`Launch.arm`](aos_gcs/mission/launch.py) [`Launch.fly`](aos_gcs/mission/launch.py) `Roster.forget`"
    assert undefined_names(text) == ["Launch.fly in aos_gcs/mission/launch.py", "Launch.fly", "Roster.forget"]
