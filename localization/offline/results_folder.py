"""A folder of results that is whole or not there: written aside and moved into place; nobody else's file is replaced.

`report.json`, which names all files, comes last. By it an earlier run's files are known and replaced.
"""

import errno
import json
import os
import shutil
from collections.abc import Collection, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from localization.offline.errors import OutputFolderError

REPORT_FILE = "report.json"
_MADE_BY = "lilliput localize"
_DISK_SAYS_NO = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS})
"""What only writing fails with, and nothing but the results is written meanwhile."""


class ResultsFolder:
    """A context manager: files are written into `draft`, `commit` moves them to `path`. Without it nothing changes.

    `names` are the files that may come. OutputFolderError when one of them exists and is not an earlier result, and when the
    disk takes no more.
    """

    def __init__(self, path: Path, names: Collection[str]) -> None:
        self._path = path
        self._earlier = _files_of_earlier_run(path)
        if path.exists() and not path.is_dir():
            raise OutputFolderError(f"{path} is not a folder")
        strangers = sorted(n for n in {*names, REPORT_FILE} if (path / n).exists() and n not in self._earlier)
        if strangers:
            raise OutputFolderError(
                f"{path} holds {', '.join(strangers)} from elsewhere; choose another folder or move them away"
            )
        self._is_new = not path.exists()
        self.draft = path / f".draft-{os.getpid()}"

    def __enter__(self) -> "ResultsFolder":
        try:
            self.draft.mkdir(parents=True)
        except OSError as error:
            raise OutputFolderError(f"{self._path} cannot be written to: {error.strerror}") from error
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._clean_up()
        if isinstance(error, OSError) and error.errno in _DISK_SAYS_NO:
            raise OutputFolderError(f"{self._path} cannot be written to: {error.strerror}") from error

    def _clean_up(self) -> None:
        shutil.rmtree(self.draft, ignore_errors=True)
        if self._is_new and self._path.is_dir() and not any(self._path.iterdir()):
            self._path.rmdir()

    def commit(self, report: Mapping[str, Any]) -> None:
        """Moves everything into place and removes what an earlier run left that this one does not have."""
        files = {*(file.name for file in self.draft.iterdir()), REPORT_FILE}
        # Should the machine stop in between, the next run must know that what lies there then is ours.
        self._put_report({"files": sorted(files | self._earlier)})
        for name in files - {REPORT_FILE}:
            (self.draft / name).replace(self._path / name)
        for name in self._earlier - files:
            (self._path / name).unlink(missing_ok=True)
        self._put_report({"files": sorted(files), **report})

    def _put_report(self, content: Mapping[str, Any]) -> None:
        text = json.dumps({"made_by": _MADE_BY, **content}, indent=1, allow_nan=False)
        (self.draft / REPORT_FILE).write_text(text + "\n", encoding="utf-8")
        (self.draft / REPORT_FILE).replace(self._path / REPORT_FILE)


def _files_of_earlier_run(path: Path) -> set[str]:
    """Names that an earlier report says it wrote; none when there is no such report."""
    try:
        report = json.loads((path / REPORT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return set()
    if not isinstance(report, dict) or report.get("made_by") != _MADE_BY:
        return set()
    return {name for name in report.get("files", []) if isinstance(name, str) and Path(name).name == name}
