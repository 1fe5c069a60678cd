"""What is known of a vehicle in the mission: who may set it, and what changes together."""

import ast
from collections import defaultdict
from dataclasses import fields
from pathlib import Path
from unittest.mock import create_autospec

import numpy as np

from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock
from tests.fakes.fleet import FakeFleet

MISSION = Path(__file__).resolve().parents[3] / "aos_gcs" / "mission"


def roster_of(count: int) -> Roster:
    clock = create_autospec(Clock, instance=True)
    roster = Roster(FakeFleet(clock, count, None), clock)
    roster.refresh()
    return roster


def writers(sources: dict[str, str], names: set[str]) -> dict[str, set[str]]:
    """Modules that set attributes of these names: member.py those of ``self``, all others those of anything else."""
    found: dict[str, set[str]] = defaultdict(set)
    for module, text in sources.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and node.attr in names:
                is_own = isinstance(node.value, ast.Name) and node.value.id == "self"
                if is_own == (module == "member.py"):
                    found[node.attr].add(module)
    return found


def test_each_field_of_a_member_is_set_by_one_module() -> None:
    """Six modules set one record once, and each kept other fields in step with it."""
    names = {field.name for field in fields(Member)}
    sources = {path.name: path.read_text(encoding="utf-8") for path in MISSION.rglob("*.py")}
    found = writers(sources, names)
    assert {name: modules for name, modules in found.items() if len(modules) > 1} == {}
    assert found["layer_height_m"] == {"member.py"}


def test_a_second_writer_of_a_field_is_found() -> None:
    sources = {
        "member.py": "class Member:\n    def leave(self):\n        self.layer_height_m = None\n",
        "joining.py": "def join(member, other):\n    member.home, other.layer_height_m = 1, 2\n",
        "other.py": "class Plan:\n    def __init__(self):\n        self.layer_height_m = 3\n",
    }
    assert writers(sources, {"layer_height_m"}) == {"layer_height_m": {"member.py", "joining.py"}}


def test_a_vehicle_that_is_not_chosen_any_more_keeps_its_layer_while_it_takes_part() -> None:
    roster = roster_of(2)
    flying, standing = roster.members()
    for member, height_m in ((flying, 35.0), (standing, 37.5)):
        member.choose(is_chosen=True)
        member.take_place(np.zeros(3), height_m)
    roster.assign(flying, Task.JOINING)
    roster.choose(())
    assert (flying.layer_height_m, standing.layer_height_m) == (35.0, None)
    assert standing.home_enu_m is not None


def test_a_hold_for_safety_is_no_order() -> None:
    (member,) = roster_of(1).members()
    member.last_command = member.hold_for_safety()
    assert not member.is_held_by_order
    first = member.safety_hold
    member.hold_for_safety()
    assert member.safety_hold is not first
    assert member.is_held_by_order, "the hold that was sent is another one"


def test_a_waypoint_is_for_the_task_that_it_is_sent_for() -> None:
    roster = roster_of(1)
    (member,) = roster.members()
    roster.assign(member, Task.JOINING)
    member.send_to(np.array([1.0, 2.0, 3.0]))
    roster.assign(member, Task.SWARM)
    assert member.waypoint_task is Task.JOINING
