"""Sources of a running station, and the errors of ours that they raise, as the sources themselves say."""

from __future__ import annotations

import ast
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Final

_STATION: Final = (
    *(
        "aos_gcs/api/",
        "aos_gcs/runtime/service.py",
        "aos_gcs/runtime/dashboard/process.py",
        "aos_gcs/runtime/survey.py",
    ),
    *("aos_gcs/runtime/processes/sharing_process.py", "aos_gcs/examination/", "aos_gcs/swarm/", "drivers/aos_drivers/"),
)
"""Sources with which a station starts, and those that it loads by name."""
_ERROR: Final = "AosError"
_INPUT_ERRORS: Final = frozenset({"ConfigurationError", "ImagingError", "InputDataError", "ParameterError"})
"""Errors of files and values, which stations have in common with commands that only read them and end."""
_READ_BEFORE: Final = (
    *("aos_gcs/api/basemap_file.py", "aos_gcs/api/tls.py", "aos_gcs/cameras/", "aos_gcs/config/", "aos_gcs/surveys/"),
    *("aos_gcs/exports/files.py", "aos_gcs/imaging/persons/classifier.py", "aos_gcs/imaging/step/settings.py"),
    *("aos_gcs/imaging/surfaces/dem_files.py", "aos_gcs/runtime/drivers.py", "aos_gcs/runtime/service.py"),
    *("aos_gcs/runtime/sign_in.py", "aos_gcs/runtime/survey.py", "aos_gcs/store/audit.py"),
    *("aos_gcs/sharing/caltopo/requests.py", "aos_gcs/sharing/http.py", "aos_gcs/sharing/secrets.py"),
    *("aos_gcs/sharing/service.py", "aos_gcs/sharing/settings.py", "aos_gcs/sharing/tak/connection.py"),
    *("drivers/aos_drivers/frames/settings.py", "drivers/aos_drivers/mavlink/", "drivers/aos_drivers/mavsdk/"),
    "drivers/aos_drivers/option_table.py",
)
"""Sources whose input is read before there is a page, or by a command: their input errors end either."""

_WITH_STATEMENTS: Final = (ast.stmt, ast.excepthandler, ast.match_case)

Trees = Mapping[str, ast.Module]
"""Syntax trees by the paths of their sources."""


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements of a tree, outer ones first, and not the far more expressions in them."""
    waiting = deque([tree])
    while waiting:
        node = waiting.popleft()
        for name in node._fields:
            inner = getattr(node, name)
            if isinstance(inner, list) and inner and isinstance(inner[0], _WITH_STATEMENTS):
                yield from inner
                waiting += inner


def of_stations(trees: Trees) -> set[str]:
    """Return the sources that a running station imports; all others speak to whoever types commands, in English."""
    by_module = {_module_of(name): name for name in trees}
    found: set[str] = set()
    waiting = [name for name in trees if name.startswith(_STATION)]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += [by_module[module] for module in _imports(trees[name]) if module in by_module]
    return found


def errors(trees: Trees) -> frozenset[str]:
    """Return the names of all errors of ours."""
    bases = {
        node.name: {base.id for base in node.bases if isinstance(base, ast.Name)}
        for tree in trees.values()
        for node in statements(tree)
        if isinstance(node, ast.ClassDef)
    }
    found = {_ERROR, *_INPUT_ERRORS}
    while more := {name for name, of in bases.items() if of & found} - found:
        found |= more
    return frozenset(found)


def reaching_the_page(name: str, errors: frozenset[str]) -> frozenset[str]:
    """Return the errors that may be shown on a page where a source raises them."""
    return errors - _INPUT_ERRORS if name.startswith(_READ_BEFORE) else errors


def _module_of(name: str) -> str:
    return name.removeprefix("drivers/").removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _imports(tree: ast.Module) -> Iterator[str]:
    for node in statements(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
