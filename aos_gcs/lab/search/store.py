"""The study of searches in a folder: a line per forest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from aos_gcs.lab.search.model import Method, SearchKey, SearchOutcome, SearchResult, SearchStudySettings
from aos_gcs.lab.study_folder import ResultLines, read_lines

RESULTS_FILE = "searches.jsonl"


class SearchFolder(ResultLines):
    """Settings and results of a study; a forest of which a crash has cut the line is searched again."""

    def __init__(self, path: Path, settings: SearchStudySettings) -> None:
        """Open a folder, or make it; see :class:`~aos_gcs.lab.study_folder.ResultLines`."""
        super().__init__(path, settings, RESULTS_FILE)

    def append(self, result: SearchResult) -> None:
        """Write down what the searches in a forest have come to."""
        self.append_line(result)

    def results(self) -> list[SearchResult]:
        """Return the results so far, in the order of their keys.

        Raises:
            InputDataError: a line is damaged.
        """
        results = read_lines(self.path / RESULTS_FILE, _parse, lambda result: result.key)
        return sorted(results.values(), key=lambda result: result.key)


def _parse(table: dict[str, Any]) -> SearchResult:
    outcomes = tuple(SearchOutcome(**{**one, "method": Method(one["method"])}) for one in table["outcomes"])
    return SearchResult(SearchKey(**table["key"]), outcomes)
