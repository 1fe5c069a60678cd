"""The audit chain: whatever was changed afterwards is named, and what was not is intact."""

from __future__ import annotations

import asyncio
import json
import sqlite3
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.actions import Action, ActionRecord
from aos_gcs.store.audit import append_entry, entry_digest, verify_audit
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.store.schema import DATABASE_NAME, MANIFEST_NAME
from tests.fakes.command_line import exit_status
from tests.fakes.records import notice_event


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    asyncio.run(_record(tmp_path))
    return tmp_path / "m"


async def _record(root: Path) -> None:
    async with MissionRecorder.create(root, "m", {"seed": 1}, notify=lambda _: None) as recorder:
        await recorder.record_event(notice_event(1, "Robin: plan applied"))
        await recorder.record_action(ActionRecord(1002.0, Action.START, None, (), operator="Robin"))
        await recorder.record_event(notice_event(2, "Robin: finding 1 confirmed"))
        await recorder.record_action(ActionRecord(1004.0, Action.HOLD, (1,), (), operator="Kim"))


def tamper(folder: Path, *statements: str) -> None:
    """Change the database as somebody does who knows how to."""
    connection = sqlite3.connect(folder / DATABASE_NAME)
    for (trigger,) in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'trigger'").fetchall():
        connection.execute(f"DROP TRIGGER {trigger}")
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


def test_an_untouched_record_is_intact(folder: Path) -> None:
    report = verify_audit(folder)
    assert report.fault is None
    assert [(entry.source, entry.row) for entry in report.entries] == [
        ("manifest", 0),
        ("event", 1),
        ("action", 1),
        ("event", 2),
        ("action", 2),
    ]
    assert report.entries[2].utc_s == 1002.0
    assert len(report.digest) == 64


@pytest.mark.parametrize(
    ("statement", "fault", "intact"),
    [
        (
            "UPDATE actions SET record = replace(record, 'Robin', 'Eve')",
            "entry 3 (action 1) of 1970-01-01 00:16:42 UTC",
            2,
        ),
        (
            "UPDATE actions SET utc_s = 1003 WHERE id = 2",
            "entry 5 (action 2) of 1970-01-01 00:16:43 UTC was changed",
            4,
        ),
        ("UPDATE events SET data = replace(data, 'confirmed', 'rejected')", "entry 4 (event 2)", 3),
        ("UPDATE actions SET utc_s = 'x' WHERE id = 1", "entry 3 (action 1) was changed: it has no time or no text", 2),
        ("DELETE FROM actions WHERE id = 1", "entry 3 (action 1): what it stands for was removed", 2),
        ("DELETE FROM audit WHERE entry = 3", "entry 3 was removed", 2),
        ("DELETE FROM audit", "all entries were removed", 0),
        ("UPDATE audit SET digest = 'x' WHERE entry = 2", "entry 2 (event 1) of", 1),
        ("UPDATE audit SET source_row = 2 WHERE entry = 3", "entry 3 (action 2) of", 2),
        ("UPDATE audit SET source = 'steps' WHERE entry = 3", "there is no such source", 2),
        ("INSERT INTO actions (utc_s, record) VALUES (1003, '{}')", "action 3 was inserted", 5),
        (
            "INSERT INTO events (seq, utc_s, kind, data) VALUES (7, 1003, 'notice', '{}')",
            "event 7 was inserted: no entry stands for it",
            5,
        ),
    ],
)
def test_whatever_was_changed_is_named(folder: Path, statement: str, fault: str, intact: int) -> None:
    tamper(folder, statement)
    report = verify_audit(folder)
    assert fault in (report.fault or "")
    assert len(report.entries) == intact


def test_two_entries_for_one_action_are_named(folder: Path) -> None:
    connection = sqlite3.connect(folder / DATABASE_NAME)
    (content,) = connection.execute("SELECT record FROM actions WHERE id = 1").fetchone()
    append_entry(connection, "action", 1, 1002.0, content)
    connection.commit()
    connection.close()
    assert verify_audit(folder).fault == "action 1 stands in several entries"


def test_a_changed_manifest_is_named(folder: Path) -> None:
    (folder / MANIFEST_NAME).write_text('{"seed": 2}\n')
    assert verify_audit(folder).fault == "entry 1 (manifest 0) was changed, or its digest"
    (folder / MANIFEST_NAME).unlink()
    assert verify_audit(folder).fault == f"entry 1 (manifest 0): {MANIFEST_NAME} is missing or damaged"


def test_the_chain_goes_on_where_a_mission_is_continued(folder: Path) -> None:
    before = verify_audit(folder)
    database = MissionDatabase.reopen(folder, last_step=0)
    database.write([lambda opened: opened.add_action(ActionRecord(1009.0, Action.RETURN, None, ()))])
    database.close()
    after = verify_audit(folder)
    assert (after.fault, after.entries[:-1], len(after.entries)) == (None, before.entries, 6)


def test_a_write_that_fails_leaves_the_chain_intact(folder: Path) -> None:
    database = MissionDatabase.open_ended(folder)

    def fail(_database: MissionDatabase) -> None:
        raise OSError("no space left")

    with pytest.raises(OSError, match="no space"):
        database.write([lambda opened: opened.add_event(notice_event(8)), fail])
    database.write([lambda opened: opened.add_event(notice_event(9))])
    database.close()
    report = verify_audit(folder)
    assert (report.fault, report.entries[-1].row) == (None, 9)


