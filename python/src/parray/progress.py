"""The progress of a job, and its display."""

from __future__ import annotations

import base64
import html
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Callable, NamedTuple, Optional, Union

from .picture import Error


class Progress(NamedTuple):
    """The progress of a job, with the values of `parray show`."""

    state: str
    """The state: queued, running, paused, finishing, done, failed or cancelled."""
    done: float
    """The completed share, 0 to 1."""
    samples_per_second: float
    seconds_left: Optional[float]
    waits_for: str
    """What the job waits for, such as workers. Empty: nothing."""
    error: Optional[Error]
    """The error after the last complete pass. None: not known."""

    @classmethod
    def of(cls, job: Mapping[str, Any]) -> Progress:
        left = job.get("seconds_left")
        return cls(
            state=job["state"],
            done=job["progress"],
            samples_per_second=job.get("samples_per_second", 0),
            seconds_left=left if left is not None and left >= 0 else None,
            waits_for=job.get("waits_for", ""),
            error=Error.of(job.get("error")),
        )

    @property
    def ended(self) -> bool:
        return self.state in ("done", "failed", "cancelled")

    def __str__(self) -> str:
        text = f"{int(1000 * self.done) / 10:5.1f} %"
        if self.waits_for:
            return f"{text}  waits for: {self.waits_for}"
        if self.state not in ("queued", "running"):
            return f"{text}  {self.state}"
        if self.samples_per_second > 0:
            text += f"  {self.samples_per_second / 1e6:.3g} M samples/s"
        if self.error:
            text += f"  error {self.error.high:.3g}"
        return text + (f"  {self.seconds_left:.0f} s left" if self.seconds_left is not None else "")


ProgressOption = Union[bool, Callable[[Progress], object], None]


class Shower:
    """Base class of displays of the progress; shows nothing. It is a context manager: its end completes the display."""

    wants_preview = False

    def show(self, progress: Progress) -> None:
        pass

    def preview(self, png: bytes) -> None:
        """Shows the unfinished picture, a PNG file."""

    def end(self) -> None:
        pass

    def __enter__(self) -> Shower:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()


class CallbackShower(Shower):
    def __init__(self, callback: Callable[[Progress], object]) -> None:
        self._callback = callback

    def show(self, progress: Progress) -> None:
        self._callback(progress)


class TerminalShower(Shower):
    """Redraws one line on stderr."""

    _drawn = 0

    def show(self, progress: Progress) -> None:
        columns = shutil.get_terminal_size().columns - 1  # a cursor beyond the last would begin a new line
        text = str(progress)
        bar = min(30, columns - len(text) - 3)
        if bar >= 5:
            filled = int(bar * progress.done)
            text = f"[{'#' * filled}{' ' * (bar - filled)}] {text}"
        text = text[:columns]
        sys.stderr.write("\r" + text.ljust(self._drawn))
        sys.stderr.flush()
        self._drawn = len(text)

    def end(self) -> None:
        if self._drawn:
            sys.stderr.write("\n")


class NotebookShower(Shower):
    """Shows a bar and the unfinished picture below the cell."""

    wants_preview = True

    def __init__(self) -> None:
        from IPython.display import HTML, display

        self._html = HTML
        self._handle = display(HTML(""), display_id=True)
        self._image = ""
        self._progress: Optional[Progress] = None

    def show(self, progress: Progress) -> None:
        self._progress = progress
        self._draw()

    def preview(self, png: bytes) -> None:
        source = base64.b64encode(png).decode()
        self._image = f'<br><img src="data:image/png;base64,{source}" alt="the picture so far">'
        self._draw()

    def _draw(self) -> None:
        if self._progress:
            bar = f'<progress value="{self._progress.done}" max="1" style="width: 20em"></progress>'
            self._handle.update(self._html(f"{bar} {html.escape(str(self._progress))}{self._image}"))

    def end(self) -> None:
        """Removes the unfinished picture, because the cell shows the finished one."""
        self._image = ""
        self._draw()


def shower_for(option: ProgressOption) -> Shower:
    """Returns the display for an option. True or None: a bar in a notebook or a terminal, otherwise nothing."""
    if callable(option):
        return CallbackShower(option)
    if option is False:
        return Shower()
    if _in_notebook():
        return NotebookShower()
    return TerminalShower() if sys.stderr is not None and sys.stderr.isatty() else Shower()


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return getattr(shell, "kernel", None) is not None


class PreviewFile:
    """A file that a program rewrites repeatedly."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._seen = 0

    def changed(self) -> Optional[bytes]:
        """Returns the bytes if the file changed since the last call, otherwise None."""
        try:
            when = self._path.stat().st_mtime_ns
            if when == self._seen:
                return None
            self._seen = when
            return self._path.read_bytes()
        except FileNotFoundError:
            return None
