"""An operator calibrates the running lab in the browser: look, collect, compare, accept, undo; robots are followed all the
while, and what came into force is as good as the truth allows."""

import math
from collections.abc import Generator
from typing import Any, cast

import pytest
from playwright.sync_api import expect

from protocol import keys
from protocol.channels import POSES
from protocol.codec import decode
from protocol.messages import TrackedPose
from tests.e2e.browser import Console, console
from tests.e2e.system import RunningSystem, wait_for

ROBOT = "wifibot-14"
CAMERAS = ("cam0", "cam1", "cam2", "cam3")
NEAR_M = 0.02


@pytest.fixture
def operator(system: RunningSystem) -> Generator[Console]:
    with console(system) as running:
        yield running


def state(system: RunningSystem) -> dict[str, Any]:
    return cast("dict[str, Any]", system.get("/calibration"))


def pose(system: RunningSystem, since_ns: int = 0) -> TrackedPose | None:
    raw = cast("bytes | None", system.redis.hget(keys.live(POSES.name), ROBOT))
    found = None if raw is None else decode(TrackedPose, raw)
    return found if found is not None and found.stamp_ns > since_ns else None


def off_m(system: RunningSystem, since_ns: int) -> float:
    """How far from the truth the robot, standing, is seen to be, by a frame after `since_ns`."""
    seen = wait_for("a pose", lambda: pose(system, since_ns))
    truth = system.truth(ROBOT)
    return math.dist((seen.x, seen.y), (truth.x, truth.y))


def extrinsics_ns(system: RunningSystem) -> set[int]:
    """Since when the cameras use what they use."""
    return {camera["extrinsics"]["stamp_ns"] for camera in system.get("/cameras")}


def test_a_calibration_is_started_compared_accepted_and_undone(system: RunningSystem, operator: Console) -> None:
    first = wait_for("the first calibration, made by itself", lambda: state(system)["current"], 60)
    assert set(first["cameras"]) == set(CAMERAS)
    assert first["by"] == "calibrator"
    stood = system.truth(ROBOT)
    assert abs(stood.linear_mps) < 1e-3
    assert off_m(system, 0) < NEAR_M

    operator.open("cameras")
    operator.page.get_by_role("link", name="Calibrate", exact=True).click()
    expect(operator.part("calibration-stage")).to_have_attribute("data-stage", "look")
    expect(operator.part("calibration-look-cam2")).to_contain_text("Sees floor tags 4, 5, 6, 7")
    operator.page.wait_for_function(
        "() => (document.querySelector(`[data-testid='preview-cam3']`)?.width ?? 0) > 300"  # a picture is painted
    )
    operator.screenshot("calibration")

    operator.part("calibration-start").click()
    expect(operator.part("calibration-stage")).to_have_attribute("data-stage", "compare", timeout=60_000)
    proposal = state(system)["proposal"]
    assert proposal["not_answered"] == []
    for camera in CAMERAS:
        expect(operator.part(f"calibration-camera-{camera}")).to_be_visible()
        compared = proposal["cameras"][camera]
        assert compared["is_new"]
        assert compared["reprojection_after_px"] < 1.0
        assert compared["floor_shift_max_m"] < 0.01, "nothing has moved"
    operator.screenshot("calibration-compare")
    assert state(system)["current"] == first, "nothing changes before somebody accepts"

    operator.part("calibration-accept").click()
    expect(operator.part("calibration-in-force")).to_have_attribute("data-id", str(proposal["calibration"]["id"]))
    accepted = state(system)["current"]
    assert accepted["by"] == "admin"
    wait_for("all cameras use it", lambda: extrinsics_ns(system) == {accepted["stamp_ns"]}, 10)
    assert off_m(system, accepted["stamp_ns"] + 1_000_000_000) < NEAR_M, "poses go on, and are right"

    operator.part("calibration-restore").click()
    expect(operator.part("calibration-in-force")).to_have_attribute("data-id", str(first["id"]))
    restored = state(system)["current"]
    assert restored["cameras"] == first["cameras"]
    wait_for("all cameras use it", lambda: extrinsics_ns(system) == {restored["stamp_ns"]}, 10)
    assert off_m(system, restored["stamp_ns"] + 1_000_000_000) < NEAR_M

    kinds = [event["kind"] for event in system.get("/events?count=1000")]
    assert [kind for kind in kinds if kind.startswith("calibration")][-5:] == [
        "calibration_refined",
        "calibration_started",
        "calibration_proposed",
        "calibration_accepted",
        "calibration_restored",
    ]


def test_a_proposal_can_be_discarded_by_keyboard(system: RunningSystem, operator: Console) -> None:
    before = wait_for("a calibration", lambda: state(system)["current"], 60)
    operator.open("calibration")
    operator.page.get_by_label("cam0", exact=True).uncheck()
    operator.page.get_by_label("cam1", exact=True).uncheck()
    start = operator.part("calibration-start")
    expect(start).to_have_text("Calibrate 2 cameras")
    start.focus()
    operator.page.keyboard.press("Enter")
    expect(operator.part("calibration-stage")).to_have_attribute("data-stage", "compare", timeout=60_000)
    proposal = state(system)["proposal"]
    assert [camera for camera, compared in proposal["cameras"].items() if compared["is_new"]] == ["cam2", "cam3"]
    operator.page.set_viewport_size({"width": 390, "height": 844})
    expect(operator.part("calibration-accept")).to_be_in_viewport()
    assert operator.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"), "a phone suffices"
    operator.screenshot("calibration-phone")
    operator.part("calibration-discard").focus()
    operator.page.keyboard.press("Enter")
    expect(operator.part("calibration-stage")).to_have_attribute("data-stage", "look")
    assert state(system)["current"] == before
    assert state(system)["run"]["state"] == "discarded"


def test_a_camera_that_is_bumped_is_refined_with_the_others_by_itself(system: RunningSystem) -> None:
    before = wait_for("a calibration", lambda: state(system)["current"], 60)
    system.api.put("/sim/cameras/cam2/fault", json={"kind": "bump", "shift_x_m": 0.02}).raise_for_status()
    after = wait_for("another calibration", lambda: newer(system, before), 40)
    assert after["by"] == "calibrator"
    assert state(system)["previous"] == before
    assert moved_m(before, after, "cam2") == pytest.approx(0.02, abs=0.008)
    assert all(moved_m(before, after, camera) < 0.008 for camera in CAMERAS if camera != "cam2")
    events = system.get("/events?count=1000")
    assert any(e["kind"] == "camera_not_calibrated" and "cam2: the camera moved" in e["text"] for e in events)
    wait_for("all cameras use it", lambda: extrinsics_ns(system) == {after["stamp_ns"]}, 10)

    system.api.delete("/sim/cameras/cam2/fault").raise_for_status()
    back = wait_for("it is found back", lambda: newer(system, after), 40)
    assert moved_m(before, back, "cam2") < 0.008
    wait_for("all is well", lambda: system.get("/health")["state"] == "ok", 20)


def newer(system: RunningSystem, than: dict[str, Any]) -> dict[str, Any] | None:
    """What is in force, once it is another."""
    current = cast("dict[str, Any]", state(system)["current"])
    return current if current["id"] != than["id"] else None


def moved_m(before: dict[str, Any], after: dict[str, Any], camera: str) -> float:
    return math.dist(before["cameras"][camera]["translation"], after["cameras"][camera]["translation"])
