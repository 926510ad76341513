"""An operator's first hour, in a real browser on the real system: waypoints, a route, a pallet in the way, the emergency stop
over a restart of the server, driving by hand, every page. Where robots are is judged by the simulated truth."""

import math
import os
import signal
import time
from collections.abc import Generator
from functools import partial

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect
from shapely.geometry import Point, Polygon, box

from geometry import SE2
from lab.objects import PALLET_LENGTH_M, PALLET_WIDTH_M
from protocol.lab import load_lab
from tests.e2e.browser import SLOW_MS, Console, console
from tests.e2e.emergency_stop import drive_to_and_fro, press_emergency_stop, release_emergency_stop
from tests.e2e.odyssey import Odyssey
from tests.e2e.system import ROOT, RunningSystem, wait_for

ROBOT = "wifibot-14"
ROUTE = [(1.5, 1.0), (3.6, 1.0), (3.6, 2.2)]
PALLET = (3.0, 1.0)
"""More than a metre ahead of the robot when it has passed the first waypoint: a browser takes a second or two to put it there."""
FOOTPRINT = Polygon(load_lab(ROOT / "labs/gulliver.yaml").vehicle(ROBOT).footprint)


@pytest.fixture(scope="module")
def operator(system: RunningSystem) -> Generator[Console]:
    for robot in ("wifibot-14", "turtlebot-16"):  # what other tests left
        system.api.delete(f"/robots/{robot}/assignment")
    with console(system) as running:
        yield running


def footprint(system: RunningSystem) -> Polygon:
    pose = system.truth(ROBOT)
    return Polygon(SE2(pose.x, pose.y, pose.yaw).apply(np.array(FOOTPRINT.exterior.coords)))


def reason(system: RunningSystem) -> str:
    found = system.robot(ROBOT)["reason"]
    return found["code"] if found else ""


def red_pixels(picture: str | os.PathLike[str], corners: list[tuple[float, float]]) -> int:
    """How many clearly red pixels the rectangle between two corners (page pixels) has."""
    (x0, y0), (x1, y1) = corners
    crop = (
        Image.open(picture)
        .convert("RGB")
        .crop((int(min(x0, x1)), int(min(y0, y1)), int(max(x0, x1)), int(max(y0, y1))))
    )
    red, green, blue = np.moveaxis(np.asarray(crop).astype(int), 2, 0)
    return int(((red > 90) & (red > 1.5 * green) & (red > 1.5 * blue)).sum())


def bring_to_start(system: RunningSystem) -> None:
    """The robot to (1, 1), wherever earlier tests left it and whatever it was doing."""
    system.api.delete(f"/robots/{ROBOT}/assignment")  # 409 when it did nothing
    body = {"id": "home", "area": "camp", "x": 1.0, "y": 1.0, "radius_m": 0.15, "yaw": 0.0}
    system.api.put("/waypoints/home", json=body).raise_for_status()
    system.api.put(
        "/routes/home", json={"id": "home", "legs": [{"waypoint": "home", "speed_mps": 0.6}]}
    ).raise_for_status()
    system.api.put(f"/robots/{ROBOT}/assignment", json={"route": "home"}).raise_for_status()
    wait_for("the robot is home", lambda: system.robot(ROBOT)["assignment"]["state"] == "done", 90)


