"""What somebody is typing is kept in the user's folder, under names that lead nowhere else."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from atleak.common.files import draft_text, drafts, forget_draft, keep_draft, made_folder, new_token


def test_a_draft_is_kept_replaced_and_forgotten(own_home: Path) -> None:
    token = new_token()
    assert draft_text(token) is None
    keep_draft(token, "größer")
    keep_draft(token, "länger")
    assert list(drafts()) == [token]
    assert draft_text(token) == "länger"
    forget_draft(token)
    assert not drafts()


def test_every_draft_is_kept_the_newest_first(own_home: Path) -> None:
    tokens = [new_token() for _ in range(30)]
    for age, token in enumerate(tokens):
        keep_draft(token, token)
        os.utime(drafts()[token], (1e9 + age, 1e9 + age))
    assert list(drafts()) == tokens[::-1]


def test_a_draft_is_its_persons_alone_and_one_of_nobody_everybodys(own_home: Path) -> None:
    mine, nobodys = new_token(), new_token()
    keep_draft(mine, "mine", "https://shop ana")
    keep_draft(nobodys, "first")
    assert set(drafts("https://shop ana")) == {mine, nobodys}
    assert set(drafts("https://shop bert")) == set(drafts()) == {nobodys}
    assert draft_text(mine, "https://shop bert") is None
    forget_draft(mine, "https://shop bert")
    keep_draft(nobodys, "gone on with", "https://shop ana")
    assert draft_text(nobodys, "https://shop ana") == "gone on with"
    assert draft_text(nobodys, "https://shop bert") == draft_text(nobodys) == "first"
    forget_draft(nobodys, "https://shop ana")
    assert draft_text(nobodys) == "first"
    assert draft_text(mine, "https://shop ana") == "mine"
    assert not any("ana" in path.name for path in own_home.rglob("*"))


@pytest.mark.parametrize("token", ["../secret", "", "ABCDEF012345", "0123456789ab/"])
def test_no_other_file_is_read_or_deleted_by_the_name_of_a_draft(own_home: Path, token: str) -> None:
    keep_draft(new_token(), "")
    secret = own_home / "secret.json"
    secret.write_text("mine", encoding="utf-8")
    assert draft_text(token) is None
    forget_draft(token)
    assert secret.exists()


def test_a_draft_that_another_page_deletes_meanwhile_is_no_error(
    own_home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = "0123456789ab"
    monkeypatch.setattr(Path, "glob", lambda folder, pattern: [folder / f"{gone}.json"])
    assert list(drafts()) == [gone]
    assert draft_text(gone) is None


def test_forgetting_a_draft_where_there_is_no_folder_of_drafts_is_no_error(own_home: Path) -> None:
    (made_folder(own_home) / "drafts").write_text("a file", encoding="utf-8")
    forget_draft(new_token())
    assert (own_home / "drafts").read_text(encoding="utf-8") == "a file"
