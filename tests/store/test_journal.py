from __future__ import annotations

from pathlib import Path

from gaitflow.store.journal import Entry, Journal, read_journal, unended, write_off


def test_only_a_start_that_nothing_follows_has_no_end(tmp_path: Path) -> None:
    assert unended(tmp_path) == {}
    for word in "abc":
        journal = Journal(tmp_path, f"7-{word}")
        journal.started("first")
        journal.stored("first", 1.0, 1.0, kept=True)
        journal.started("second")
    Journal(tmp_path, "7-a").ended("second")
    Journal(tmp_path, "9-d").started("first")
    assert {unit: sorted(solvers) for unit, solvers in unended(tmp_path).items()} == {
        "second": ["7-b", "7-c"],
        "first": ["9-d"],
    }


def test_what_is_written_off_does_not_count_again(tmp_path: Path) -> None:
    for word in "ab":
        Journal(tmp_path, f"7-{word}").started("unit")
    write_off(tmp_path, "unit", unended(tmp_path)["unit"])
    assert unended(tmp_path) == {}
    assert [entry.event for entry in read_journal(tmp_path)] == ["start", "start", "ended", "ended"]
    Journal(tmp_path, "8-c").started("unit")
    assert unended(tmp_path) == {"unit": ["8-c"]}


def test_long_journals_are_read_from_their_end_and_cut_lines_left_out(tmp_path: Path) -> None:
    journal = Journal(tmp_path, "7-a")
    for number in range(200):
        journal.started(f"{number:064d}")
        journal.stored(f"{number:064d}", 1.0, 1.0, kept=True)
    journal.started("last")
    Journal(tmp_path, "7-b").started("cut")
    cut = tmp_path / "7-b.jsonl"
    cut.write_text(cut.read_text()[:-9])
    (tmp_path / "7-c.jsonl").touch()
    assert unended(tmp_path) == {"last": ["7-a"]}
    assert len(read_journal(tmp_path)) == 401
    assert isinstance(read_journal(tmp_path)[-1], Entry)
