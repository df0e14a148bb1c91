"""What can go wrong; the texts are those of the command line."""

from __future__ import annotations


class ParRayError(Exception):
    """Any of the errors below."""


class InputError(ParRayError, ValueError):
    """What was asked for cannot be done: the text says where it is wrong, and the remedy (status 2 of `parray`)."""


class RenderError(ParRayError, RuntimeError):
    """It was tried and failed (status 1): a job that failed or was cancelled, a farm that does not answer."""


class Interrupted(ParRayError):
    """The program was interrupted by somebody else than this process (status 130)."""


class ProgramNotFound(ParRayError, FileNotFoundError):
    """There is no program `parray` on this machine, or not where PARRAY_BIN says."""


class ParRayWarning(UserWarning):
    """What the program says on the way to a picture, such as that a scene has duplicates."""
