"""Commands that are imported on demand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import typer
from typer.core import TyperGroup

from aos_gcs.errors import ConfigurationError
from aos_gcs.input_values import problem_texts

ENTRY_POINT_GROUP = "aos_gcs.commands"


class LazyCommands(Mapping[str, Any]):
    """Command name to typer command; a look-up imports the module behind the name."""

    def __init__(self, targets: Mapping[str, EntryPoint]) -> None:
        self._targets = targets
        self._loaded: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self._loaded:
            self._loaded[name] = _load(name, self._targets[name])
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._targets)

    def __len__(self) -> int:
        return len(self._targets)


def group_class(built_in: Mapping[str, str]) -> type[TyperGroup]:
    """Return a typer group with the built-in commands (name to ``module:function``) and the installed plug-ins.

    A plug-in that carries the name of a built-in command is ignored.
    """
    plug_ins = {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}
    own = {name: EntryPoint(name, target, ENTRY_POINT_GROUP) for name, target in built_in.items()}
    commands = LazyCommands(own | {name: point for name, point in plug_ins.items() if name not in own})

    class Group(TyperGroup):
        def __init__(self, **attributes: Any) -> None:
            super().__init__(**attributes)
            # Only read from here on; typer's own registration would want a mutable mapping.
            self.commands = commands  # type: ignore[assignment]

        def invoke(self, ctx: Any) -> Any:
            try:
                return super().invoke(ctx)
            except typer.BadParameter as error:
                # Put the words of this program for those of the library that checks the values of options.
                problems = getattr(error.__cause__, "errors", None)
                if problems is not None:
                    error.message = problem_texts(problems(), "it")[0]
                raise

        def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002 - typer's signature
            return list(commands)

    return Group


def _load(name: str, point: EntryPoint) -> Any:
    try:
        target = point.load()
    except Exception as error:  # whatever foreign code raises on import must not take the other commands along
        return _unavailable(name, point, error)
    return _to_command(name, target)


def _to_command(name: str, target: Any) -> Any:
    """Return a typer command; ``target`` is a function with typer annotations or a ``typer.Typer``."""
    if isinstance(target, typer.Typer):
        command = typer.main.get_command(target)
        command.name = name  # a group of its own does not know what it is called here
        return command
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command(name)(target)
    return typer.main.get_command(app)


def _unavailable(name: str, point: EntryPoint, error: Exception) -> Any:
    reason = f"{type(error).__name__}: {error}"

    def explain() -> None:
        raise ConfigurationError(
            f"The command '{name}' is unavailable, because {point.value} cannot be loaded ({reason}). "
            "Install the package that provides it together with its requirements."
        ) from error

    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command(
        name,
        help=f"Unavailable: {reason}",
        add_help_option=False,
        context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
    )(explain)
    return typer.main.get_command(app)
