"""The launcher's errors: each is one line that says what to do, and carries the exit status."""


class LauncherError(Exception):
    """Something went wrong that the person at the terminal can mend."""

    exit_status = 1


class UsageError(LauncherError):
    """The command was used in a way that cannot work."""

    exit_status = 2
