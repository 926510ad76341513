"""Reads a lab file; every problem is named with the line that it stands on."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from protocol.errors import LabFileError, LabProblem
from protocol.lab.description import Lab, Location


def load_lab(path: Path | str) -> Lab:
    """The lab described by the YAML file; LabFileError when it cannot be read, parsed or believed."""
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise LabFileError(str(file), [LabProblem(0, "", f"cannot read the lab file: {error}")]) from error
    return parse_lab(text, str(file))


def parse_lab(text: str, name: str = "lab.yaml") -> Lab:
    """The lab described by YAML text; `name` stands in the messages of LabFileError."""
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
        _refuse_duplicate_keys(root, name)
        data = yaml.safe_load(text)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 0
        raise LabFileError(name, [LabProblem(line, "", f"not YAML: {error.problem or error}")]) from error
    except yaml.YAMLError as error:
        raise LabFileError(name, [LabProblem(0, "", f"not YAML: {error}")]) from error
    if not isinstance(data, dict):
        raise LabFileError(name, [LabProblem(1, "", "a lab file is a mapping with name, areas, cameras, ...")])
    collected: list[tuple[Location, str]] = []
    try:
        lab = Lab.model_validate(data, context={"problems": collected})
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
    problems = [LabProblem(_line(location, root), _dotted(location), what) for location, what in found]
    return sorted(set(problems), key=lambda problem: (problem.line, problem.where))


def _dotted(location: Location) -> str:
    text = ""
    for part in location:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def _line(location: Location, root: yaml.Node | None) -> int:
    """The line of the deepest node on the way to `location` that the document has; of the key, not its value."""
    node, line = root, 1
    for part in location:
        if isinstance(node, yaml.MappingNode):
            key = next((k for k, _ in node.value if _key(k) == str(part)), None)
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
        return next((value for key, value in node.value if _key(key) == str(part)), None)
    if isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
        return node.value[part]
    return None


def _key(node: yaml.Node) -> str:
    return str(node.value) if isinstance(node, yaml.ScalarNode) else ""


def _refuse_duplicate_keys(node: yaml.Node | None, name: str) -> None:
    """YAML keeps the last of two equal keys in silence; here that is an error."""
    if isinstance(node, yaml.MappingNode):
        seen: dict[str, int] = {}
        for key, value in node.value:
            text, line = _key(key), key.start_mark.line + 1
            if text in seen:
                raise LabFileError(name, [LabProblem(line, text, f"key given twice (first on line {seen[text]})")])
            seen[text] = line
            _refuse_duplicate_keys(value, name)
    elif isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _refuse_duplicate_keys(item, name)