def test_an_older_record_has_no_chain_and_gets_none(folder: Path) -> None:
    tamper(folder, "DROP TABLE audit")
    database = MissionDatabase.open_ended(folder)
    database.write([lambda opened: opened.add_event(notice_event(8))])
    database.close()
    with pytest.raises(InputDataError, match="has no audit chain: an older version has recorded it"):
        verify_audit(folder)


@given(st.text(), st.sampled_from(["action", "event"]), st.integers(0), st.floats(0.0, 1e11), st.text())
def test_every_part_of_an_entry_is_in_its_digest(
    previous: str, source: str, row: int, utc_s: float, content: str
) -> None:
    digest = entry_digest(previous, source, row, utc_s, content)
    assert digest != entry_digest(previous + "0", source, row, utc_s, content)
    assert digest != entry_digest(previous, source + "s", row, utc_s, content)
    assert digest != entry_digest(previous, source, row + 1, utc_s, content)
    assert digest != entry_digest(previous, source, row, utc_s + 1.0, content)
    assert digest != entry_digest(previous, source, row, utc_s, content + " ")


def inspect(*arguments: object) -> int:
    return exit_status(["inspect", "--audit", *arguments])


def test_the_command_tells_and_returns_what_it_has_found(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert inspect(folder) == 0
    assert capsys.readouterr().out == f"intact: 5 entries, digest {verify_audit(folder).digest}\n"
    tamper(folder, "DELETE FROM actions WHERE id = 2")
    assert inspect(folder, "--json") == 1
    told = json.loads(capsys.readouterr().out)
    assert (told["fault"], len(told["entries"])) == ("entry 5 (action 2): what it stands for was removed", 4)
    assert inspect(folder) == 1
    assert "the 4 entries before it are intact" in capsys.readouterr().out
    tamper(folder, "DROP TABLE audit")
    assert inspect(folder) == 2
    assert inspect(folder / "frames") == 2
    capsys.readouterr()
    assert inspect(folder, "--steps") == 2
    assert "leave --steps and --truth out" in capsys.readouterr().err


def test_a_noted_digest_is_found_however_it_was_written_down(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    noted = verify_audit(folder).entries[2].digest
    grouped = " ".join(noted[start : start + 4] for start in range(0, 16, 4)).upper()
    for text in (noted, noted[:16], grouped):
        assert inspect(folder, "--audit-digest", text) == 0
        out = capsys.readouterr().out
        assert "noted digest: that of entry 3 (action 1) of 1970-01-01 00:16:42 UTC" in out
        assert "2 came later" in out


def test_a_digest_of_the_last_entry_and_of_the_manifest_are_found(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    entries = verify_audit(folder).entries
    assert inspect(folder, "--audit-digest", entries[-1].digest) == 0
    assert "0 came later" in capsys.readouterr().out
    assert inspect(folder, "--audit-digest", entries[0].digest, "--json") == 0
    assert json.loads(capsys.readouterr().out)["noted"] == {"digest": entries[0].digest, "entry": 1}


def test_a_chain_that_was_computed_anew_does_not_have_the_noted_digest(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noted = verify_audit(folder).digest
    tamper(folder, "UPDATE actions SET record = replace(record, 'Kim', 'Robin') WHERE id = 2")
    compute_anew(folder)
    assert inspect(folder) == 0
    capsys.readouterr()
    assert inspect(folder, "--audit-digest", noted) == 1
    assert "noted digest: none of the 5 entries has it" in capsys.readouterr().out
    assert inspect(folder, "--audit-digest", noted, "--json") == 1
    assert json.loads(capsys.readouterr().out)["noted"]["entry"] is None


def test_a_change_after_the_noted_digest_is_told_with_what_still_fits(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noted = verify_audit(folder).entries[1].digest
    tamper(folder, "DELETE FROM actions WHERE id = 2")
    assert inspect(folder, "--audit-digest", noted) == 1
    out = capsys.readouterr().out
    assert out.startswith("changed: entry 5")
    assert "noted digest: that of entry 2" in out


@pytest.mark.parametrize("text", ["", "6f0d5c", "x" * 64, "0" * 65, "6f0d5c…"])
def test_what_is_no_digest_is_refused(folder: Path, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert inspect(folder, "--audit-digest", text) == 2
    assert "audit digest: give the 64 hexadecimal digits" in capsys.readouterr().err


def compute_anew(folder: Path) -> None:
    """Compute the chain of a record again, as a forger does."""
    connection = sqlite3.connect(folder / DATABASE_NAME)
    rows = connection.execute("SELECT source, source_row FROM audit ORDER BY entry").fetchall()
    tables = {"action": "SELECT utc_s, record FROM actions WHERE id = ?"}
    tables["event"] = "SELECT utc_s, data FROM events WHERE seq = ?"
    connection.execute("DELETE FROM audit")
    for source, number in rows:
        manifest = None, (folder / MANIFEST_NAME).read_text(encoding="utf-8")
        utc_s, content = connection.execute(tables[source], (number,)).fetchone() if number else manifest
        append_entry(connection, source, number, utc_s, content)
    connection.commit()
    connection.close()
