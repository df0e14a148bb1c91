"""The program `parray` on this machine: where it is, what it is asked, what it answers."""

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
_PATIENCE = 10  # seconds, of a program that was asked to end


def find_program() -> str:
    """The program `parray`: PARRAY_BIN (the program, or the folder that it is in), else the one in PATH.
    ProgramNotFound."""
    asked = os.environ.get("PARRAY_BIN")
    found = shutil.which(os.path.join(asked, "parray") if asked and os.path.isdir(asked) else asked or "parray")
    if found:
        return found
    if asked:
        raise ProgramNotFound(f"PARRAY_BIN is {asked}: no program there: name `parray`, or the folder that it is in")
    raise ProgramNotFound(
        "no program `parray` in PATH: build or install ParRay, then add its folder to PATH or name it in PARRAY_BIN; "
        "or render on a farm: parray.Farm(url).render(...)"
    )


def convert(file: Path, scene: Path, options: list[str]) -> None:
    """`parray convert`."""
    done = subprocess.run(
        [find_program(), "convert", str(file), str(scene), *options], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise error_of(done.returncode, done.stderr)


def error_of(status: int, stderr: str) -> ParRayError:
    text = stderr.strip()
    text = text[len("parray: ") :] if text.startswith("parray: ") else text
    return _ERRORS.get(status, RenderError)(text or f"parray has ended with status {status}")


class _Render:
    """One run of `parray render`: what it is called with, and what becomes of what it says and writes."""

    def __init__(self, source: Any, radii: Any, colors: Any, given: RenderOptions, folder: Path, shower: Shower):
        scene, options = split(given, RenderOptions)
        program = find_program()
        self._folder = folder
        self._shower = shower
        self._exr = folder / "picture.exr"
        self._png = folder / "picture.png"
        # Only a PNG picture is drawn on; the preview beside it ends as its floats. A style may draw, too.
        self._drawn = is_drawn_on(options) or (scene.get("style", "studio") != "studio" and "aov" not in options)
        self._preview = PreviewFile(self._exr if self._drawn else self._png)
        self._said: list[str] = []
        # Not where preview() makes its files: one of them may have any name.
        inputs = folder / "input"
        inputs.mkdir()
        file = prepare(source, radii, colors, scene, options, inputs, convert).local_file(inputs)
        output, preview = (self._png, self._exr) if self._drawn else (self._exr, self._png)
        self.command = [program, "render", str(file), "-o", str(output),
                        "--report", str(folder / "report.json"), "--progress", "json", *as_arguments(options)]  # fmt: skip
        if shower.wants_preview or self._drawn:
            self.command += ["--preview", str(preview)]

    def hear(self, line: str) -> None:
        """A line of stderr."""
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
    """Renders on this machine, by the program `parray` (find_program()), and returns the picture.

    source    positions, an array of (N, 3); ASE Atoms; an MDAnalysis Universe or AtomGroup; an OVITO Pipeline or
              DataCollection; the path of a scene or particle file; a scene as a dict, in whose `particles` each `file`
              may be any of those but a scene
    radii     of particles: (N,), or one for all
    colors    (N, 3), or (3,) for all: linear RGB from 0 to 1; of type uint8: sRGB (parray.srgb_to_linear for others)
    elements  (N,): symbols or atomic numbers, for their colours and radii
    camera, sky   members of a scene's `camera` and `sky`, which replace those of the scene or portrait
    material  of particles: "by-element", "by-type", "column", "plain", or a material of a scene file, for all:
              {"type": "metal", "albedo": [0.8, 0.6, 0.2]}
    frame     of a particle file, Universe or Pipeline with several, from 0; of a file also "last"
    select, slice, hide, alternatives   which particles are shown: select="z > 10", slice="z=40%:60%"
    topology  file with the elements and names of a trajectory that has none
    color_by, colormap, range   colours by a number or category of the particles; range: (low, high), or "1%:99%"
    view, style, projection   the side that they are seen from, what is around them, and how far things look
    legend, scale_bar, unit, time_stamp, cell, text   drawn on the PNG picture, what is shown and saved as .png
    outline, depth_cue        done to it: True, False, or how much
    font_size, width_mm, dpi  its size in print
    labels    False: none of the labels that a scene asks for
    aov       extra channels, see Picture.channels: "depth,normal" or a list
    like      a picture file of ParRay: the same picture again
    progress  False: show none; a function: called with a Progress, up to five times a second; otherwise a bar, at a
              terminal or in a notebook

    width, height, spp, max_depth, seed, sampler, precision, target_error, target_half_width, time_limit, adaptive,
    passes, denoise, transparent, accelerator, isa, schedule, row_order, threads: as `parray help render --all` has them.

    Raises InputError, RenderError, Interrupted or ProgramNotFound. Ctrl-C ends the program, too.
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
    """render() for asyncio. Cancelling the task ends the program."""
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
