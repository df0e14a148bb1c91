"""A farm: a coordinator that serves HTTP (`parray-coordinator --http`), asked by what Python brings along.

Its document, GET /api/v1/openapi.json, has all that is used here.
"""

from __future__ import annotations

import asyncio
import contextlib
import html
import tempfile
import time
import uuid
from collections.abc import Generator, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional

import numpy.typing as npt

from .errors import ParRayError, RenderError
from .http import Form, Http
from .options import SubmitOptions, shows_keywords, split
from .picture import Picture
from .program import convert
from .progress import Progress, ProgressOption, Shower, shower_for
from .scene import prepare, scene_bytes

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Farm:
    """The coordinator at `url`, such as "http://127.0.0.1:7480"; `token` is one that `parray keygen` made for you.
    Without an answer for `patience` seconds it is given up."""

    def __init__(self, url: str, token: Optional[str] = None, *, patience: float = 30) -> None:
        self._http = Http(url, token, patience)
        self.url = url

    @shows_keywords(SubmitOptions)
    def submit(
        self,
        source: Any,
        radii: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        **options: Unpack[SubmitOptions],
    ) -> Job:
        """Hands a scene to the farm, which renders it whether you wait or not. Arguments of parray.render(), but for those
        of this machine, and name, priority, max_failures, webhook and progressive as in the farm's document. Particles
        with `camera`, `sky`, `material`, or what chooses and colours them, need the program `parray` here, too, to make a
        scene of them."""
        scene_options, settings = split(options, SubmitOptions)
        with tempfile.TemporaryDirectory(prefix="parray-") as folder:
            work = prepare(source, radii, colors, scene_options, settings, Path(folder), convert)
            scene, files = work.parts()
            form = Form()
            form.text("options", scene_bytes(settings), "application/json")
            if scene is not None:
                form.text("scene", scene, "application/json")
            for name, path in files.items():
                form.file(name, path)
            key = {"Idempotency-Key": uuid.uuid4().hex}
            answer = self._http.json("POST", "/api/v1/jobs", form, {**key, **form.headers})
        return Job(self, answer["id"])

    @shows_keywords(SubmitOptions)
    def render(
        self,
        source: Any,
        radii: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        *,
        progress: ProgressOption = None,
        **options: Unpack[SubmitOptions],
    ) -> Picture:
        """Submits and waits. What ends the waiting, such as Ctrl-C, cancels the job."""
        job = self.submit(source, radii, colors, **options)
        try:
            return job.wait(progress=progress)
        except BaseException:
            job._give_up()
            raise

    @shows_keywords(SubmitOptions)
    async def render_async(
        self,
        source: Any,
        radii: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        *,
        progress: ProgressOption = None,
        **options: Unpack[SubmitOptions],
    ) -> Picture:
        """render() for asyncio. Cancelling the task cancels the job."""
        job = await asyncio.to_thread(self.submit, source, radii, colors, **options)
        try:
            return await job.wait_async(progress=progress)
        except BaseException:
            await asyncio.shield(asyncio.to_thread(job._give_up))
            raise

    def job(self, id: int) -> Job:
        """A job by its number."""
        return Job(self, id)

    def jobs(self, states: Sequence[str] = ()) -> Iterator[Job]:
        """The newest first; only those in one of `states`, if any are given."""
        query = "?limit=1000" + (f"&state={','.join(states)}" if states else "")
        before = ""
        while True:
            page = self._http.json("GET", f"/api/v1/jobs{query}{before}")
            for job in page["jobs"]:
                yield Job(self, job["id"])
            if page["next"] is None:
                return
            before = f"&before={page['next']}"

    def workers(self) -> list[dict[str, Any]]:
        """Those that are there now, as `parray workers --json` has them."""
        workers: list[dict[str, Any]] = self._http.json("GET", "/api/v1/workers")["workers"]
        return workers

    def __repr__(self) -> str:
        return f"Farm({self.url!r})"


