"""What the agent's requests have in common: one client with the robot's token, and sentences for what goes wrong."""

import httpx

TIMEOUT_S = 2.0
SLOW_RETRY_S = 5.0
"""After an answer that will be the same in a moment: the token is wrong or the server does not know the robot."""


def make_client(server_url: str, token: str) -> httpx.AsyncClient:
    """For the whole life of the agent. Proxies of the environment are left out: the server is on the robot's own network."""
    return httpx.AsyncClient(
        base_url=server_url,
        headers={"Authorization": f"Bearer {token}"},
        timeout=TIMEOUT_S,
        trust_env=False,
    )


def is_hopeless(status: int) -> bool:
    """Whether asking again soon is pointless."""
    return status in (401, 403, 404)


def sentence(error: Exception) -> str:
    """What went wrong, for the log."""
    if not isinstance(error, httpx.HTTPStatusError):
        return str(error) or type(error).__name__
    match error.response.status_code:
        case 401:
            return "the server does not know the token (401); make one with ./lilliput token and set LILLIPUT_TOKEN"
        case 403:
            return "the token is not this robot's (403); it needs the role robot, bound to this vehicle"
        case 404:
            return "the server does not know this vehicle (404); do both use the same lab file?"
        case status:
            return f"the server answered {status}"
