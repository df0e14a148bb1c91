"""Runs the program `parray` on this machine."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional

import numpy.typing as npt

from .errors import Interrupted, InputError, ParRayError, ParRayWarning, ProgramNotFound, RenderError
from .options import RenderOptions, as_arguments, drawn_by, shows_keywords, split
from .picture import Picture, Pictures
from .progress import PreviewFile, Progress, ProgressOption, Shower, shower_for
from .scene import prepare, with_labels_of
from .several import Tools, calls_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

_ERRORS = {1: RenderError, 2: InputError, 130: Interrupted}
_TEMPORARY = "/parray-[a-z0-9_]{8}/"  # of tempfile
_BUNDLED = Path(__file__).parent / "bundled" / "bin" / "parray"
_PATIENCE = 10  # seconds until a program that must end is killed


def find_program() -> str:
    """Returns the program `parray`: that of PARRAY_BIN (a program or its folder), otherwise that inside this package, which
    a wheel of deploy/wheel has, otherwise the one in PATH. Raises ProgramNotFound."""
    asked = os.environ.get("PARRAY_BIN")
    if asked:
        places = [os.path.join(asked, "parray") if os.path.isdir(asked) else asked]
    else:
        places = [str(_BUNDLED), "parray"]
    found = next(filter(None, map(shutil.which, places)), None)
    if found:
        return found
    if asked:
        raise ProgramNotFound(f"PARRAY_BIN is {asked}, where no program is: name the program `parray` or its folder")
    raise ProgramNotFound(
        "`parray` is not in PATH: build or install ParRay, then add its folder to PATH or name it in PARRAY_BIN; "
        "or render on a farm: parray.Farm(url).render(...)"
    )


def convert(file: Path, scene: Path, options: list[str]) -> None:
    """Runs `parray convert`."""
    done = subprocess.run(
        [find_program(), "convert", str(file), str(scene), *options], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise error_of(done.returncode, done.stderr)


def validate(file: Path, options: Sequence[str]) -> dict[str, Any]:
    """Returns what `parray validate` says about a particle file: an entry of `particle_files`. Returns an empty dict if it
    refuses the file or the options."""
    command = [find_program(), "validate", str(file), "--json", *options]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    files = json.loads(done.stdout).get("particle_files", []) if done.returncode == 0 else []
    return dict(files[0]) if files else {}


def legends(file: Path) -> list[dict[str, Any]]:
    """Returns the legends for a file: the member `legends` of the report of a picture of 4 x 4 pixels."""
    report = file.with_name("legends.json")
    command = [find_program(), "render", str(file), "-q", "-o", str(file.with_name("legends.exr")), "--report", str(report)]
    command += ["--width", "4", "--height", "4", "--spp", "1"]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise error_of(done.returncode, done.stderr)
    found: list[dict[str, Any]] = json.loads(report.read_bytes())["legends"]
    return found


def has_option(option: str) -> bool:
    """Returns whether `parray render` of this machine has an option."""
    command = [find_program(), "help", "render", "--all"]
    return option in subprocess.run(command, capture_output=True, text=True, check=False).stdout.split()


_TOOLS = Tools(convert, validate, legends, has_option)


def _without_folders(text: str) -> str:
    """Returns a message in which temporary files have no folder, as "particles.xyz", and other files a short path."""

    def short(found: re.Match[str]) -> str:
        path = os.path.normpath(found[0])
        return os.path.basename(path) if re.search(_TEMPORARY, path) else path

    return re.sub(rf"[^\s:]*{_TEMPORARY}[^\s:]*", short, text)


def error_of(status: int, stderr: str) -> ParRayError:
    text = _without_folders(stderr.strip())
    text = text[len("parray: ") :] if text.startswith("parray: ") else text
    return _ERRORS.get(status, RenderError)(text or f"parray ended with status {status}")


class _Render:
    """One run of `parray render`: its arguments, its output and its picture."""

    def __init__(self, source: Any, radii: Any, colors: Any, given: RenderOptions, folder: Path, shower: Shower):
        scene, options = split(given, RenderOptions)
        program = find_program()
        self._folder = folder
        self._shower = shower
        self._exr = folder / "picture.exr"
        self._png = folder / "picture.png"
        # Only PNG pictures have labels and postprocessing; then the preview receives the floats. A style may add outlines.
        drawn = drawn_by(options)
        if drawn and "aov" in options:
            raise InputError(f"aov: a picture with {', '.join(drawn)} has no extra channels: render the channels in another call")
        self._drawn = bool(drawn) or (scene.get("style", "studio") != "studio" and "aov" not in options)
        self._preview = PreviewFile(self._exr if self._drawn else self._png)
        self._said: list[str] = []
        # A separate folder, because the names of input files are arbitrary.
        inputs = folder / "input"
        inputs.mkdir()
        work = prepare(source, radii, colors, scene, options, inputs, convert, as_file=True)
        options = with_labels_of(work, options, has_option)
        file = work.local_file(inputs)
        output, preview = (self._png, self._exr) if self._drawn else (self._exr, self._png)
        self.command = [program, "render", str(file), "-o", str(output),
                        "--report", str(folder / "report.json"), "--progress", "json", *work.options, *as_arguments(options)]  # fmt: skip
        if shower.wants_preview or self._drawn:
            self.command += ["--preview", str(preview)]

    def hear(self, line: str) -> None:
        """Handles a line of stderr."""
        if not line.startswith("{"):
            self._said.append(line)
            return
        self._shower.show(Progress.of(json.loads(line)))
        picture = self._preview.changed() if self._shower.wants_preview else None
        if picture:
            self._shower.preview(Picture(picture, {})._repr_png_() if self._drawn else picture)

    def picture(self, status: int) -> Picture:
        said = "".join(self._said).strip()
        if status != 0:
            raise error_of(status, said)
        if said:
            warnings.warn(_without_folders(said), ParRayWarning, stacklevel=_level_of_user())
        report = json.loads((self._folder / "report.json").read_bytes())
        return Picture(self._exr.read_bytes(), report, self._png.read_bytes() if self._drawn else None)


@shows_keywords(RenderOptions)
def render(
    source: Any,
    radii: Optional[npt.ArrayLike] = None,
    colors: Optional[npt.ArrayLike] = None,
    *,
    progress: ProgressOption = None,
    **options: Unpack[RenderOptions],
) -> Picture:
    """Renders on this machine with the program `parray` (find_program()) and returns the picture.

    source    positions as an array of (N, 3); a table with columns x, y and z (pandas, astropy, structured arrays); ASE
              Atoms; an MDAnalysis Universe or AtomGroup; an OVITO Pipeline or DataCollection; the path of a scene or
              particle file; or a scene as a dict. In the dict, each `file` of `particles` may be any of these except a
              scene. A list of sources, an array of (F, N, 3) or a trajectory of ASE gives a list of pictures with one
              camera and one range of colours
    radii     radii of particles: (N,), or one for all
    colors    (N, 3), or (3,) for all: linear RGB from 0 to 1, or sRGB of type uint8 (see parray.srgb_to_linear); or names
              of colours: "tab:blue", "#1f77b4"
    elements  (N,): symbols or atomic numbers, which determine colours and radii
    camera, sky   members of a scene's `camera` and `sky`; they replace those of the scene or automatic scene. With vfov
              alone, the camera moves so that the particles fill the picture as before
    material  material of particles: "by-element", "by-type", "column", "plain", or one material of a scene file for all:
              {"type": "metal", "albedo": [0.8, 0.6, 0.2]}
    frame     number, from 0, of a frame in a particle file, Universe or Pipeline; for a file also "last"
    frames    several numbers of frames, such as range(0, 100, 10), or "all": returns a list of pictures
    select, slice, hide, alternatives   which particles are shown: select="z > 10", slice="z=40%:60%"
    crystal, replicate, wrap, whole, center   what the periodic cell means: replicate="3x3x3", center="resname LIG"
    topology  file with elements and names for a trajectory without them
    color_by  colours by a number or category of the particles: the name of a column, or (N,) numbers or texts for arrays
              and objects. `values` is another word for it
    colormap, range, color_scale   of these colours; range: (low, high), or "1%:99%"
    radius_by radii by a number of the particles: "diameter", or "mass:0.5:2" for radii from 0.5 to 2
    show      parts with their own look: show=[{"select": "protein", "color_by": "chain"}, {"select": "ligand", "radius": 1}]
    view, style, projection   direction of view, surroundings of the particles, and projection
    style     also shapes of the particles: "spheres", "balls-and-sticks" (default for small molecules), "sticks". Both:
              ("flat", "sticks")
    bonds, stick_radius   bonds that sticks show ("auto", "file", "off"), and the radius of sticks
    arrows, arrow_scale   a vector of each particle as an arrow: "velocity", "force" or "mux,muy,muz", and the length of
              an arrow for a vector of length 1
    solid_cell   True: the edges of the cell are rods
    up, azimuth, elevation, zoom   change the camera: up="y", angles in degrees, zoom=1.5
    background   colour of the PNG picture's background, such as "black" or "#1e90ff", for particles with the program's camera
    quality   "draft", "good" or "print": size and error
    views     several views, such as "front,iso": returns a list of pictures
    legend, legend_title, scale_bar, unit, time_stamp, cell, text   labels on the PNG picture, which is shown and saved as .png
    outline, depth_cue        postprocessing of the PNG picture: True, False, or a width (outline) or strength (depth_cue)
    font_size, width_mm, dpi  size of the PNG picture in print
    labels    False: leaves out the labels that the scene asks for
    aov       extra channels, see Picture.channels: "depth,normal" or a list
    like      a picture file of ParRay: renders the same picture again
    progress  False: none; a function: called with a Progress up to five times a second; otherwise a bar in a terminal or
              a notebook

    width, height, spp, max_depth, seed, sampler, precision, target_error, target_half_width, time_limit, adaptive,
    passes, denoise, transparent, accelerator, isa, schedule, row_order, threads: see `parray help render --all`.

    Raises InputError, RenderError, Interrupted or ProgramNotFound. Ctrl-C also ends the program.
    """
    calls = calls_of(source, radii, colors, options, _TOOLS)
    if calls is not None:
        pictures = Pictures(render(*call[:3], progress=progress, **call.options) for call in calls)
        return pictures  # type: ignore[return-value]
    with tempfile.TemporaryDirectory(prefix="parray-") as folder, shower_for(progress) as shower:
        run = _Render(source, radii, colors, options, Path(folder), shower)
        with subprocess.Popen(
            run.command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as process:
            try:
                assert process.stderr is not None
                for line in process.stderr:
                    run.hear(line)
                status = process.wait()
            except BaseException:
                _end(process)
                raise
        return run.picture(status)


def _level_of_user() -> int:
    """Returns the `stacklevel` of a warning for which the caller's line is outside this package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == os.path.dirname(__file__):
        frame, level = frame.f_back, level + 1
    return level


