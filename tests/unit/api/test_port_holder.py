"""Process that holds a port, as the system tells."""

from __future__ import annotations

from pathlib import Path

import pytest

from aos_gcs.api.port_holder import find_holder


@pytest.mark.parametrize(
    ("state", "port", "words"),
    [
        ("S", 8080, "process 41 (aos-gcs run (a b)): stop it"),
        ("T", 8080, "process 41 (aos-gcs run (a b)), which is stopped and keeps it: end it with kill -9 41"),
        ("S", 8081, None),
    ],
)
def test_who_holds_a_port_is_read_from_the_system(tmp_path: Path, state: str, port: int, words: str | None) -> None:
    row = "   0: 00000000:{:04X} 00000000:0000 {} 00000000:00000000 00:00000000 00000000     0        0 {} 1"
    (tmp_path / "net").mkdir()
    rows = [row.format(8080, "01", 76), row.format(8080, "0A", 77), row.format(8082, "0A", 78)]
    (tmp_path / "net" / "tcp").write_text("\n".join(["head", *rows, ""]))
    for pid, inode in ((40, 76), (41, 77), (42, 78)):
        (tmp_path / str(pid) / "fd").mkdir(parents=True)
        (tmp_path / str(pid) / "fd" / "3").symlink_to(f"socket:[{inode}]")
        (tmp_path / str(pid) / "cmdline").write_bytes(b"aos-gcs\0run\0(a b)\0")
        (tmp_path / str(pid) / "stat").write_text(f"{pid} (aos) (b) {state} 1 1")
    (tmp_path / "39").mkdir()
    found = find_holder(port, tmp_path)
    assert (None if found is None else found.describe()) == words
