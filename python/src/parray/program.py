"""Runs the program `parray` on this machine."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import shutil
import signal
import subprocess
import tempfile
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional

import numpy.typing as npt

from .errors import Interrupted, InputError, ParRayError, ParRayWarning, ProgramNotFound, RenderError
from .options import RenderOptions, as_arguments, is_drawn_on, shows_keywords, split
from .picture import Picture
from .progress import PreviewFile, Progress, ProgressOption, Shower, shower_for
from .scene import prepare

if TYPE_CHECKING:
    from typing_extensions import Unpack

_ERRORS = {1: RenderError, 2: InputError, 130: Interrupted}
_PATIENCE = 10  # seconds until a program that must end is killed


def find_program() -> str:
    """Returns the program `parray`: that of PARRAY_BIN (a program or its folder), otherwise the one in PATH. Raises
    ProgramNotFound."""
    asked = os.environ.get("PARRAY_BIN")
    found = shutil.which(os.path.join(asked, "parray") if asked and os.path.isdir(asked) else asked or "parray")
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


def error_of(status: int, stderr: str) -> ParRayError:
    text = stderr.strip()
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
        self._drawn = is_drawn_on(options) or (scene.get("style", "studio") != "studio" and "aov" not in options)
        self._preview = PreviewFile(self._exr if self._drawn else self._png)
        self._said: list[str] = []
        # A separate folder, because the names of input files are arbitrary.
        inputs = folder / "input"
        inputs.mkdir()
        file = prepare(source, radii, colors, scene, options, inputs, convert).local_file(inputs)
        output, preview = (self._png, self._exr) if self._drawn else (self._exr, self._png)
        self.command = [program, "render", str(file), "-o", str(output),
                        "--report", str(folder / "report.json"), "--progress", "json", *as_arguments(options)]  # fmt: skip
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
            warnings.warn(said, ParRayWarning, stacklevel=3)
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

    source    positions as an array of (N, 3); ASE Atoms; an MDAnalysis Universe or AtomGroup; an OVITO Pipeline or
              DataCollection; the path of a scene or particle file; or a scene as a dict. In the dict, each `file` of
              `particles` may be any of these except a scene
    radii     radii of particles: (N,), or one for all
    colors    (N, 3), or (3,) for all: linear RGB from 0 to 1, or sRGB of type uint8 (see parray.srgb_to_linear)
    elements  (N,): symbols or atomic numbers, which determine colours and radii
    camera, sky   members of a scene's `camera` and `sky`; they replace those of the scene or automatic scene
    material  material of particles: "by-element", "by-type", "column", "plain", or one material of a scene file for all:
              {"type": "metal", "albedo": [0.8, 0.6, 0.2]}
    frame     number, from 0, of a frame in a particle file, Universe or Pipeline; for a file also "last"
    select, slice, hide, alternatives   which particles are shown: select="z > 10", slice="z=40%:60%"
    crystal, replicate, wrap, whole, center   what the periodic cell means: replicate="3x3x3", center="resname LIG"
    topology  file with elements and names for a trajectory without them
    color_by, colormap, range   colours by a number or category of the particles; range: (low, high), or "1%:99%"
    view, style, projection   direction of view, surroundings of the particles, and projection
    up, azimuth, elevation, zoom   change the camera: up="y", angles in degrees, zoom=1.5
    background   colour of the PNG picture's background, such as "black" or "#1e90ff", for a particle file without options
              that choose or colour particles or change the camera
    quality   "draft", "good" or "print": size and error
    legend, legend_title, scale_bar, unit, time_stamp, cell, text   labels on the PNG picture, which is shown and saved as .png
    outline, depth_cue        postprocessing of the PNG picture: True, False, or a strength
    font_size, width_mm, dpi  size of the PNG picture in print
    labels    False: no labels, even if the scene has some
    aov       extra channels, see Picture.channels: "depth,normal" or a list
    like      a picture file of ParRay: renders the same picture again
    progress  False: none; a function: called with a Progress up to five times a second; otherwise a bar in a terminal or
              a notebook

    width, height, spp, max_depth, seed, sampler, precision, target_error, target_half_width, time_limit, adaptive,
    passes, denoise, transparent, accelerator, isa, schedule, row_order, threads: see `parray help render --all`.

    Raises InputError, RenderError, Interrupted or ProgramNotFound. Ctrl-C also ends the program.
    """
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