def _end(process: subprocess.Popen[str]) -> None:
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(signal.SIGINT)
    try:
        process.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
    except BaseException:  # a second Ctrl-C
        process.kill()
        raise


@shows_keywords(RenderOptions)
async def render_async(
    source: Any,
    radii: Optional[npt.ArrayLike] = None,
    colors: Optional[npt.ArrayLike] = None,
    *,
    progress: ProgressOption = None,
    **options: Unpack[RenderOptions],
) -> Picture:
    """Does the same as render() for asyncio. Cancelling the task ends the program."""
    calls = await asyncio.to_thread(calls_of, source, radii, colors, options, _TOOLS)
    if calls is not None:
        pictures = Pictures([await render_async(*call[:3], progress=progress, **call.options) for call in calls])
        return pictures  # type: ignore[return-value]
    with tempfile.TemporaryDirectory(prefix="parray-") as folder, shower_for(progress) as shower:
        run = await asyncio.to_thread(_Render, source, radii, colors, options, Path(folder), shower)
        process = await asyncio.create_subprocess_exec(
            *run.command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        )
        try:
            assert process.stderr is not None
            async for line in process.stderr:
                run.hear(line.decode(errors="replace"))
            status = await process.wait()
        except BaseException:
            await asyncio.shield(_end_async(process))
            raise
        return await asyncio.to_thread(run.picture, status)


async def _end_async(process: asyncio.subprocess.Process) -> None:
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(signal.SIGINT)
    try:
        await asyncio.wait_for(process.wait(), _PATIENCE)
    except asyncio.TimeoutError:
        process.kill()
        await process.wait()
