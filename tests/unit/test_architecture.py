"""Rules of the architecture: the table of imports in ARCHITECTURE.md, and what source files may contain."""

import ast
import gc
import re
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE_FOLDERS = {"aos_gcs": ROOT, "aos_drivers": ROOT / "drivers", "aos_sim": ROOT / "sim"}
FOR_ALL = {"aos_gcs.errors", "aos_gcs.extras", "aos_gcs.input_values"}
"""Modules that every row of the table may import without naming them."""

MAX_LINES = 399

BAD_BEGINNING = re.compile(
    r"(Of|That|Whose|Who|How|Where|When|Which|As|At|By|In|To|From|On|With|Within|For|About|Above|Below|Over|Around|"
    r"Those|Its|Their|They|It)\b"
)


def source_files() -> Iterator[tuple[str, Path]]:
    for package, folder in SOURCE_FOLDERS.items():
        for path in sorted((folder / package).rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


PATHS = dict(source_files())


@cache
def trees() -> dict[str, ast.Module]:
    """Syntax trees of all modules. Parsed by the first test, not while tests are collected, which each process does."""
    return {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in PATHS.items()}


@cache
def all_nodes() -> dict[str, list[ast.AST]]:
    """Nodes of the syntax trees of all modules."""
    return {name: list(ast.walk(tree)) for name, tree in trees().items()}


@pytest.fixture(scope="module", autouse=True)
def _forgotten_trees() -> Iterator[None]:
    """Forget half a million nodes after the last test, and keep the garbage collector from looking through them."""
    gc.disable()
    yield
    trees.cache_clear()
    all_nodes.cache_clear()
    gc.enable()


def imports(nodes: Iterable[ast.AST]) -> set[str]:
    """Dotted names that a module imports, inside of functions too."""
    found: set[str] = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"relative import of {node.module}"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


@cache
def all_imports() -> dict[str, set[str]]:
    """Dotted names that each module imports."""
    return {name: imports(nodes) for name, nodes in all_nodes().items()}


def is_within(name: str, packages: set[str]) -> bool:
    return any(name == package or name.startswith(package + ".") for package in packages)


def importers_of(packages: set[str]) -> set[str]:
    return {name for name, imported in all_imports().items() if any(is_within(one, packages) for one in imported)}


# --- the table ------------------------------------------------------------------------------------------------------


def read_table(heading: str, package: str = "aos_gcs") -> dict[str, set[str]]:
    """Package or module to the names that its row allows, in the order of the rows."""
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    section = re.split(r"\n##+ ", text.partition(f"\n{heading}\n")[2])[0]
    rules: dict[str, set[str]] = {}
    for line in section.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("| [") or cells[0].startswith("[`web`]"):
            continue
        allowed = {full_name(name, package) for name in cells[2].split(", ") if name != "nothing"}
        for name in re.findall(r"\[`([\w.]+)`\]\(", cells[0]):
            rules[full_name(name, package)] = allowed
    return rules


def full_name(name: str, package: str) -> str:
    return name if name.partition(".")[0] in SOURCE_FOLDERS else f"{package}.{name}"


RULES = read_table("## The packages")
MISSION = read_table("### Within mission", "aos_gcs.mission")
SEARCH = read_table("### Within search", "aos_gcs.mission.search")


def row_of(name: str) -> str:
    """Return the most specific row that a module belongs to; empty if there is none."""
    return max((row for row in RULES if is_within(name, {row})), key=len, default="")


ROWS = {name: row_of(name) for name in PATHS if name != "aos_gcs"}


def test_the_table_covers_every_module_and_nothing_else() -> None:
    assert {name for name, row in ROWS.items() if not row} == set()
    assert set(RULES) - set(ROWS.values()) == set()


def test_modules_import_what_the_table_allows() -> None:
    wrong = [
        f"{name} imports {imported}"
        for name, row in ROWS.items()
        for imported in sorted(all_imports()[name])
        if is_within(imported, set(SOURCE_FOLDERS))
        and not is_within(imported, RULES.get(row, set()) | FOR_ALL | {row or name})
    ]
    assert wrong == []


def test_rows_allow_only_rows_above_them() -> None:
    order = list(RULES)
    wrong = [
        f"{row} may import {name}, which is not above it"
        for position, row in enumerate(order)
        for name in sorted(RULES[row] - set(order[:position]))
    ]
    assert wrong == [], "an import cycle between packages becomes possible"


@pytest.mark.parametrize(
    ("package", "rules"), [("aos_gcs.mission", MISSION), ("aos_gcs.mission.search", SEARCH)], ids=["mission", "search"]
)
def test_parts_of_a_mission_import_what_their_table_allows(package: str, rules: dict[str, set[str]]) -> None:
    wrong = [
        f"{name} imports {imported}"
        for row, allowed in rules.items()
        for name in sorted(PATHS)
        if is_within(name, {row})
        for imported in sorted(all_imports()[name])
        if is_within(imported, {package}) and not is_within(imported, allowed | {row})
    ]
    assert wrong == []
    assert len(rules) > 8, "the table is read"
    assert {row for row in rules if row not in PATHS} == set(), "each row is a module or a folder"


def test_each_part_of_the_search_is_in_its_table_and_imports_only_those_above_it() -> None:
    package = "aos_gcs.mission.search"
    parts = {".".join(name.split(".")[:4]) for name in PATHS if name.startswith(package + ".")}
    assert parts - set(SEARCH) == {f"{package}.search"}
    order = list(SEARCH)
    assert [row for position, row in enumerate(order) if SEARCH[row] - set(order[:position])] == []


def test_what_puts_a_mission_together_is_known_to_none_of_its_parts_nor_is_the_search() -> None:
    assert set().union(*MISSION.values()) <= set(MISSION) - {"aos_gcs.mission.search"}


def test_modules_do_not_import_one_another_in_a_circle() -> None:
    graph = {
        name: {other for one in all_imports()[name] for other in (one, one.rpartition(".")[0]) if other in trees()}
        - {name}
        for name in trees()
    }
    # Importing a module is no use of the package around it.
    graph = {name: {o for o in others if not is_within(name, {o})} for name, others in graph.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"import cycle: {' -> '.join(error.args[1])}")


def test_the_core_knows_neither_drivers_nor_simulator() -> None:
    assert {name for name in importers_of({"aos_drivers", "aos_sim"}) if is_within(name, {"aos_gcs"})} == set()


def test_drivers_and_simulator_do_not_know_each_other() -> None:
    assert not any(is_within(name, {"aos_sim"}) for name in importers_of({"aos_drivers"}))
    assert not any(is_within(name, {"aos_drivers"}) for name in importers_of({"aos_sim"}))


# --- libraries ------------------------------------------------------------------------------------------------------


def test_pydantic_is_used_where_data_come_in_only() -> None:
    edges = {"aos_gcs.api", "aos_gcs.bridge", "aos_gcs.config"}
    outside = {name for name in importers_of({"pydantic"}) if not is_within(name, edges)}
    assert outside == set()


def test_web_frameworks_are_used_by_the_api_only() -> None:
    frameworks = {"fastapi", "starlette", "uvicorn"}
    assert {name for name in importers_of(frameworks) if not is_within(name, {"aos_gcs.api"})} == set()


def test_nothing_that_flies_or_is_tested_waits_for_slow_libraries() -> None:
    """Each takes a second to import, in every process that is started: only what needs it imports it."""
    slow = {"scipy.signal", "scipy.stats", "matplotlib", "pyarrow", "dask", "distributed"}
    loading = {
        name
        for name, tree in trees().items()
        for node in tree.body
        if isinstance(node, (ast.Import, ast.ImportFrom)) and any(is_within(one, slow) for one in imports([node]))
    }
    assert loading <= {name for name in PATHS if is_within(name, {"aos_gcs.lab"})}


def test_mavlink_is_spoken_by_drivers_and_simulator_only_and_never_through_mavutil() -> None:
    assert importers_of({"pymavlink.mavutil"}) == set()
    assert {name for name in importers_of({"pymavlink", "mavsdk"}) if is_within(name, {"aos_gcs"})} == set()


# --- time and chance ------------------------------------------------------------------------------------------------

SOURCES = re.compile(
    r"time\.\w+|datetime\.(datetime|date)\.(now|utcnow|today)"
    r"|(random|secrets)\.\w+|uuid\.uuid[14]|os\.(urandom|getrandom)|numpy\.random\.[a-z]\w*"
)
SEEDED = {"numpy.random.default_rng", "numpy.random.PCG64", "numpy.random.SeedSequence", "numpy.random.RandomState"}
ALLOWED = {
    "aos_gcs.api.access": {"secrets.compare_digest", "secrets.token_urlsafe"},
    "aos_gcs.cli.output": {"time.monotonic"},
    "aos_gcs.cli.report": {"datetime.datetime.now"},
    "aos_gcs.clock": {"time.time"},
    "aos_gcs.mission.search.frames.intake": {"time.perf_counter"},
    "aos_gcs.mission.search.step_work": {"time.perf_counter"},
    "aos_gcs.runtime.simulated.mission_study": {"time.process_time"},
    "aos_gcs.runtime.service": {"datetime.datetime.now"},
    "aos_gcs.runtime.wall.video_maker": {"time.process_time", "time.sleep"},
    "aos_gcs.workers.lifeline": {"time.sleep"},
    "aos_sim.attached.service": {"time.monotonic", "time.time_ns"},
    "aos_sim.swarm": {"time.time_ns"},
}
"""Sources that modules or packages may use: for clocks, secret codes, durations of our own work, and pauses between
tries of what the kernel may refuse, or in which others may work."""


def time_and_chance(nodes: list[ast.AST]) -> set[str]:
    """Return the sources of time and chance that a module uses, as full names."""
    full = {}
    for node in nodes:
        if isinstance(node, ast.Import):
            full |= {alias.asname: alias.name for alias in node.names if alias.asname}
            full |= {first: first for alias in node.names if not alias.asname for first in [alias.name.split(".")[0]]}
        elif isinstance(node, ast.ImportFrom):
            full |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
    found = set()
    for node in nodes:
        if isinstance(node, ast.Attribute | ast.Name):
            name = resolved(node, full)
            if SOURCES.fullmatch(name) and name not in SEEDED:
                found.add(name)
        elif isinstance(node, ast.Call) and is_unseeded(node) and resolved(node.func, full) in SEEDED:
            found.add(f"{resolved(node.func, full)}()")
    return found


def is_unseeded(call: ast.Call) -> bool:
    """Whether a generator is made without a seed, or with None for one."""
    values = [*call.args, *(keyword.value for keyword in call.keywords)]
    return all(isinstance(value, ast.Constant) and value.value is None for value in values)


def resolved(node: ast.expr, full: dict[str, str]) -> str:
    """Return the full name of ``a`` or ``a.b.c`` whose first part was imported; else nothing."""
    parts = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return ".".join([full[node.id], *reversed(parts)]) if isinstance(node, ast.Name) and node.id in full else ""


def test_time_and_chance_are_arguments() -> None:
    wrong = {
        name: sorted(unexpected)
        for name, nodes in all_nodes().items()
        if (
            unexpected := time_and_chance(nodes).difference(
                *(allowed for key, allowed in ALLOWED.items() if is_within(name, {key}))
            )
        )
    }
    assert wrong == {}


def test_sources_of_time_and_chance_are_recognised() -> None:
    text = """
import random, time, numpy as np
from datetime import datetime
from numpy.random import default_rng
from time import monotonic
rng = np.random.default_rng()
other = default_rng(None)
third = np.random.SeedSequence(entropy=None)
np.random.normal()
random.random()
datetime.now()
time.sleep(1)
monotonic()
np.random.default_rng(7)
"""
    assert time_and_chance(list(ast.walk(ast.parse(text)))) == {
        "numpy.random.default_rng()",
        "numpy.random.SeedSequence()",
        "numpy.random.normal",
        "random.random",
        "datetime.datetime.now",
        "time.sleep",
        "time.monotonic",
    }


# --- files and words ------------------------------------------------------------------------------------------------


def test_files_are_short() -> None:
    page = [path for ending in ("ts", "tsx", "css") for path in (ROOT / "web" / "src").rglob(f"*.{ending}")]
    paths = [*PATHS.values(), *(ROOT / "tests").rglob("*.py"), *page]
    lengths = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8").count("\n") for path in paths}
    del lengths["web/src/api/schema.ts"]  # generated
    too_long = {path: lines for path, lines in lengths.items() if lines > MAX_LINES}
    assert too_long == {}, f"split files of more than {MAX_LINES} lines by purpose"


def test_a_public_class_name_of_the_core_stands_for_one_thing() -> None:
    """The same name on both sides of a protocol, in the core and in drivers or simulator, is not ambiguous."""
    modules: dict[str, set[str]] = {}
    for module, tree in trees().items():
        for node in tree.body:
            if is_within(module, {"aos_gcs"}) and isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                modules.setdefault(node.name, set()).add(module)
    ambiguous = {name: known for name, known in modules.items() if len(known) > 1}
    assert ambiguous == {}, "one name, one thing: rename the class that fewer modules import, or merge the two"


def docstrings(nodes: Iterable[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield line and text of the docstrings of modules, classes, functions and attributes."""
    for node in nodes:
        for statement in getattr(node, "body", []) if not isinstance(node, ast.IfExp | ast.Lambda) else []:
            match statement:
                case ast.Expr(value=ast.Constant(value=str(text))):
                    yield statement.lineno, text


def test_docstrings_begin_with_a_noun_or_verb() -> None:
    wrong = [
        f"{PATHS[name].relative_to(ROOT)}:{line}: {text.splitlines()[0]}"
        for name, nodes in all_nodes().items()
        for line, text in docstrings(nodes)
        if BAD_BEGINNING.match(text)
    ]
    wrong += [
        f"{path.relative_to(ROOT)}:{line}: {text.splitlines()[0]}"
        for path in sorted((ROOT / "tests").rglob("*.py"))
        for line, text in docstrings(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        if BAD_BEGINNING.match(text)
    ]
    assert wrong == []


def test_modules_say_what_they_are_for() -> None:
    assert {name for name, tree in trees().items() if not ast.get_docstring(tree)} == set()