def test_a_route_is_placed_driven_blocked_and_finished(system: RunningSystem, operator: Console) -> None:
    bring_to_start(system)
    known = {waypoint["id"] for waypoint in system.api.get("/waypoints").json()}
    operator.open("floor")
    operator.part("place-waypoints").click()
    for x, y in ROUTE:
        operator.click_floor(x, y)
    wait_for("three waypoints", lambda: len(system.api.get("/waypoints").json()) == len(known) + 3)
    operator.part("place-waypoints").click()
    placed = {w["id"]: w for w in system.api.get("/waypoints").json() if w["id"] not in known}
    ordered = [
        min(placed, key=lambda name: math.dist(point, (placed[name]["x"], placed[name]["y"]))) for point in ROUTE
    ]
    assert all(math.dist(p, (placed[n]["x"], placed[n]["y"])) < 0.03 for p, n in zip(ROUTE, ordered, strict=True))

    operator.open("routes")
    operator.part("route-new").click()
    operator.part("route-id").fill("rounds")
    for name in ordered:
        operator.part("route-add-waypoint").click()
        operator.page.get_by_role("option", name=name, exact=True).click()
    operator.screenshot("routes")
    operator.part("route-save").click()
    wait_for("the route", lambda: any(route["id"] == "rounds" for route in system.api.get("/routes").json()))

    # It is to stand before the pallet for as long as that is looked at.
    system.api.put(f"/robots/{ROBOT}/settings", json={"detour_after_s": 60.0}).raise_for_status()
    operator.open("floor")
    with Odyssey(system) as odyssey:
        operator.start_route(ROBOT, "rounds")
        wait_for("the first waypoint is passed", lambda: system.robot(ROBOT)["assignment"]["leg"] == 1, 40)
        operator.click_floor(*PALLET, right=True)
        operator.part("menu-add-pallet").click()
        pallet = box(
            PALLET[0] - PALLET_LENGTH_M / 2,
            PALLET[1] - PALLET_WIDTH_M / 2,
            PALLET[0] + PALLET_LENGTH_M / 2,
            PALLET[1] + PALLET_WIDTH_M / 2,
        )
        wait_for("it waits for the obstacle", lambda: reason(system) == "obstacle", 30)
        wait_for("it stands", lambda: abs(system.truth(ROBOT).linear_mps) < 1e-3, 5)
        gap_m = footprint(system).distance(pallet)
        assert gap_m >= 0.3
        expect(operator.part(f"robot-{ROBOT}")).to_have_attribute("data-state", "waiting")
        front_x = max(x for x, _ in footprint(system).exterior.coords)
        lane = [operator.at(front_x + 0.08, 1.1), operator.at(pallet.bounds[0] - 0.08, 0.9)]
        assert red_pixels(operator.screenshot("blocked"), lane) > 50
        stood = system.truth(ROBOT)
        waited_from = time.monotonic()
        while time.monotonic() - waited_from < 2.0:
            assert math.dist((stood.x, stood.y), (system.truth(ROBOT).x, system.truth(ROBOT).y)) < 0.005
        operator.click_floor(*PALLET, right=True)
        operator.part("menu-remove-object").click()
        wait_for("it drives on", lambda: abs(system.truth(ROBOT).linear_mps) > 0.1, 10)
        assert red_pixels(operator.screenshot("floor"), lane) < 50
        wait_for("the route is done", lambda: system.robot(ROBOT)["assignment"]["state"] == "done", 60)
    for name in ordered:
        waypoint = placed[name]
        assert odyssey.nearest_m(ROBOT, (waypoint["x"], waypoint["y"])) <= waypoint["radius_m"]
    assert Point(system.truth(ROBOT).x, system.truth(ROBOT).y).distance(Point(*ROUTE[-1])) <= 0.15 + 0.03
    assert odyssey.truths[-1].contacts == 0


@pytest.fixture
def tours(system: RunningSystem) -> Generator[tuple[str, str]]:
    """Two robots that drive to and fro."""
    names = drive_to_and_fro(system)
    yield names
    if system.get("/estop")["engaged"]:
        system.api.request("DELETE", "/estop", json={"confirm": True}).raise_for_status()
    for robot in names:
        system.api.delete(f"/robots/{robot}/assignment")


def test_the_emergency_stop_halts_all_at_once_and_outlives_the_server(
    system: RunningSystem, operator: Console, tours: tuple[str, str]
) -> None:
    """How soon they stand is measured by `./lilliput bench stop`."""
    operator.open("floor")
    with Odyssey(system) as odyssey:
        pressed_ns = press_emergency_stop(operator)
        wait_for("all stand", partial(odyssey.all_stand_since, pressed_ns, tours), 5)
    assert {system.robot(robot)["status"]["stopped_by"]["code"] for robot in tours} == {"emergency_stop"}
    expect(operator.part("estop-banner")).to_be_visible()
    operator.screenshot("emergency-stop")

    where = {robot: system.truth(robot) for robot in tours}
    server = system.processes()["server"]
    assert server.pid is not None
    os.kill(server.pid, signal.SIGKILL)
    wait_for("the server is back", lambda: system.processes()["server"].pid not in (None, server.pid))
    expect(operator.part("connection")).to_have_attribute("data-state", "live")
    assert system.get("/estop")["engaged"] is True
    expect(operator.part("estop-banner")).to_be_visible()
    assert all(abs(system.truth(robot).linear_mps) < 1e-3 for robot in tours)
    for robot, before in where.items():
        after = system.truth(robot)
        assert math.dist((before.x, before.y), (after.x, after.y)) < 0.01
    refused = system.api.put("/robots/wifibot-15/assignment", json={"route": f"to-{tours[0]}"})
    assert refused.status_code == 409

    release_emergency_stop(operator)
    wait_for("both drive again", lambda: all(abs(system.truth(robot).linear_mps) > 0.1 for robot in tours), 20)


