"""From host names to IPv4 addresses, without holding anything up: a name server that does not answer keeps a thread of its own
waiting, which does not keep the process from ending."""

import asyncio
import contextlib
import ipaddress
import socket
import threading
from collections.abc import Callable
from typing import cast

Lookup = Callable[[str], str]


class UnresolvedHostError(Exception):
    """No IPv4 address is known for a host; the text says why."""


def is_address(host: str) -> bool:
    """Whether this is an IPv4 address in dotted form, which needs no name server."""
    try:
        ipaddress.IPv4Address(host)
    except ValueError:
        return False
    return True


def look_up(host: str) -> str:
    """The host's first IPv4 address; blocks. UnresolvedHostError when there is none."""
    try:
        found = socket.getaddrinfo(host, None, family=socket.AF_INET, type=socket.SOCK_DGRAM)
        return cast("str", found[0][4][0])
    except (OSError, UnicodeError, IndexError) as error:
        raise UnresolvedHostError(f"{host!r} has no IPv4 address: {error}") from error


async def resolve(host: str, lookup: Lookup = look_up) -> str:
    """The host's IPv4 address; UnresolvedHostError when there is none."""
    if is_address(host):
        return host
    loop = asyncio.get_running_loop()
    answer: asyncio.Future[str] = loop.create_future()

    def settle(address: str, problem: UnresolvedHostError | None) -> None:
        if answer.done():  # nobody waits any more
            return
        if problem is None:
            answer.set_result(address)
        else:
            answer.set_exception(problem)

    def work() -> None:
        address, problem = "", None
        try:
            address = lookup(host)
        except UnresolvedHostError as error:
            problem = error
        with contextlib.suppress(RuntimeError):  # the loop has ended meanwhile
            loop.call_soon_threadsafe(settle, address, problem)

    # Not the loop's executor: asyncio waits for its threads at the end, as long as a resolver takes.
    threading.Thread(target=work, name=f"resolve {host}", daemon=True).start()
    return await answer
