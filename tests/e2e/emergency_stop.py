"""The emergency stop while two robots drive, as the browser test tries it and the benchmark times it."""

from playwright.sync_api import expect

from tests.e2e.browser import Console
from tests.e2e.system import RunningSystem, wait_for

SPEED_MPS = 0.3
_ENDS = {"wifibot-14": ((1.2, 2.2), (3.4, 2.2)), "turtlebot-16": ((4.8, 1.0), (6.8, 1.0))}


def drive_to_and_fro(system: RunningSystem) -> tuple[str, str]:
    """Sends two robots on endless routes, and returns their names when both have their speed."""
    for robot, ends in _ENDS.items():
        for number, (x, y) in enumerate(ends):
            body = {"id": f"stop-{robot}-{number}", "area": "camp", "x": x, "y": y, "radius_m": 0.2}
            system.api.put(f"/waypoints/{body['id']}", json=body).raise_for_status()
        legs = [{"waypoint": f"stop-{robot}-{number}", "speed_mps": SPEED_MPS} for number in range(2)]
        system.api.put(f"/routes/to-{robot}", json={"id": f"to-{robot}", "legs": legs, "loop": True}).raise_for_status()
        system.api.put(f"/robots/{robot}/assignment", json={"route": f"to-{robot}"}).raise_for_status()
    wait_until_both_drive(system)
    first, second = _ENDS
    return first, second


def wait_until_both_drive(system: RunningSystem) -> None:
    wait_for("both drive", lambda: all(abs(system.truth(name).linear_mps) > 0.8 * SPEED_MPS for name in _ENDS), 30)


def press_emergency_stop(operator: Console) -> float:
    """When the browser felt the press, nanoseconds since the epoch; the console shows the floor."""
    operator.page.evaluate(
        "window.addEventListener('pointerdown', () => { window.pressedAt = performance.timeOrigin + performance.now() },"
        " {capture: true, once: true})"
    )
    operator.part("estop-engage").click()
    return float(operator.page.evaluate("window.pressedAt")) * 1e6


def release_emergency_stop(operator: Console) -> None:
    operator.part("estop-release").click()
    operator.part("estop-release-confirm").click()
    expect(operator.part("estop-banner")).to_be_hidden()
