"""Exceptions. Their texts are those of the command line."""

from __future__ import annotations


class ParRayError(Exception):
    """Base class of the errors below."""


class InputError(ParRayError, ValueError):
    """The input is invalid. The text names the place and the remedy (status 2 of `parray`)."""


class RenderError(ParRayError, RuntimeError):
    """The work failed (status 1): a job failed or was cancelled, or a farm does not answer."""


class Interrupted(ParRayError):
    """Another process interrupted the program (status 130)."""


class ProgramNotFound(ParRayError, FileNotFoundError):
    """This machine has no program `parray`, or PARRAY_BIN does not name one."""


class ParRayWarning(UserWarning):
    """A warning of the program during a render, for example about duplicate spheres."""
