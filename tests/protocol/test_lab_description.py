"""The lab file: the shipped one loads, and every mistake is named with the line that it stands on."""

import math
from pathlib import Path

import pytest

from protocol.errors import LabFileError
from protocol.lab import Lab, load_lab, parse_lab

ROOT = Path(__file__).parents[2]

GOOD = """\
name: room
areas:
  - {id: camp, outline: [[0, 0], [4, 0], [4, 3], [0, 3]]}
cameras:
  - &camera
    id: cam0
    area: camp
    source: sim
    width: 640
    height: 480
    rate_hz: 15
    intrinsics: {fx: 500, fy: 500, cx: 320, cy: 240}
  - {<<: *camera, id: cam1}
floor_tags:
  family: tag36h11
  size_m: 0.16
  poses:
    0: [0, 0, 0]
    1: [1, 0, 0]
vehicles:
  - &robot
    id: robot-1
    kind: wifibot
    footprint: [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]
    tag: {id: 14, size_m: 0.16, height_m: 0.3}
  - <<: *robot
    id: robot-2
    tag:
      id: 15
      size_m: 0.16
      height_m: 0.3
zones:
  - id: crossing
    detection_m: 2.0
    subareas:
      ne: [[1, 1], [2, 1], [2, 2]]
simulation:
  mounts:
    cam0: {position: [1, 1, 3]}
    cam1: {position: [3, 1, 3]}
"""


def speed_zone(corners: int, speed_mps: float, radius_m: float = 1.0) -> str:
    """The lab file's section with one zone, a regular polygon, and the line after it."""
    turns = [math.tau * corner / corners for corner in range(corners)]
    outline = ", ".join(f"[{radius_m * math.cos(turn)}, {radius_m * math.sin(turn)}]" for turn in turns)
    return f"speed_zones:\n  - id: bend\n    outline: [{outline}]\n    speed_mps: {speed_mps}\nsimulation:"


def problems_of(text: str) -> list[tuple[int, str, str]]:
    with pytest.raises(LabFileError) as caught:
        parse_lab(text, "room.yaml")
    for problem in caught.value.problems:
        assert f"room.yaml:{problem.line}: " in str(caught.value)
    return [(p.line, p.where, p.what) for p in caught.value.problems]


def line_of(text: str, part: str) -> int:
    """The 1-based line of the only occurrence of `part`."""
    lines = [number for number, line in enumerate(text.splitlines(), 1) if part in line]
    assert len(lines) == 1, (part, lines)
    return lines[0]


def test_the_room_of_the_reports_loads() -> None:
    lab = load_lab(ROOT / "labs" / "gulliver.yaml")
    assert [camera.id for camera in lab.cameras] == ["cam0", "cam1", "cam2", "cam3"]
    assert len(lab.floor_tags.poses) == 10
    assert {vehicle.tag.id for vehicle in lab.vehicles}.isdisjoint(lab.floor_tags.poses)
    assert {zone.id for zone in lab.zones} == {"crossing", "merge", "roundabout"}
    assert lab.has_simulation
    low_x, low_y, high_x, high_y = lab.bounds()
    assert all(low_x < x < high_x and low_y < y < high_y for x, y, _ in lab.floor_tags.poses.values())


def test_recorded_cameras_need_no_simulation() -> None:
    described = GOOD[: GOOD.index("simulation:")]
    assert [what for _, _, what in problems_of(described)] == [
        f"simulated camera 'cam{i}' has no entry in simulation.mounts" for i in (0, 1)
    ]
    assert [camera.source for camera in parse_lab(described, recorded=True).cameras] == ["sim", "sim"]


def test_merge_keys_and_defaults() -> None:
    lab = parse_lab(GOOD)
    assert lab.camera("cam1").width == 640
    assert lab.vehicle("robot-2").footprint == lab.vehicle("robot-1").footprint
    assert lab.vehicle("robot-2").tag.id == 15
    assert lab.ports.http == 8000
    assert lab.camera("cam0").model().distortion == (0, 0, 0, 0, 0)
    area = lab.area_at(1.0, 1.0)
    assert area is not None
    assert area.id == "camp"
    assert lab.area_at(9.0, 9.0) is None
    for missing in (lab.camera, lab.vehicle):
        with pytest.raises(KeyError, match="ghost"):
            missing("ghost")


