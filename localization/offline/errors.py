"""What can be wrong with a recording or with where its poses should go."""


class OfflineError(Exception):
    """Base of the errors of this package; the text names the file or folder and says what is wrong with it."""


class RecordingError(OfflineError):
    """A recording that cannot be used."""


class CalibrationFileError(OfflineError):
    """A calibration file that cannot be used."""


class NotCalibratedError(OfflineError):
    """No camera of the recording finds its place."""


class OutputFolderError(OfflineError):
    """A folder that results cannot be written to."""
