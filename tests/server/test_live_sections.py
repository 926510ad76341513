"""Versions of the live state: whatever a client has seen, what it is sent makes its picture the current one."""

import json
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from server.live import sections as module
from server.live.sections import Item, Sections


class Thing(BaseModel):
    value: int


IDS = ("a", "b", "c")
CONTENTS = st.dictionaries(st.sampled_from(IDS), st.integers(0, 3), max_size=3)
STEPS = st.lists(st.tuples(CONTENTS, st.one_of(st.none(), st.integers(0, 3)), st.sets(st.integers(0, 2))), max_size=15)


class Reader:
    """A client that takes a message now and then."""

    def __init__(self) -> None:
        self.version = -1
        self.things: dict[str, Any] = {}
        self.single: Any = None
        self.lines: list[int] = []

    def read(self, sections: Sections) -> None:
        message = json.loads(sections.message(self.version, 7))
        assert message["stamp_ns"] == 7
        if message["type"] == "snapshot":
            self.things, self.single = message["waypoints"], message["obstacles"]
            self.lines = [line["value"] for line in message["events"]]
        else:
            merged = {**self.things, **message.get("waypoints", {})}
            self.things = {name: value for name, value in merged.items() if value is not None}
            self.single = message.get("obstacles", self.single)
            self.lines += [line["value"] for line in message.get("events", [])]
        self.version = sections.version


@given(STEPS)
def test_every_reader_ends_with_the_truth(steps: list[tuple[dict[str, int], int | None, set[int]]]) -> None:
    sections, readers = Sections(), [Reader(), Reader(), Reader()]
    for number, (things, single, reading) in enumerate(steps):
        sections.replace("waypoints", {name: Item(Thing(value=value)) for name, value in things.items()})
        sections.replace_single("obstacles", None if single is None else Item(Thing(value=single)))
        sections.append(Thing(value=number))
        assert sections.commit()
        for index in reading:
            readers[index].read(sections)
    for reader in readers:
        reader.read(sections)
        things, single, _ = steps[-1] if steps else ({}, None, set[int]())
        assert reader.things == {name: {"value": value} for name, value in things.items()}
        assert reader.single == (None if single is None else {"value": single})
        assert reader.lines == list(range(len(steps)))


def test_nothing_new_is_no_version() -> None:
    sections = Sections()
    sections.replace("routes", {"a": Item(Thing(value=1))})
    assert sections.commit()
    sections.replace("routes", {"a": Item(Thing(value=1))})
    assert not sections.commit()
    assert sections.version == 1


def test_the_key_alone_tells_a_change() -> None:
    sections = Sections()
    sections.replace("robots", {"a": Item(Thing(value=1), "key")})
    sections.commit()
    sections.replace("robots", {"a": Item(Thing(value=2), "key")})
    assert not sections.commit()


def test_some_entries_may_be_set_alone() -> None:
    sections, reader = Sections(), Reader()
    sections.put("waypoints", {"a": Item(Thing(value=1))})
    sections.put("waypoints", {"b": Item(Thing(value=2))})
    assert sections.commit()
    sections.put("waypoints", {"b": Item(Thing(value=3))})
    reader.read(sections)
    assert sections.commit()
    reader.read(sections)
    assert reader.things == {"a": {"value": 1}, "b": {"value": 3}}


def test_one_who_lags_too_far_behind_gets_a_snapshot(monkeypatch: Any) -> None:
    monkeypatch.setattr(module, "_TOMBSTONES", 4)
    sections = Sections()
    sections.commit()
    for number in range(20):
        sections.replace("objects", {f"o{number}": Item(Thing(value=number))})
        sections.commit()
    assert json.loads(sections.message(0, 1))["type"] == "snapshot"
    assert list(json.loads(sections.message(0, 1))["objects"]) == ["o19"]
    assert json.loads(sections.message(sections.version - 1, 1))["type"] == "changes"
