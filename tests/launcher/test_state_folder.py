"""Secrets of the state folder: private, made once, checked."""

import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from launcher.errors import UsageError
from launcher.state_folder import create_secret, locked, udp_key


def test_the_key_is_made_once_and_private(tmp_path: Path) -> None:
    key = udp_key(tmp_path)
    assert len(bytes.fromhex(key)) == 32
    assert udp_key(tmp_path) == key
    assert stat.S_IMODE((tmp_path / "udp.key").stat().st_mode) == 0o600


def test_a_given_key_wins_and_is_not_kept(tmp_path: Path) -> None:
    assert udp_key(tmp_path, "ab" * 32) == "ab" * 32
    assert not (tmp_path / "udp.key").exists()


@pytest.mark.parametrize("bad", ["", "abc", "zz" * 32, "ab"])
def test_a_spoiled_key_file_is_named(tmp_path: Path, bad: str) -> None:
    (tmp_path / "udp.key").write_text(bad)
    with pytest.raises(UsageError, match=r"udp\.key must hold"):
        udp_key(tmp_path)


def test_of_two_that_make_a_secret_at_once_one_wins_whole(tmp_path: Path) -> None:
    path = tmp_path / "secret"
    texts = [str(number) * 1000 for number in range(8)]
    with ThreadPoolExecutor(len(texts)) as pool:
        list(pool.map(create_secret, [path] * len(texts), texts))
    assert path.read_text() in texts
    assert sorted(p.name for p in tmp_path.iterdir()) == ["secret"]


def test_a_folder_is_held_by_one_and_let_go_of(tmp_path: Path) -> None:
    state = tmp_path / "new" / "state"
    with locked(state), pytest.raises(UsageError, match="already runs"), locked(state):
        pass
    with locked(state):
        assert stat.S_IMODE(state.stat().st_mode) == 0o700
