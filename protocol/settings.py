"""What every process is told through its environment; built in `main()`, never at import."""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Settings:
    """Resolved settings of one process. Secrets are left out of `repr`, so the whole can be printed at start."""

    lab: Path
    state: Path
    redis_url: str = field(repr=False)
    server_url: str
    host: str
    udp_key: bytes | None = field(repr=False)
    token: str = field(repr=False)
    run: str = ""
    timings_mb: float = 20.0

    @classmethod
    def from_environment(cls, environment: Mapping[str, str] = os.environ, *, needs_redis: bool = True) -> "Settings":
        """LILLIPUT_LAB and, where `needs_redis`, REDIS_URL are needed; LILLIPUT_STATE, LILLIPUT_SERVER, LILLIPUT_HOST (what
        servers bind to), LILLIPUT_UDP_KEY (hex) and LILLIPUT_TOKEN have defaults; so have LILLIPUT_RUN (the name under which
        processes that were started together keep their stage timings) and LILLIPUT_TIMINGS_MB (how much of them each may
        keep, 0 for nothing). SystemExit with a sentence when something is wrong."""
        needed = ("LILLIPUT_LAB", "REDIS_URL") if needs_redis else ("LILLIPUT_LAB",)
        missing = [name for name in needed if not environment.get(name)]
        if missing:
            raise SystemExit(f"set {' and '.join(missing)} in the environment, or start through ./lilliput up")
        key = environment.get("LILLIPUT_UDP_KEY", "")
        try:
            udp_key = bytes.fromhex(key) or None
        except ValueError:
            raise SystemExit("LILLIPUT_UDP_KEY must be hexadecimal digits") from None
        run = environment.get("LILLIPUT_RUN", "")
        if run and not is_run_name(run):
            raise SystemExit(f"LILLIPUT_RUN must be letters, digits, - and _ (it names a folder), not {run!r}")
        return cls(
            lab=Path(environment["LILLIPUT_LAB"]),
            state=Path(environment.get("LILLIPUT_STATE", ".lilliput")),
            redis_url=environment.get("REDIS_URL", ""),
            server_url=environment.get("LILLIPUT_SERVER", "http://127.0.0.1:8000"),
            host=environment.get("LILLIPUT_HOST", "127.0.0.1"),
            udp_key=udp_key,
            token=environment.get("LILLIPUT_TOKEN", ""),
            run=run,
            timings_mb=_megabytes(environment.get("LILLIPUT_TIMINGS_MB") or "20"),
        )


def is_run_name(text: str) -> bool:
    """Whether a run of the system (`protocol.timings`) may be called so: it names a folder."""
    return re.fullmatch(r"[0-9A-Za-z][0-9A-Za-z_-]{0,63}", text) is not None


def _megabytes(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not 0.0 <= number <= 1e6:
        raise SystemExit(f"LILLIPUT_TIMINGS_MB must be a number of megabytes, not {text!r}")
    return number


def frames_folder(state: Path) -> Path:
    """Where the simulated cameras' shared frames lie: in memory where the system has /dev/shm, apart per state folder."""
    shared = Path("/dev/shm")  # noqa: S108  # named by a digest of the private state folder
    if not shared.is_dir() or not os.access(shared, os.W_OK):
        return state / "frames"
    import hashlib

    digest = hashlib.sha256(str(state.resolve()).encode()).hexdigest()[:16]
    return shared / f"lilliput-{os.getuid()}-{digest}"


def frame_ring(state: Path, camera_id: str) -> Path:
    """The ring (`protocol.frames`) through which a simulated camera's frames go."""
    return frames_folder(state) / f"{camera_id}.frames"
