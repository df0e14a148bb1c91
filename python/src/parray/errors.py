"""Exceptions. Their texts are messages of `parray`, of the farm, or of this package, all in the same form."""

from __future__ import annotations


class ParRayError(Exception):
    """Base class of the errors below."""


class InputError(ParRayError, ValueError):
    """The input is invalid (status 2 of `parray`). The text names the place and the remedy."""


class RenderError(ParRayError, RuntimeError):
    """The work failed: status 1 of `parray`, or another that is neither 2 nor 130; a job failed or was cancelled; a farm
    refused the request, has no room for it, or does not answer."""


class Interrupted(ParRayError):
    """Another process interrupted the program (status 130). Ctrl-C raises KeyboardInterrupt instead."""


class ProgramNotFound(ParRayError, FileNotFoundError):
    """There is no program `parray`: in the place that PARRAY_BIN names or, without it, in the package and in PATH."""


class ParRayWarning(UserWarning):
    """All lines that a successful render writes beside its result, for example about duplicate spheres."""
