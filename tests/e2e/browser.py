"""The console in a real Chromium, as an operator's hands use it.

Pictures of its pages go to .lilliput/screenshots; those of the documentation are made by
`LILLIPUT_SCREENSHOTS=docs/images ./lilliput test tests/e2e/test_console.py`.
"""

import os
import re
from collections.abc import Generator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Locator, Page, expect, sync_playwright

from tests.e2e.system import ROOT, RunningSystem

CHROMIUM = "/usr/bin/chromium"
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
SCREENSHOTS = Path(os.environ.get("LILLIPUT_SCREENSHOTS", ROOT / ".lilliput" / "screenshots"))
SLOW_MS = 20_000


class Console:
    """An operator at the console of a running system, logged in."""

    def __init__(self, page: Page, url: str) -> None:
        self.page = page
        self.url = url

    def part(self, test_id: str) -> Locator:
        return self.page.get_by_test_id(test_id)

    def log_in(self, user: str, password: str) -> None:
        self.page.goto(self.url)
        self.part("login-user").fill(user)
        self.part("login-password").fill(password)
        self.part("login-submit").click()
        expect(self.part("connection")).to_have_attribute("data-state", "live")

    def open(self, page: str) -> None:
        self.part(f"nav-{page}").click()
        expect(self.page).to_have_url(re.compile(f"/{page}$"))

    def screenshot(self, name: str) -> Path:
        """Writes a picture of the page, in 256 colours so that it is small enough for the documentation."""
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        path = SCREENSHOTS / f"{name}.png"
        Image.open(BytesIO(self.page.screenshot())).convert("RGB").quantize(256).save(path, optimize=True)
        return path

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Where a point of the floor (metres, map frame) is on the page (pixels)."""
        self.page.wait_for_function("window.lilliput !== undefined")
        pixel = self.page.evaluate("([x, y]) => window.lilliput.toPixel(x, y)", [x, y])
        return float(pixel[0]), float(pixel[1])

    def click_floor(self, x: float, y: float, *, right: bool = False) -> None:
        self.page.mouse.click(*self.at(x, y), button="right" if right else "left")

    def select(self, robot: str) -> None:
        self.part(f"robot-{robot}").click()
        expect(self.part("robot-panel")).to_have_attribute("data-robot", robot)

    def start_route(self, robot: str, route: str) -> None:
        self.select(robot)
        self.part("route-select").click()
        self.page.get_by_role("option", name=route, exact=True).click()
        self.part("route-start").click()


@contextmanager
def console(system: RunningSystem) -> Generator[Console]:
    """Opens Chromium, logs in as the admin, and fails on any error that the page's scripts raise."""
    errors: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            page.set_default_timeout(SLOW_MS)
            expect.set_options(timeout=SLOW_MS)
            page.on("pageerror", lambda error: errors.append(str(error)))
            operator = Console(page, system.url)
            operator.log_in("admin", system.password)
            yield operator
        finally:
            browser.close()
    assert errors == []
