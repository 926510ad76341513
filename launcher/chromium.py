"""The browser of the browser tests: Debian's Chromium, installed when missing and allowed."""

import os
import shutil
import subprocess

from launcher.errors import LauncherError
from launcher.output import progress

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PACKAGES = ("chromium", "fonts-liberation")


def find_chromium() -> str | None:
    """The path of an installed Chromium, or None."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


def ensure_chromium() -> str:
    """The path of Chromium, installing it by apt-get as root; LauncherError says what to do when that cannot be."""
    if found := find_chromium():
        return found
    by_hand = f"apt-get install {' '.join(PACKAGES)}"
    if shutil.which("apt-get") is None:
        raise LauncherError("the browser tests need Chromium: install it so that `chromium` is on the PATH")
    if os.geteuid() != 0:
        raise LauncherError(f"the browser tests need Chromium: run `sudo {by_hand}` once, then start again")
    progress(f"installing Chromium for the browser tests ({by_hand})")
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for arguments in (["update"], ["install", "--yes", "--no-install-recommends", *PACKAGES]):
        done = subprocess.run(
            ["apt-get", "--quiet", *arguments],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            check=False,
        )
        if done.returncode != 0 and arguments[0] == "install":  # an unreachable extra source must not stop the install
            raise LauncherError(f"installing Chromium failed; run `{by_hand}` by hand:\n{done.stdout[-2000:]}")
    if found := find_chromium():
        return found
    raise LauncherError(f"`{by_hand}` left no chromium on the PATH")
