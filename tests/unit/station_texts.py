"""What the station says to operators, found in its sources: notices, checks, problems of plans, and refusals.

Texts are often built in variables, by conditions and by functions of the same module: all that these may become is
followed, as far as it stands in the sources. A 7 stands for whatever else is filled in.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, product
from pathlib import Path
from typing import Final

from tests.unit import station_sources

PACKAGES: Final = ("aos_gcs", "drivers/aos_drivers")
_SPEAKING: Final = {
    **dict.fromkeys(("notice", "Notice"), ((1, "\0"),)),
    "Refusal": ((0, "\0"),),
    "operator_notice": ((1, "7: \0"),),
    "PlanProblem": ((1, "\0"),),
    "_all_members": ((0, "\0"),),
    "_result": ((2, "\0"),),
}
"""Position of the text among the arguments, and what is said of it, by what is called; errors come beside these."""
_RESULTS: Final = {"passed", "failed", "warned"}
"""Functions that make results of preflight checks, of texts and remedies."""
_TEXT_PARAMETERS: Final = {"text", "reason", "problem", "message", "what"}
_MOST_VARIANTS: Final = 64
_DEPTH: Final = 8
FILLED_IN: Final = "7"
"""Text that stands for what is not known."""

Environment = dict[str, list[ast.expr]]
"""Expressions that each variable may have been given."""
Function = ast.FunctionDef | ast.AsyncFunctionDef
Speaking = dict[str, tuple[tuple[int, str], ...]]


def said_texts(root: Path) -> dict[str, set[str]]:
    """Return the texts of all sources of stations below a folder, by the path of the source."""
    paths = sorted(path for package in PACKAGES for path in (root / package).rglob("*.py"))
    trees = {path.relative_to(root).as_posix(): ast.parse(path.read_text(encoding="utf-8")) for path in paths}
    errors = station_sources.errors(trees)
    found = {
        name: set(_Module(trees[name], station_sources.reaching_the_page(name, errors)).texts())
        for name in sorted(station_sources.of_stations(trees))
    }
    return {name: texts for name, texts in found.items() if texts}


def _called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def _steps(body: Sequence[ast.stmt], known: Environment) -> Iterator[tuple[ast.AST, Environment]]:
    """Yield statements and conditions, in each case with what the variables may be there; ``known`` follows."""
    for statement in body:
        yield from _step(statement, known)
        if isinstance(statement, ast.Return | ast.Raise | ast.Continue | ast.Break):
            known.clear()
            known[_ENDED] = []
            return


_ENDED: Final = "return"
"""No variable has this name: it marks a branch that does not go on."""


def _step(statement: ast.stmt, known: Environment) -> Iterator[tuple[ast.AST, Environment]]:
    branches = [getattr(statement, name) for name in ("body", "orelse", "finalbody") if hasattr(statement, name)]
    branches += [handler.body for handler in getattr(statement, "handlers", [])]
    branches += [case.body for case in getattr(statement, "cases", [])]
    if isinstance(statement, Function | ast.ClassDef):
        return
    if not branches:
        _assign(statement, known)
        yield statement, known
        return
    for name in ("test", "iter", "subject"):
        if isinstance(condition := getattr(statement, name, None), ast.expr):
            yield condition, known
    if not isinstance(statement, ast.If | ast.With | ast.AsyncWith):
        branches.append([])
    after: Environment = {}
    for branch in branches:
        inside = dict(known)
        yield from _steps(branch, inside)
        if _ENDED not in inside:
            for name, values in inside.items():
                after[name] = list(dict.fromkeys([*after.get(name, []), *values]))
    known.clear()
    known.update(after)


def _assign(statement: ast.stmt, known: Environment) -> None:
    match statement:
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            known[name] = [_fixed(value, known)]
        case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
            for target, value in zip(names, values, strict=True):
                if isinstance(target, ast.Name):
                    known[target.id] = [value]
        case ast.AugAssign(target=ast.Name(id=name), value=value):
            known[name] = [ast.BinOp(before, ast.Add(), value) for before in known.get(name, [])]


def _fixed(value: ast.expr, known: Mapping[str, list[ast.expr]]) -> ast.expr:
    """Return a variable that is given to another one as what it is now."""
    values = known.get(value.id, []) if isinstance(value, ast.Name) else []
    return values[0] if len(values) == 1 else value


class _Module:
    def __init__(self, tree: ast.Module, errors: frozenset[str]) -> None:
        functions = [node for node in station_sources.statements(tree) if isinstance(node, Function)]
        self._functions = {function.name: function for function in functions}
        self._speaking: Speaking = _SPEAKING | dict.fromkeys(errors, ((0, "\0"),))
        for function in functions:
            if function.name not in self._speaking and (said := tuple(self._learned(function))):
                self._speaking[function.name] = said

    def _learned(self, function: Function) -> Iterator[tuple[int, str]]:
        """Yield what a function of this module says of the texts that it is given."""
        parameters = [one.arg for one in function.args.args if one.arg not in ("self", "cls")]
        for position, parameter in enumerate(parameters):
            if parameter in _TEXT_PARAMETERS:
                said = self._said_in(function, {parameter: [ast.Constant("\0")]})
                yield from ((position, text) for text in said if "\0" in text)

    def texts(self) -> Iterator[str]:
        """Yield all texts."""
        for function in self._functions.values():
            parameters = {one.arg: [ast.Constant("\0")] for one in function.args.args if one.arg in _TEXT_PARAMETERS}
            yield from (text for text in self._said_in(function, parameters) if "\0" not in text)

    def _said_in(self, function: Function, known: Environment) -> Iterator[str]:
        for node, inside in _steps(function.body, dict(known)):
            for call in (one for one in ast.walk(node) if isinstance(one, ast.Call)):
                yield from self._said_by(call, inside)

    def _said_by(self, call: ast.Call, known: Environment) -> Iterator[str]:
        name = _called(call)
        if name in _RESULTS:
            for argument in (*call.args, *(keyword.value for keyword in call.keywords)):
                yield from self._variants(argument, known, _DEPTH)
        for position, frame in self._speaking.get(name, ()):
            for argument in call.args[position : position + 1]:
                yield from (frame.replace("\0", text) for text in self._variants(argument, known, _DEPTH))

    def _variants(self, node: ast.expr | None, known: Environment, depth: int) -> list[str]:
        """Return what an expression may become."""
        found = self._found(node, known, depth - 1) if node is not None and depth > 0 else []
        return list(islice(dict.fromkeys(found), _MOST_VARIANTS)) or [FILLED_IN]

    def _found(self, node: ast.expr, known: Environment, depth: int) -> Iterator[str]:
        match node:
            case ast.Constant(value=str(text)):
                yield text
            case ast.JoinedStr(values=values):
                parts = [self._variants(value, known, depth + 1) for value in values]
                yield from map("".join, islice(product(*parts), _MOST_VARIANTS))
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                parts = [self._variants(side, known, depth + 1) for side in (left, right)]
                yield from map("".join, product(*parts))
            case ast.FormattedValue(value=value):
                yield from self._variants(value, known, depth)
            case ast.IfExp(body=body, orelse=orelse):
                yield from self._several((body, orelse), known, depth)
            case ast.BoolOp(op=ast.Or(), values=values):
                yield from self._several(values, known, depth)
            case ast.Name(id=name):
                yield from self._several(known.get(name, ()), known, depth)
            case ast.Call() if (function := self._functions.get(_called(node))) is not None:
                for step, inside in _steps(function.body, {}):
                    if isinstance(step, ast.Return):
                        yield from self._variants(step.value, inside, depth)

    def _several(self, nodes: Sequence[ast.expr], known: Environment, depth: int) -> Iterator[str]:
        for node in nodes:
            yield from self._variants(node, known, depth)
