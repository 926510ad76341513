"""The channel table and the keys: what a health report and a debugger rely on."""

import ast
import inspect
from pathlib import Path

import pytest

from protocol import keys
from protocol.channels import CHANNELS, EVENTS, RESPONSES, Channel, Delivery, Instances

PRODUCERS = {"camera", "tracker", "calibrator", "mapper", "guidance", "agent", "server", "intake", "launcher", "lab"}


def test_names_are_unique_and_fit_a_topic() -> None:
    names = [channel.name for channel in CHANNELS]
    assert len(set(names)) == len(names)
    assert all(name.replace("_", "").isalpha() and name.islower() for name in names)


def test_every_channel_of_the_module_is_in_the_table() -> None:
    import protocol.channels

    defined = {value.name for _, value in inspect.getmembers(protocol.channels, lambda v: isinstance(v, Channel))}
    assert defined == {channel.name for channel in CHANNELS}


@pytest.mark.parametrize("channel", CHANNELS, ids=lambda channel: channel.name)
def test_a_channel_makes_sense(channel: Channel) -> None:  # type: ignore[type-arg]  # of any message
    assert channel.producer in PRODUCERS
    assert channel.rate_hz >= 0
    if channel.stale_after_s:
        assert channel.rate_hz > 0, "what has no rate cannot be late"
        assert channel.stale_after_s >= 2 / channel.rate_hz, "one lost message must not count as silence"
    if channel.delivery is Delivery.EVERY:
        assert channel.stale_after_s == 0


def test_what_must_arrive_is_a_stream() -> None:
    assert {c.name for c in CHANNELS if c.delivery is Delivery.EVERY} == {RESPONSES.name, EVENTS.name}


def test_a_process_channel_is_per_process() -> None:
    assert [c.name for c in CHANNELS if c.per is Instances.PROCESS] == ["processes"]


def test_keys_are_distinct_and_ours() -> None:
    texts = [value for name, value in vars(keys).items() if name.isupper() and name != "PREFIX"]
    texts += [keys.live("poses"), keys.topic("poses", "a"), keys.stream("poses"), keys.session("d")]
    assert len(set(texts)) == len(texts)
    assert all(text.startswith(f"{keys.PREFIX}:") for text in texts)


def test_every_key_is_documented() -> None:
    body = ast.parse(Path(keys.__file__).read_text()).body
    for node, following in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id != "PREFIX":
            assert isinstance(following, ast.Expr), node.targets[0].id
