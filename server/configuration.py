"""What the service is told at its start, resolved in `main()`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from protocol.lab import Lab
from protocol.settings import Settings


@dataclass(frozen=True, slots=True)
class Configuration:
    """Where to listen, what to serve, and to which port robots send their statuses."""

    host: str
    http_port: int
    udp_port: int
    scene_port: int
    redis_url: str = field(repr=False)
    console: Path
    state: Path = Path(".lilliput")


def configuration(settings: Settings, lab: Lab, environment: Mapping[str, str], console: Path) -> Configuration:
    """From the process settings and the lab's ports; LILLIPUT_HTTP_PORT outranks the lab's. SystemExit when it is no port."""
    text = environment.get("LILLIPUT_HTTP_PORT") or str(lab.ports.http)
    if not text.isascii() or not text.isdigit() or not 0 < int(text) < 65536:
        raise SystemExit(f"LILLIPUT_HTTP_PORT must be a port, not {text!r}")
    return Configuration(
        host=settings.host,
        http_port=int(text),
        udp_port=lab.ports.robots_udp,
        scene_port=lab.ports.scene,
        redis_url=settings.redis_url,
        console=console,
        state=settings.state,
    )