class Job:
    """A job of a farm. Awaiting it waits for its picture."""

    def __init__(self, farm: Farm, id: int) -> None:
        self.farm = farm
        self.id = id
        self._http = farm._http
        self._path = f"/api/v1/jobs/{id}"

    def show(self) -> dict[str, Any]:
        """What there is to know of it, as `parray show --json` has it."""
        job: dict[str, Any] = self._http.json("GET", self._path)
        return job

    @property
    def state(self) -> str:
        """queued, running, paused, finishing, done, failed or cancelled."""
        return str(self.show()["state"])

    @property
    def progress(self) -> Progress:
        return Progress.of(self.show())

    def picture(self) -> Picture:
        """The picture, or what there is of it. InputError as long as there is nothing."""
        job = self.show()
        exr = self._http.body("GET", self._path + "/image.exr")
        done = job["state"] == "done"
        return Picture(exr, self._http.json("GET", self._path + "/report") if done else {"error": job.get("error")})

    def png(self) -> bytes:
        """The same as a PNG file."""
        return self._http.body("GET", self._path + "/image.png")

    def wait(self, timeout: Optional[float] = None, progress: ProgressOption = None) -> Picture:
        """Until it is done; `progress` as parray.render() has it. RenderError when it fails or is cancelled,
        TimeoutError after `timeout` seconds. The job itself goes on, whatever ends the waiting."""
        with shower_for(progress) as shower:
            for pause in self._looks(timeout, shower):
                time.sleep(pause)
        return self.picture()

    async def wait_async(self, timeout: Optional[float] = None, progress: ProgressOption = None) -> Picture:
        """wait() for asyncio."""
        with shower_for(progress) as shower:
            looks = self._looks(timeout, shower)
            while (pause := await asyncio.to_thread(next, looks, None)) is not None:
                await asyncio.sleep(pause)
        return await asyncio.to_thread(self.picture)

    def __await__(self) -> Generator[Any, None, Picture]:
        return self.wait_async().__await__()

    def _looks(self, timeout: Optional[float], shower: Shower) -> Iterator[float]:
        """Looks at the job, and says how long to wait until the next time, until it is done."""
        begin = time.monotonic()
        while True:
            job = self.show()
            now = Progress.of(job)
            shower.show(now)
            if now.ended:
                break
            if shower.wants_preview and now.done > 0:
                with contextlib.suppress(ParRayError):  # there is nothing yet
                    shower.preview(self.png())
            waited = time.monotonic() - begin
            if timeout is not None and waited >= timeout:
                raise TimeoutError(f"job {self.id} is not done after {timeout:g} s: it goes on")
            pause = min(max(waited / 20, 0.05), 2)
            yield pause if timeout is None else min(pause, timeout - waited)
        if now.state != "done":
            reason = f": {job['reason']}" if job["reason"] else ""
            raise RenderError(f"job {self.id} was not finished: {now.state}{reason}")

    def pause(self) -> None:
        self._http.json("POST", self._path + "/pause")

    def resume(self) -> None:
        self._http.json("POST", self._path + "/resume")

    def cancel(self) -> None:
        """One that has ended stays as it is."""
        self._http.json("POST", self._path + "/cancel")

    def requeue(self) -> None:
        """Goes on with one that has failed or was cancelled."""
        self._http.json("POST", self._path + "/requeue")

    def set_priority(self, priority: int) -> None:
        """0 to 100: of one user's jobs those of higher priority go first."""
        self._http.json("PUT", self._path + "/priority", {"priority": priority})

    def forget(self) -> None:
        """Deletes one that has ended, with its picture."""
        self._http.body("DELETE", self._path)

    def _give_up(self) -> None:
        with contextlib.suppress(Exception):
            self.cancel()

    def _repr_html_(self) -> str:
        job = self.show()
        if job["state"] == "done":
            return self.picture()._repr_html_()
        return html.escape(f"job {self.id}: {Progress.of(job)}")

    def __repr__(self) -> str:
        return f"<Job {self.id} of {self.farm.url}>"

