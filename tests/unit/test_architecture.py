"""Dependencies point inward: what each package may import, and what only named modules may touch."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE_FOLDERS = {"aos_gcs": ROOT, "aos_drivers": ROOT / "drivers", "aos_sim": ROOT / "sim"}

FOUNDATION = {"aos_gcs.errors", "aos_gcs.extras", "aos_gcs.geometry", "aos_gcs.radiometry"}
CONTRACT = FOUNDATION | {"aos_gcs.ports"}
MISSION = CONTRACT | {
    "aos_gcs.airspace",
    "aos_gcs.imaging",
    "aos_gcs.planning",
    "aos_gcs.swarm",
    "aos_gcs.tracking",
}
MAY_IMPORT = {
    "aos_gcs.errors": set(),
    "aos_gcs.extras": {"aos_gcs.errors"},
    "aos_gcs.cluster": FOUNDATION,
    "aos_gcs.clock": set(),
    "aos_gcs.radiometry": set(),
    "aos_gcs.geometry": {"aos_gcs.errors"},
    "aos_gcs.geotags": FOUNDATION,
    "aos_gcs.ports": FOUNDATION,
    "aos_gcs.imaging": CONTRACT,
    "aos_gcs.optimisers": {"aos_gcs.errors"},
    "aos_gcs.swarm": CONTRACT | {"aos_gcs.optimisers"},
    "aos_gcs.tracking": {"aos_gcs.errors"},
    "aos_gcs.airspace": CONTRACT,
    "aos_gcs.planning": CONTRACT | {"aos_gcs.airspace", "aos_gcs.imaging", "aos_gcs.swarm", "aos_gcs.tracking"},
    "aos_gcs.mission": MISSION,
    "aos_gcs.store": MISSION | {"aos_gcs.mission"},
    "aos_gcs.api": MISSION | {"aos_gcs.exports", "aos_gcs.mission", "aos_gcs.store"},
    "aos_gcs.lab.scenes": CONTRACT,
    "aos_gcs.lab.worlds": CONTRACT,
    "aos_gcs.surveys": CONTRACT | {"aos_gcs.cluster", "aos_gcs.geotags", "aos_gcs.imaging"},
    "aos_gcs.exports": CONTRACT | {"aos_gcs.imaging", "aos_gcs.mission", "aos_gcs.surveys"},
    "aos_drivers": CONTRACT | {"aos_gcs.clock", "aos_gcs.geotags"},
    "aos_drivers.frames": CONTRACT | {"aos_drivers.option_table", "aos_gcs.geotags"},
    "aos_drivers.links": CONTRACT | {"aos_drivers.background"},
    "aos_drivers.vehicle": CONTRACT | {"aos_drivers.frames", "aos_drivers.links", "aos_gcs.geotags"},
    "aos_drivers.mavsdk": CONTRACT
    | {
        "aos_drivers.background",
        "aos_drivers.frames",
        "aos_drivers.links",
        "aos_drivers.options",
        "aos_drivers.vehicle",
    },
    "aos_sim": CONTRACT | {"aos_gcs.clock", "aos_gcs.lab.scenes", "aos_gcs.lab.worlds"},
}
"""Package (or module) to what it may import of the project besides itself. Who is not listed stands further out."""

INNER = {name for name in MAY_IMPORT if name.startswith("aos_gcs.")}


def modules() -> Iterator[tuple[str, Path]]:
    for package, folder in SOURCE_FOLDERS.items():
        for path in sorted((folder / package).rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in modules()}


def imports(name: str) -> set[str]:
    """Dotted names that a module imports, inside of functions too."""
    found: set[str] = set()
    for node in ast.walk(TREES[name]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name} imports relatively"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def is_within(name: str, packages: set[str]) -> bool:
    return any(name == package or name.startswith(package + ".") for package in packages)


def importers_of(packages: set[str]) -> set[str]:
    return {name for name in TREES if any(is_within(imported, packages) for imported in imports(name))}


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_dependencies_point_inward(package: str) -> None:
    allowed = MAY_IMPORT[package] | {package}
    wrong = {
        f"{name} imports {imported}"
        for name in TREES
        if is_within(name, {package})
        for imported in imports(name)
        if is_within(imported, set(SOURCE_FOLDERS)) and not is_within(imported, allowed)
    }
    assert not wrong


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_every_rule_is_about_something(package: str) -> None:
    assert any(is_within(name, {package}) for name in TREES)


def test_the_core_knows_neither_drivers_nor_simulator() -> None:
    assert {name for name in importers_of({"aos_drivers", "aos_sim"}) if is_within(name, {"aos_gcs"})} == set()


def test_drivers_and_simulator_do_not_know_each_other() -> None:
    assert not any(is_within(name, {"aos_sim"}) for name in importers_of({"aos_drivers"}))
    assert not any(is_within(name, {"aos_drivers"}) for name in importers_of({"aos_sim"}))


def test_pydantic_stays_at_the_door() -> None:
    outside = {name for name in importers_of({"pydantic"}) if not is_within(name, {"aos_gcs.api", "aos_gcs.config"})}
    assert outside == set()


def test_web_frameworks_stay_in_the_api() -> None:
    frameworks = {"fastapi", "starlette", "uvicorn"}
    assert {name for name in importers_of(frameworks) if not is_within(name, {"aos_gcs.api"})} == set()


def test_mavlink_is_spoken_by_drivers_and_simulator_only_and_never_through_mavutil() -> None:
    assert importers_of({"pymavlink.mavutil"}) == set()
    assert {name for name in importers_of({"pymavlink", "mavsdk"}) if is_within(name, {"aos_gcs"})} == set()


READINGS_OF_TIME = {"time.time", "time.time_ns", "time.monotonic", "time.sleep", "datetime.now", "datetime.utcnow"}


@pytest.mark.parametrize("name", sorted(name for name in TREES if is_within(name, INNER - {"aos_gcs.clock"})))
def test_the_core_takes_time_and_chance_as_arguments(name: str) -> None:
    readings = {ast.unparse(node) for node in ast.walk(TREES[name]) if isinstance(node, ast.Attribute)}
    assert not {reading for reading in readings if reading.endswith(tuple(READINGS_OF_TIME))}
    assert not {found for found in imports(name) if is_within(found, {"random"})}
