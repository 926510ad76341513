"""Reads a lab file; every problem is named with the line that it stands on."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from protocol.errors import LabFileError, LabProblem
from protocol.lab.description import Lab, Location

_MERGE = "<<"
_DEEPEST = 50


def load_lab(path: Path | str, *, recorded: bool = False) -> Lab:
    """The lab described by the YAML file; LabFileError when it cannot be read, parsed or believed. With `recorded` its
    cameras' frames come from a recording: a simulated camera needs no place in the simulation."""
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise LabFileError(str(file), [LabProblem(0, "", f"cannot read the lab file: {error}")]) from error
    return parse_lab(text, str(file), recorded=recorded)


def parse_lab(text: str, name: str = "lab.yaml", *, recorded: bool = False) -> Lab:
    """The lab described by YAML text; `name` stands in the messages of LabFileError, `recorded` is as in `load_lab`."""
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
        _check_keys(root, name)
        data = yaml.safe_load(text)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 0
        raise LabFileError(name, [LabProblem(line, "", f"not YAML: {error.problem or error}")]) from error
    except RecursionError as error:
        raise LabFileError(name, [LabProblem(0, "", "nested too deeply for a lab file")]) from error
    except (yaml.YAMLError, ValueError) as error:  # ValueError: a date such as 2001-99-99
        raise LabFileError(name, [LabProblem(0, "", f"not YAML: {error}")]) from error
    if not isinstance(data, dict):
        raise LabFileError(name, [LabProblem(1, "", "a lab file is a mapping with name, areas, cameras, ...")])
    collected: list[tuple[Location, str]] = []
    try:
        lab = Lab.model_validate(data, context={"problems": collected, "recorded": recorded})
    except ValidationError as error:
        found = [(_location(item["loc"], root), _sentence(item)) for item in error.errors(include_url=False)]
        raise LabFileError(name, _with_lines(found, root)) from error
    if collected:
        raise LabFileError(name, _with_lines(collected, root))
    return lab


def _sentence(item: Any) -> str:
    kind, message = str(item["type"]), str(item["msg"])
    if kind == "extra_forbidden":
        return "unknown key"
    if kind == "missing":
        return "missing"
    given = item.get("input")
    shown = f" (got {given!r})" if isinstance(given, str | int | float | bool) else ""
    return message.removeprefix("Value error, ") + shown


def _location(loc: tuple[str | int, ...], root: yaml.Node | None) -> Location:
    """Pydantic adds names of union branches and "[key]" to a location; only what the document has is kept, and the last
    part, which a missing key needs."""
    kept: list[str | int] = []
    node = root
    for position, part in enumerate(loc):
        child = _child(node, part)
        if child is None and position < len(loc) - 1:
            continue
        if part == "[key]":
            continue
        kept.append(part)
        node = child
    return tuple(kept)


def _with_lines(found: list[tuple[Location, str]], root: yaml.Node | None) -> list[LabProblem]:
    problems = [LabProblem(_line(location, root), _dotted(location, root), what) for location, what in found]
    return sorted(set(problems), key=lambda problem: (problem.line, problem.where))


def _dotted(location: Location, root: yaml.Node | None) -> str:
    """As people write it: `cameras[0].width`; a number that is a mapping's key is a name like any other."""
    text, node = "", root
    for part in location:
        is_index = isinstance(part, int) and not isinstance(node, yaml.MappingNode)
        text += f"[{part}]" if is_index else f".{part}" if text else str(part)
        node = _child(node, part)
    return text


def _line(location: Location, root: yaml.Node | None) -> int:
    """The line of the deepest node on the way to `location` that the document has; of the key, not its value."""
    node, line = root, 1
    for part in location:
        if isinstance(node, yaml.MappingNode):
            key = next((k for k, _ in _pairs(node) if _key(k) == str(part)), None)
            if key is not None:
                line = key.start_mark.line + 1
        child = _child(node, part)
        if child is None:
            break
        if not isinstance(node, yaml.MappingNode):
            line = child.start_mark.line + 1
        node = child
    return line


def _child(node: yaml.Node | None, part: str | int) -> yaml.Node | None:
    if isinstance(node, yaml.MappingNode):
        return next((value for key, value in _pairs(node) if _key(key) == str(part)), None)
    if isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
        return node.value[part]
    return None


def _pairs(node: yaml.MappingNode) -> Iterator[tuple[yaml.Node, yaml.Node]]:
    """A mapping's own keys and values, then those that it takes over by `<<`."""
    merged: list[yaml.Node] = []
    for key, value in node.value:
        if _key(key) == _MERGE:
            merged.extend(value.value if isinstance(value, yaml.SequenceNode) else [value])
        else:
            yield key, value
    for source in merged:
        if isinstance(source, yaml.MappingNode):
            yield from _pairs(source)


def _key(node: yaml.Node) -> str:
    return str(node.value) if isinstance(node, yaml.ScalarNode) else ""


def _check_keys(node: yaml.Node | None, name: str, path: tuple[int, ...] = (), seen: set[int] | None = None) -> None:
    """YAML keeps the last of two equal keys in silence; here that is an error, as is a part that contains itself. Parts
    used several times by anchors are looked at once."""
    checked = set[int]() if seen is None else seen
    if node is None or isinstance(node, yaml.ScalarNode):
        return
    line = node.start_mark.line + 1
    if id(node) in path:
        raise LabFileError(name, [LabProblem(line, "", "an anchor that contains itself")])
    if id(node) in checked:
        return
    if len(path) >= _DEEPEST:
        raise LabFileError(name, [LabProblem(line, "", "nested too deeply for a lab file")])
    inner = (*path, id(node))
    if isinstance(node, yaml.MappingNode):
        lines: dict[str, int] = {}
        for key, value in node.value:
            text, line = _key(key), key.start_mark.line + 1
            if text in lines:
                raise LabFileError(name, [LabProblem(line, text, f"key given twice (first on line {lines[text]})")])
            lines[text] = line
            _check_keys(value, name, inner, checked)
    elif isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _check_keys(item, name, inner, checked)
    checked.add(id(node))
