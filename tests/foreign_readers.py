"""Our files and messages, read by the schema and the program of others.

Run: python -m tests.foreign_readers [--gpx-schema gpx.xsd] [--node-cot FOLDER]

``--gpx-schema`` names the schema of GPX 1.1 (https://www.topografix.com/GPX/1/1/gpx.xsd), which is not part of this
repository; it needs lxml. ``--node-cot`` names a folder in which ``npm install @tak-ps/node-cot`` has been run. Both
get what a scripted mission makes of its findings, among them one whose texts hold markup and control characters.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

from aos_gcs.clock import LoopClock
from aos_gcs.exports.finding_files import PlacedFinding, to_gpx
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.tak.board import MarkBoard
from aos_gcs.sharing.tak.scene import scene
from tests.fakes.mission import ScriptedMission
from tests.fakes.sharing import UTC_S, seen

VEHICLES = 8
STEPS = 40
HOSTILE = "page 1\x0bpage 2\x00 <b>&amp; ]]> \"'\U0001f6a9" + "x" * 2000
UNDULATION_M = 45.0

READ_EVENTS = """
import CoT, * as all from '@tak-ps/node-cot';
let text = '';
for await (const part of process.stdin) text += part;
const answers = [];
for (const xml of JSON.parse(text)) {
    try {
        const cot = all.CoTParser ? all.CoTParser.from_xml(xml) : new CoT(xml);
        const feature = all.CoTParser ? await all.CoTParser.to_geojson(cot) : cot.to_geojson();
        answers.push(feature.geometry.type);
    } catch (error) {
        answers.push(`refused: ${error.message}`);
    }
}
console.log(JSON.stringify(answers));
"""
"""Reads events, and tells of each what geometry it has become."""


async def fly() -> tuple[list[MissionSnapshot], MissionSnapshot]:
    """Return the states of a mission in which findings are made, judged and rejected, and the last one."""
    mission = ScriptedMission(LoopClock(), VEHICLES)
    await mission.act(Action.START, None)
    states = [mission.snapshot()]
    for number in range(STEPS):
        mission.make_step()
        if number == STEPS // 2:
            marked = await mission.add_finding((5.0, 6.0, 0.0), HOSTILE, operator=HOSTILE[:40])
            rejected = await mission.add_finding((7.0, 6.0, 0.0), "", operator="Kim")
            await mission.change_finding(marked.finding_id, FindingChange(FindingStatus.CONFIRMED), operator="Kim")
        if number == STEPS - 15:
            await mission.change_finding(rejected.finding_id, FindingChange(FindingStatus.REJECTED), operator="Kim")
        states.append(mission.snapshot())
    return states, mission.snapshot()


def events_of(states: Sequence[MissionSnapshot]) -> list[str]:
    """Return what TAK is sent of states that are a second apart."""
    board, events = MarkBoard(), []
    for second, state in enumerate(states):
        shown = scene(seen(state), "AOS", lambda _latitude_deg, _longitude_deg: UNDULATION_M, 0.0)
        events += board.due(shown, float(second), UTC_S + second)
    return [event.decode() for event in events]


def check_cot(folder: Path, states: Sequence[MissionSnapshot]) -> bool:
    """Tell what node-cot makes of the events; whether it reads all."""
    events = events_of(states)
    command = ["node", "--input-type=module", "-e", READ_EVENTS]
    ran = subprocess.run(  # noqa: S603 - our own script
        command, cwd=folder, input=json.dumps(events), capture_output=True, text=True, check=True
    )
    answers = json.loads(ran.stdout)
    refused = [answer for answer in answers if answer.startswith("refused")]
    sent = Counter(ET.fromstring(event).get("type") for event in events)  # noqa: S314 - our own
    say(f"node-cot: {len(answers) - len(refused)} of {len(events)} events read; {dict(sent)}; {dict(Counter(answers))}")
    return not refused and len(answers) == len(events)


def check_gpx(schema: Path, last: MissionSnapshot) -> bool:
    """Tell whether the findings as GPX fit the schema."""
    from lxml import etree  # noqa: PLC0415 - needed for this only

    if last.origin is None:
        raise SystemExit("the scripted mission has no origin")
    frame = LocalFrame(last.origin)
    placed = [PlacedFinding(one, frame.to_geodetic(one.position_enu_m), UTC_S) for one in last.findings]
    rules = etree.XMLSchema(etree.parse(schema))
    wrong = [
        f"{count} findings: {error.message}"
        for count in range(len(placed) + 1)
        if not rules.validate(etree.fromstring(to_gpx(placed[:count]).encode()))
        for error in rules.error_log
    ]
    say(f"GPX: files of 0 to {len(placed)} findings: {wrong or 'all fit the schema'}")
    return not wrong


def say(text: str) -> None:
    """Print a line."""
    sys.stdout.write(f"{text}\n")


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the options and check what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gpx-schema", type=Path)
    parser.add_argument("--node-cot", type=Path)
    options = parser.parse_args(arguments)
    if options.gpx_schema is None and options.node_cot is None:
        parser.error("nothing to check: give --gpx-schema FILE or --node-cot FOLDER")
    states, last = asyncio.run(fly())
    results = [] if options.gpx_schema is None else [check_gpx(options.gpx_schema, last)]
    results += [] if options.node_cot is None else [check_cot(options.node_cot, states)]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
