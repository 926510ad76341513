"""A camera's address as it may be shown and logged."""

from urllib.parse import urlsplit, urlunsplit


def without_password(source: str | int) -> str:
    """The source; URLs lose their user and password."""
    text = str(source)
    try:
        parts = urlsplit(text)
    except ValueError:
        return text.rpartition("@")[2]
    if "@" not in parts.netloc:
        return text
    return urlunsplit(parts._replace(netloc=parts.netloc.rpartition("@")[2]))