@pytest.mark.parametrize(
    ("old", "new", "at", "where", "what"),
    [
        ("name: room", "name: room\ncolour: red", "colour", "colour", "unknown key"),
        ("    area: camp", "    area: camp\n    colour: red", "colour", "cameras[0].colour", "unknown key"),
        ("  size_m: 0.16\n  poses", "  size_m: 0.16\n  hue: 1\n  poses", "hue", "floor_tags.hue", "unknown key"),
        ("name: room", "name: Room 1", "name:", "name", "pattern"),
        ("    intrinsics: {fx: 500, fy: 500, cx: 320, cy: 240}\n", "", "&camera", "cameras[0].intrinsics", "missing"),
        ("fx: 500, ", "", "intrinsics", "cameras[0].intrinsics.fx", "missing"),
        ("fx: 500", "fx: -500", "intrinsics", "cameras[0].intrinsics.fx", "greater than 0 (got -500)"),
        ("fx: 500", "fx: .nan", "intrinsics", "cameras[0].intrinsics.fx", "finite"),
        ("    rate_hz: 15", "    rate_hz: fast", "rate_hz", "cameras[0].rate_hz", "(got 'fast')"),
        ("    width: 640", "    width: 0", "width", "cameras[0].width", "greater than 0"),
        (
            "    area: camp",
            "    area: yard",
            "area: yard",
            "cameras[0].area",
            "'yard', which does not exist (areas: camp)",
        ),
        ("id: cam1}", "id: cam0}", "<<: *camera", "cameras[1].id", "'cam0' is used twice in cameras"),
        ("id: robot-2", "id: robot-1  # again", "# again", "vehicles[1].id", "'robot-1' is used twice"),
        ("    cam1: {pos", "    cam9: {pos", "cam9", "simulation.mounts.cam9", "unknown camera 'cam9'"),
        ("position: [3, 1, 3]", "position: [3, 1]", "cam1: {pos", "simulation.mounts.cam1.position", "missing"),
        ("tag: {id: 14,", "tag: {id: 1,", "tag: {id: 1,", "vehicles[0].tag.id", "floor tag 1 and vehicle 'robot-1'"),
        (
            "      id: 15",
            "      id: 14",
            "      id: 14",
            "vehicles[1].tag.id",
            "vehicle 'robot-1' and vehicle 'robot-2'",
        ),
        ("kind: wifibot", "kind: submarine", "submarine", "vehicles[0].kind", "'wifibot'"),
        ("    1: [1, 0, 0]", "    1: [1, 0]", "    1: [1, 0]", "floor_tags.poses.1", "missing"),
        ("    1: [1, 0, 0]", "    one: [1, 0, 0]", "    one:", "floor_tags.poses.one", "integer"),
        ("[4, 3], [0, 3]]", "[0, 3], [4, 3]]", "outline", "areas[0]", "not a simple polygon"),
        ("[2, 1], [2, 2]]", "[2, 1]]", "      ne:", "zones[0].subareas.ne", "at least 3"),
        ("[2, 1], [2, 2]]", "[2, 1], [3, 1]]", "id: crossing", "zones[0]", "sub-area ne is not a simple polygon"),
        ("family: tag36h11", "family: tag16h5", "tag16h5", "floor_tags.family", "tag36h11"),
        ("simulation:", "ports: {http: 8000, scene: 8000}\nsimulation:", "ports", "ports", "cannot share port 8000"),
        ("simulation:", "ports: {http: 0}\nsimulation:", "ports", "ports.http", "greater than 0"),
        ("simulation:", speed_zone(64, 10.1), "speed_mps", "speed_zones[0].speed_mps", "less than or equal to 10"),
        ("simulation:", speed_zone(65, 0.2), "outline: [[1.0", "speed_zones[0].outline", "at most 64"),
        ("simulation:", speed_zone(3, 0.2, 1e10), "outline: [[10000000000.0", "speed_zones[0].outline", "1000000000"),
    ],
)
def test_a_mistake_is_named_with_its_line(old: str, new: str, at: str, where: str, what: str) -> None:
    assert GOOD.count(old) == 1
    text = GOOD.replace(old, new)
    problems = problems_of(text)
    matching = [p for p in problems if p[1].startswith(where) and what in p[2]]
    assert matching, problems
    assert matching[0][0] == line_of(text, at), problems


def test_a_mistake_in_a_merged_mapping_is_named_where_it_stands() -> None:
    text = GOOD.replace("    height: 480", "    height: tall")
    problems = problems_of(text)
    assert {where for _, where, _ in problems} == {"cameras[0].height", "cameras[1].height"}
    # Both cameras take it from the same line.
    assert {line for line, _, _ in problems} == {line_of(text, "height: tall")}


def test_all_mistakes_are_named_at_once_in_the_order_of_their_lines() -> None:
    text = GOOD.replace("fx: 500", "fx: 0").replace("kind: wifibot", "kind: boat").replace("name: room", "name: 5")
    lines = [line for line, _, _ in problems_of(text)]
    assert lines == sorted(lines)
    assert {line_of(text, "name: 5"), line_of(text, "fx: 0"), line_of(text, "boat")} <= set(lines)


def test_clashes_are_found_together() -> None:
    text = GOOD.replace("area: camp", "area: yard").replace("tag: {id: 14,", "tag: {id: 0,")
    found = problems_of(text)
    assert any("yard" in what for _, _, what in found)
    assert any("floor tag 0 and vehicle 'robot-1'" in what for _, _, what in found)


