"""The console's API types, generated from the server's OpenAPI description (web/src/api/schema.gen.ts)."""

import subprocess
import tempfile
from pathlib import Path

from launcher.errors import LauncherError
from launcher.output import progress
from launcher.paths import PYTHON, ROOT, WEB
from launcher.web_build import install_packages

GENERATED_TYPES = WEB / "src" / "api" / "schema.gen.ts"


def generate_api_types(output: Path) -> None:
    """Writes the TypeScript types of the server as it is now to `output`; LauncherError when a tool fails."""
    node = install_packages(WEB, progress)
    with tempfile.TemporaryDirectory(prefix="lilliput-openapi-") as folder:
        description = Path(folder) / "openapi.json"
        description.write_text(_output([PYTHON, "-P", "-m", "server.openapi"], ROOT, None))
        output.parent.mkdir(parents=True, exist_ok=True)
        generate = node.npm("run", "--silent", "generate", "--", str(description), "-o", str(output))
        _output(generate, WEB, node.environment())


def _output(argv: list[str], cwd: Path, environment: dict[str, str] | None) -> str:
    done = subprocess.run(argv, cwd=cwd, env=environment, capture_output=True, text=True, errors="replace", check=False)
    if done.returncode != 0:
        raise LauncherError(f"`{' '.join(argv)}` failed:\n{done.stdout}{done.stderr}".rstrip())
    return done.stdout
