"""The lives of a frame, a command and an action in ARCHITECTURE.md: what each function calls there, in this order."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SEARCH = "aos_gcs/mission/search"
FLIGHT = "aos_gcs/mission/fleet/flight.py"

CALLS = {
    # --- a frame
    (f"{SEARCH}/search.py", "Search.make_step"): ("make_steps", "_make_step"),
    (f"{SEARCH}/search.py", "Search._make_step"): ("add", "take", "work_on", "fly"),
    (f"{SEARCH}/in_flight/splitting.py", "Splitting.make_steps"): ("_look", "conclude"),
    (f"{SEARCH}/in_flight/splitting.py", "Splitting._look"): ("take", "decide_on"),
    (f"{SEARCH}/in_flight/sweeping.py", "Sweeping._make_step"): ("round", "work_on"),
    (f"{SEARCH}/frames/intake.py", "FrameIntake._record"): ("record_frame",),
    (f"{SEARCH}/frames/intake.py", "FrameIntake._examine"): ("examine_all",),
    (f"{SEARCH}/step_work.py", "StepWork.work_on"): ("decide_on", "conclude"),
    (f"{SEARCH}/step_work.py", "StepWork.decide_on"): ("_see", "_decide", "_record", "_send", "render", "note"),
    (f"{SEARCH}/step_work.py", "StepWork._see"): ("see",),
    (f"{SEARCH}/step_work.py", "StepWork._decide"): ("decide",),
    (f"{SEARCH}/step_work.py", "StepWork._record"): ("record_decision", "flush"),
    (f"{SEARCH}/step_work.py", "StepWork._send"): ("send",),
    (f"{SEARCH}/step_work.py", "StepWork.conclude"): ("_learn", "await_arrival"),
    (f"{SEARCH}/step_work.py", "StepWork._learn"): ("learn", "conclude", "observe"),
    (f"{SEARCH}/frames/vision.py", "Vision.see"): ("_placed", "analyse_examined"),
    (f"{SEARCH}/frames/vision.py", "Vision.learn"): ("_watch_persons", "_register", "_refocus"),
    ("aos_gcs/imaging/step/analysis.py", "analyse_examined"): ("_analyse", "mark"),
    ("aos_gcs/imaging/step/analysis.py", "_analyse"): ("judge",),
    (f"{SEARCH}/decisions/decider.py", "Decider.decide"): ("_observe", "_next_phase", "fly_on", "_choose_places"),
    (f"{SEARCH}/decisions/decider.py", "Decider._observe"): ("observe", "leaves"),
    (f"{SEARCH}/decisions/decider.py", "Decider._choose_places"): ("tell", "ask"),
    (f"{SEARCH}/decisions/decider.py", "Decider.conclude"): ("judge", "announce", "review"),
    (f"{SEARCH}/targets/tracker.py", "TargetTracker.observe"): ("locate_together", "observe"),
    (f"{SEARCH}/gallery.py", "Gallery.render"): ("render_pictures", "publish"),
    (f"{SEARCH}/ground/covered_ground.py", "CoveredGround.note"): ("_map", "add_footprints", "publish"),
    (f"{SEARCH}/ground/covered_ground.py", "CoveredGround._map"): ("offer",),
    # --- a command
    (FLIGHT, "FlightControl.vet"): ("situation", "vet_plan"),
    ("aos_gcs/airspace/plans.py", "vet_plan"): ("vet_waypoints",),
    (FLIGHT, "FlightControl.send"): ("orders", "command_each"),
    (FLIGHT, "FlightControl.command_each"): ("command",),
    (FLIGHT, "FlightControl.command"): ("execute",),
    (f"{SEARCH}/in_flight/commands.py", "SweepCommands._start"): ("orders", "_send"),
    (f"{SEARCH}/in_flight/commands.py", "SweepCommands._send"): ("command",),
    # --- an action
    ("aos_gcs/api/routers/mission.py", "act"): ("claim", "require_seen", "run", "act"),
    ("aos_gcs/bridge/calls.py", "MissionCalls._act"): ("act",),
    ("aos_gcs/mission/commands.py", "LiveCommands.act"): ("act",),
    ("aos_gcs/mission/actions.py", "ActionHandler.act"): (
        *("check", "cancel", "check_action", "note", "end", "_on_all", "_act_on", "_record"),
    ),
    ("aos_gcs/mission/actions.py", "ActionHandler._record"): ("record_action",),
}
"""Names that a function uses, in the order of their first use, by its module and its own name."""


def function_in(tree: ast.Module, name: str) -> ast.AST:
    found: ast.AST = tree
    for part in name.split("."):
        inner: list[ast.AST] = [one for one in ast.iter_child_nodes(found) if getattr(one, "name", "") == part]
        assert inner, f"{name} is not defined any more: follow it in ARCHITECTURE.md, and here"
        (found,) = inner
    return found


def used_names(function: ast.AST) -> Iterator[str]:
    """Yield attributes and variables that are read, in the order of the source."""
    nodes = [node for node in ast.walk(function) if isinstance(node, ast.Attribute | ast.Name)]
    for node in sorted(nodes, key=lambda node: (node.end_lineno or 0, node.end_col_offset or 0)):
        if isinstance(node.ctx, ast.Load):
            yield node.attr if isinstance(node, ast.Attribute) else node.id


@pytest.mark.parametrize(("where", "calls"), CALLS.items(), ids=[name for _, name in CALLS])
def test_functions_call_one_another_as_the_description_tells(where: tuple[str, str], calls: tuple[str, ...]) -> None:
    path, name = where
    used = list(used_names(function_in(ast.parse((ROOT / path).read_text(encoding="utf-8")), name)))
    assert [call for call in dict.fromkeys(used) if call in calls] == list(calls)


def test_every_method_in_the_descriptions_is_followed() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    lives = text[text.index("## The life of a frame") : text.index("## Rules that keep it safe")]
    methods = re.findall(r"`([A-Z]\w+\.\w+)`", lives)
    assert len(methods) > 15
    known = {name for _, name in CALLS} | {name for calls in CALLS.values() for name in calls}
    assert [method for method in methods if method not in known and method.partition(".")[2] not in known] == []