ROS2_CLASHES = [
    ("", "", "robot_1", True),
    ("", "", "robot-3", False),
    ("ros2: {namespace: base}", "ros2: {namespace: base}", "robot-2", True),
    ("ros2: {namespace: base, domain: 1}", "ros2: {namespace: base, domain: 1}", "robot-2", True),
    ("ros2: {namespace: base, domain: 1}", "ros2: {namespace: base, domain: 2}", "robot-2", False),
    ("ros2: {namespace: base}", "ros2: {namespace: base, domain: 2}", "robot-2", True),
    ("ros2: {namespace: robot_2}", "", "robot-2", True),
]


@pytest.mark.parametrize(("first", "second", "id_", "clash"), ROS2_CLASHES)
def test_no_two_vehicles_command_the_same_ros_2_base(first: str, second: str, id_: str, clash: bool) -> None:
    text = GOOD.replace("    id: robot-1\n", f"    id: robot-1\n    driver: ros2\n    {first}\n")
    text = text.replace("    id: robot-2\n", f"    id: {id_}\n    {second or 'ros2: {}'}\n")
    if not clash:
        assert len(parse_lab(text, "room.yaml").vehicles) == 2
        return
    ((line, where, what),) = problems_of(text)
    assert (line, where) == (line_of(text, f"id: {id_}"), "vehicles[1].id")
    assert f"'robot-1' and '{id_}'" in what and "DDS domain" in what


@pytest.mark.parametrize(
    ("old", "new", "line_text", "words"),
    [
        ("    width: 640", "    width: 640\n    width: 641", "width: 641", "key given twice (first on line 9)"),
        ("    0: [0, 0, 0]", "    1: [0, 0, 0]", "    1: [1, 0, 0]", "key given twice"),
        ("zones:", "name: again\nzones:", "name: again", "key given twice (first on line 1)"),
    ],
)
def test_a_key_given_twice_is_refused(old: str, new: str, line_text: str, words: str) -> None:
    text = GOOD.replace(old, new)
    ((line, _, what),) = problems_of(text)
    assert line == line_of(text, line_text)
    assert words in what


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("name: [unclosed", 1, "not YAML"),
        ("name: room\n  areas: 1\n", 2, "not YAML"),
        ("a: b\n\tc: d\n", 2, "not YAML"),
        ("name: room\nareas: *nothing\n", 2, "not YAML"),
        ("name: !!python/object/apply:os.system [ls]\n", 1, "not YAML"),
        ("name: room\nareas: \x00\n", 0, "not YAML"),
        ("name: 2001-99-99\n", 0, "not YAML: month must be in 1..12"),
        ("- a\n- list\n", 1, "a lab file is a mapping"),
        ("", 1, "a lab file is a mapping"),
        ("just words", 1, "a lab file is a mapping"),
        ("name: a\n---\nname: b\n", 2, "not YAML"),
        ("? [a, b]\n: 1\n", 1, "key"),
        ("1: a\nname: room\n", 1, "1 Keys should be strings"),
        ("a: &a [*a]\n", 1, "contains itself"),
        ("a: &a {<<: *a}\n", 1, "contains itself"),
        ("a: " + "[" * 300 + "]" * 300, 1, "nested too deeply"),
        ("a: " + "[" * 3000 + "]" * 3000, 0, "nested too deeply"),
        ("[]: 1\n", 1, "key"),
    ],
)
def test_what_is_no_lab_at_all_says_so(text: str, line: int, words: str) -> None:
    problems = problems_of(text)
    assert any(found == line and words in f"{where} {what}" for found, where, what in problems), problems


def test_anchors_that_multiply_cost_no_time() -> None:
    """Ten levels of ten references each: 10^10 nodes for whoever follows every one."""
    levels = ["l0: &l0 [1]"] + [f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 10)}]" for n in range(1, 11)]
    found = problems_of("\n".join(levels) + "\n")
    assert ("l10", "unknown key") in {(where, what) for _, where, what in found}


def test_a_file_that_cannot_be_read_says_so(tmp_path: Path) -> None:
    with pytest.raises(LabFileError, match=r"none\.yaml:0: cannot read the lab file"):
        load_lab(tmp_path / "none.yaml")
    with pytest.raises(LabFileError, match="cannot read the lab file"):
        load_lab(tmp_path)
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00name")
    with pytest.raises(LabFileError, match="cannot read the lab file"):
        load_lab(str(binary))


def test_a_lab_without_the_loader_raises_too() -> None:
    with pytest.raises(ValueError, match="used twice"):
        Lab.model_validate(
            {
                "name": "room",
                "areas": [{"id": "a", "outline": [[0, 0], [1, 0], [1, 1]]}] * 2,
                "floor_tags": {"size_m": 0.1, "poses": {}},
            }
        )