def test_the_stick_drives_the_robot_and_hands_it_back(system: RunningSystem, operator: Console) -> None:
    bring_to_start(system)
    for number, (x, y) in enumerate([(2.4, 1.0), (1.0, 1.0)]):
        body = {"id": f"stick-{number}", "area": "camp", "x": x, "y": y}
        system.api.put(f"/waypoints/stick-{number}", json=body).raise_for_status()
    legs = [{"waypoint": f"stick-{number}", "speed_mps": 0.3} for number in range(2)]
    system.api.put("/routes/stick", json={"id": "stick", "legs": legs}).raise_for_status()
    system.api.put(f"/robots/{ROBOT}/assignment", json={"route": "stick"}).raise_for_status()
    wait_for("it drives its route", lambda: abs(system.truth(ROBOT).linear_mps) > 0.1, 20)
    operator.open("floor")
    operator.select(ROBOT)
    stick = operator.part("stick")
    stick.hover()  # waits until the panel has come to rest
    place = stick.bounding_box()
    assert place is not None
    x, y = place["x"] + place["width"] / 2, place["y"] + place["height"] / 2
    operator.page.mouse.move(x, y)
    operator.page.mouse.down()
    operator.page.mouse.move(x - place["width"] / 2, y, steps=4)  # full left: turn on the spot, as no route would
    wait_for("it turns by hand", lambda: system.truth(ROBOT).angular_radps > 0.3, 10)
    assert system.robot(ROBOT)["reason"]["code"] == "manual"
    turned_from = system.truth(ROBOT).yaw
    wait_for("it has turned", lambda: abs(SE2(0, 0, system.truth(ROBOT).yaw - turned_from).yaw) > 0.3, 10)
    operator.screenshot("manual")
    operator.page.mouse.up()
    wait_for("the route has it again", lambda: system.robot(ROBOT)["state"] == "driving", 10)
    assert system.robot(ROBOT)["manual"] is None
    wait_for("the route is done", lambda: system.robot(ROBOT)["assignment"]["state"] == "done", 90)


def test_every_page_shows_what_it_is_for(system: RunningSystem, operator: Console) -> None:
    operator.open("cameras")
    for camera in ("cam0", "cam1", "cam2", "cam3"):
        expect(operator.part(f"camera-{camera}")).to_have_attribute("data-ok", "true")
        operator.page.wait_for_function(
            # a canvas is 300 pixels wide until a picture is painted
            "id => (document.querySelector(`[data-testid='preview-${id}']`)?.width ?? 0) > 300",
            arg=camera,
        )
    operator.screenshot("cameras")
    operator.open("system")
    expect(operator.part("processes")).to_contain_text("camera-cam3")
    operator.screenshot("system")
    operator.open("events")
    expect(operator.part("events")).to_contain_text("wifibot-14")
    operator.screenshot("events")
    operator.open("admin")
    expect(operator.part("users")).to_contain_text("admin")
    operator.screenshot("admin")
    operator.open("3d")
    frame = operator.page.frame_locator("[data-testid='scene-frame']")
    expect(frame.locator("canvas").first).to_be_visible(timeout=3 * SLOW_MS)
    expect(operator.part("scene")).to_have_attribute("data-state", "alive", timeout=3 * SLOW_MS)
    operator.screenshot("scene")


def test_a_fault_is_tried_on_a_camera_and_taken_back(operator: Console) -> None:
    operator.open("cameras")
    card = operator.part("camera-cam3")
    expect(card).to_have_attribute("data-ok", "true", timeout=SLOW_MS)
    operator.part("try-fault-cam3").click()
    operator.part("fault-unplug").click()
    expect(card).to_have_attribute("data-ok", "false", timeout=SLOW_MS)
    expect(card).to_contain_text("the simulated lab gives no frames", timeout=SLOW_MS)
    operator.screenshot("fault")
    operator.part("end-fault-cam3").click()
    expect(card).to_have_attribute("data-ok", "true", timeout=SLOW_MS)
    expect(operator.part("try-fault-cam3")).to_be_visible()
