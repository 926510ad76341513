"""Runs a command that the kernel kills when its parent dies: `death_signal.py PARENT_PID NICENESS COMMAND ARGUMENT...`.

Started between the supervisor and each of its children, so that not even `kill -9` of the supervisor leaves an orphan.
The request is made here and not between fork and exec of the supervisor, where running Python is unsafe beside threads;
it survives the exec that follows. Needs nothing but the standard library (it runs isolated, for a quick start).
"""

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1


def main(parent: int, niceness: int, argv: list[str]) -> int:
    """Replaces this process by `argv`, so much nicer than the parent; returns only when that fails."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, int(signal.SIGKILL))
    if os.getppid() != parent:  # it died before the request took effect
        return 1
    if niceness:
        os.nice(niceness)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # Python ignores it, and what is ignored stays so across exec
    try:
        os.execvp(argv[0], argv)  # noqa: S606  # a list, and no shell is wanted
    except OSError as error:
        print(f"cannot start {argv[0]}: {error.strerror}", file=sys.stderr)
        return 127


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]))
