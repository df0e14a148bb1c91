"""Renders pictures of spheres by path tracing and states their error. See render() and Farm."""

from .errors import InputError, Interrupted, ParRayError, ParRayWarning, ProgramNotFound, RenderError
from .farm import Farm, Job
from .particles import Particles
from .picture import Error, Picture, Pictures
from .program import find_program, render, render_async
from .progress import Progress
from .srgb import srgb_to_linear

__version__ = "0.2.0"
__all__ = [
    "Error",
    "Farm",
    "InputError",
    "Interrupted",
    "Job",
    "ParRayError",
    "ParRayWarning",
    "Particles",
    "Picture",
    "Pictures",
    "ProgramNotFound",
    "Progress",
    "RenderError",
    "find_program",
    "render",
    "render_async",
    "srgb_to_linear",
]
