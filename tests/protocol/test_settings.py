"""Settings from the environment: needed ones are asked for by name, secrets stay out of what is printed."""

from pathlib import Path

import pytest

from protocol.settings import Settings, frames_folder

NEEDED = {"LILLIPUT_LAB": "labs/gulliver.yaml", "REDIS_URL": "unix:///tmp/redis.sock"}


def test_defaults_fill_what_is_not_needed() -> None:
    settings = Settings.from_environment(NEEDED)
    assert settings.lab == Path("labs/gulliver.yaml")
    assert settings.redis_url == "unix:///tmp/redis.sock"
    assert settings.host == "127.0.0.1"
    assert settings.udp_key is None


@pytest.mark.parametrize("missing", sorted(NEEDED))
@pytest.mark.parametrize("value", [None, ""])
def test_what_is_missing_is_named(missing: str, value: str | None) -> None:
    environment = {name: text for name, text in NEEDED.items() if name != missing}
    if value is not None:
        environment[missing] = value
    with pytest.raises(SystemExit, match=missing):
        Settings.from_environment(environment)


def test_secrets_are_read_and_not_shown() -> None:
    settings = Settings.from_environment(
        {
            "LILLIPUT_LAB": "labs/gulliver.yaml",
            "REDIS_URL": "redis://lab:hunter2@redis.example:6379/0",
            "LILLIPUT_UDP_KEY": "c0ffee",
            "LILLIPUT_TOKEN": "a-token",
        }
    )
    assert settings.udp_key == b"\xc0\xff\xee"
    assert settings.token == "a-token"
    assert "a-token" not in repr(settings)
    assert "c0" not in repr(settings)
    assert "hunter2" not in repr(settings)


def test_a_key_that_is_not_hexadecimal_is_refused() -> None:
    with pytest.raises(SystemExit, match="LILLIPUT_UDP_KEY"):
        Settings.from_environment({**NEEDED, "LILLIPUT_UDP_KEY": "secret"})


def test_each_state_folder_has_frames_of_its_own(tmp_path: Path) -> None:
    assert frames_folder(tmp_path / "a") != frames_folder(tmp_path / "b")
    assert frames_folder(tmp_path / "a") == frames_folder(tmp_path / "b" / ".." / "a")
