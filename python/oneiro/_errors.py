"""The exceptions: one for each exit code of the program, with the program's messages."""


class Error(Exception):
    """Anything that Oneiro refuses or fails to do."""

    code = 1


class FailedError(Error):
    """A run, a check or a comparison failed."""

    code = 1


class InputError(Error, ValueError):
    """An experiment, a file or an argument is invalid: the message names the place, the problem and what is allowed."""

    code = 3


class DeviceError(Error):
    """There is no such device, or it can't run the kernels."""

    code = 4


class CorruptError(Error):
    """Recorded data are not what was written."""

    code = 5


class StorageError(Error, OSError):
    """The disk is full, or reading or writing failed."""

    code = 6


class ShortMemoryError(Error, MemoryError):
    """There is not enough memory, or no thread can be started."""

    code = 7


class BrokenError(Error):
    """A mistake in Oneiro, which the message asks you to report."""

    code = 70


class StoppedError(Error):
    """The work was stopped; the message says how to go on."""

    code = 75


_CLASSES = {
    1: FailedError,
    2: InputError,
    3: InputError,
    4: DeviceError,
    5: CorruptError,
    6: StorageError,
    7: ShortMemoryError,
    70: BrokenError,
    75: StoppedError,
}


def of(code: int, message: str) -> Error:
    """The exception for an exit code."""
    return _CLASSES.get(code, Error)(message)
