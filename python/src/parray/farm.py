"""A client of a farm, that is of a coordinator with HTTP (`parray-coordinator --http`). Needs only the standard library.

The document GET /api/v1/openapi.json describes all requests.
"""

from __future__ import annotations

import asyncio
import contextlib
import html
import os
import tempfile
import time
import uuid
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union
from urllib.parse import urlencode

import numpy.typing as npt

from .errors import InputError, ParRayError, RenderError
from .http import Busy, Form, Http
from .options import SubmitOptions, shows_keywords, split
from .picture import Picture
from .program import convert
from .progress import Progress, ProgressOption, Shower, shower_for
from .scene import prepare, safe_name, scene_bytes, with_labels_of
from .several import is_series

if TYPE_CHECKING:
    from typing_extensions import Unpack


_MOST_LISTED = 1000  # jobs in one answer
_MOST_CHANGED = 500  # jobs in one request


class Farm:
    """The coordinator at `url`, such as "http://127.0.0.1:7480". `parray keygen` makes the `token` of a user. Requests
    fail if the coordinator does not answer for `patience` seconds. The constructor asks the coordinator once, so that a
    wrong address or token fails here, within two seconds; with `check=False` it does not."""

    def __init__(self, url: str, token: Optional[str] = None, *, patience: float = 30, check: bool = True) -> None:
        self._http = Http(url, token, patience)
        self.url = url
        if check:
            with contextlib.suppress(Busy):  # it is there
                self._http.ask_once("/api/v1/server", min(patience, 2))

    @shows_keywords(SubmitOptions)
    def submit(
        self,
        source: Any,
        radii: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        **options: Unpack[SubmitOptions],
    ) -> Job:
        """Submits a scene and returns its job. The farm renders the scene whether you wait or not. Takes the arguments of
        parray.render(), except those for this machine. Also takes name, priority, max_failures, webhook and progressive
        of the farm's document. Particles with `camera`, `sky` or `material` need the program `parray` on this machine to
        make a scene. `frames` makes a series of jobs of a trajectory: "all", "0:100:5" (first, last, step) or a range;
        the job that submit() then returns stands for all frames."""
        scene_options, settings = split(options, SubmitOptions)
        if "frames" in settings:
            settings["frames"] = frames_text(settings["frames"])
        with _form_of(source, radii, colors, scene_options, settings) as form:
            key = {"Idempotency-Key": uuid.uuid4().hex}
            answer = self._http.json("POST", "/api/v1/jobs", form, {**key, **form.headers})
        return Job(self, answer["id"])

    @shows_keywords(SubmitOptions)
    def plan(
        self,
        source: Any,
        radii: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        **options: Unpack[SubmitOptions],
    ) -> dict[str, Any]:
        """Forecasts a job on this farm without submitting it. Takes the arguments of submit(). The farm traces a small
        part of the picture for this, which takes a few seconds. Returns `seconds` (`low`, `expected`, `high`) from the
        first sample to the picture, `queue_seconds` before that, `samples_per_pixel`, `error`, `threads`,
        `thread_seconds` and `notes`."""
        scene_options, settings = split(options, SubmitOptions)
        if "frames" in settings:
            settings["frames"] = frames_text(settings["frames"])
        with _form_of(source, radii, colors, scene_options, settings) as form:
            forecast: dict[str, Any] = self._http.json("POST", "/api/v1/plan", form, form.headers)
        return forecast

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
        """Submits a scene, waits for the picture and returns it. Ctrl-C and other exceptions cancel the job."""
        _require_one_picture(options)
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
        """Does the same as render() for asyncio. Cancelling the task cancels the job."""
        _require_one_picture(options)
        job = await asyncio.to_thread(self.submit, source, radii, colors, **options)
        try:
            return await job.wait_async(progress=progress)
        except BaseException:
            await asyncio.shield(asyncio.to_thread(job._give_up))
            raise

    def job(self, id: int) -> Job:
        """Returns a job by its number."""
        return Job(self, id)

    def jobs(
        self,
        state: Union[str, Sequence[str]] = (),
        *,
        user: Optional[str] = None,
        name: Optional[str] = None,
        sort: Optional[str] = None,
        order: Optional[str] = None,
        limit: Optional[int] = None,
    ) -> list[Job]:
        """Returns the jobs, the newest first: those in one of the states `state`, of `user`, whose name contains `name`,
        at most `limit`. `sort`: id, name, user, state, priority, submitted, finished, taken or progress. `order`: asc or
        desc."""
        states = state if isinstance(state, str) else ",".join(state)
        chosen = {"state": states, "user": user, "name": name, "sort": sort, "order": order}
        query = {key: value for key, value in chosen.items() if value}
        by_offset = sort is not None or order is not None  # otherwise pages stay whole while jobs are submitted
        found: list[Job] = []
        most = float("inf") if limit is None else limit
        while len(found) < most:
            query["limit"] = str(int(min(_MOST_LISTED, most - len(found))))
            page = self._http.json("GET", "/api/v1/jobs?" + urlencode(query, safe=","))
            found += [Job(self, job["id"]) for job in page["jobs"]]
            if len(page["jobs"]) < int(query["limit"]) or not by_offset and page["next"] is None:
                break
            query.update({"offset": str(len(found))} if by_offset else {"before": str(page["next"])})
        return found

    def pause(self, jobs: Iterable[Union[Job, int]]) -> None:
        """Pauses many jobs with few requests. Each is a Job or its number. Raises RenderError, after all others are
        paused, if some were refused."""
        self._steer("pause", jobs)

    def resume(self, jobs: Iterable[Union[Job, int]]) -> None:
        """Resumes many jobs. Takes jobs and raises errors as pause() does."""
        self._steer("resume", jobs)

    def cancel(self, jobs: Iterable[Union[Job, int]]) -> None:
        """Cancels many jobs. Takes jobs and raises errors as pause() does."""
        self._steer("cancel", jobs)

    def requeue(self, jobs: Iterable[Union[Job, int]]) -> None:
        """Continues many jobs that failed or were cancelled. Takes jobs and raises errors as pause() does."""
        self._steer("requeue", jobs)

    def forget(self, jobs: Iterable[Union[Job, int]]) -> None:
        """Deletes many jobs that have ended, with their pictures. Takes jobs and raises errors as pause() does."""
        self._steer("forget", jobs)

    def set_priority(self, jobs: Iterable[Union[Job, int]], priority: int) -> None:
        """Sets the priority (0 to 100) of many jobs. Takes jobs and raises errors as pause() does."""
        self._steer("priority", jobs, priority=priority)

    def _steer(self, action: str, jobs: Iterable[Union[Job, int]], **more: int) -> None:
        ids = [job.id if isinstance(job, Job) else job for job in jobs]
        refused = []
        for begin in range(0, len(ids), _MOST_CHANGED):
            body = {"ids": ids[begin : begin + _MOST_CHANGED], **more}
            for result in self._http.json("POST", f"/api/v1/jobs/{action}", body)["results"]:
                if "problem" in result:
                    refused.append(f"job {result['id']}: {result['problem']['detail']}")
        if refused:
            others = f"; and {len(refused) - 3} others" if len(refused) > 3 else ""
            raise RenderError(f"{action}: refused for {len(refused)} of {len(ids)} jobs: {'; '.join(refused[:3])}{others}")

    def workers(self) -> list[dict[str, Any]]:
        """Returns the connected workers in the form of `parray workers --json`."""
        workers: list[dict[str, Any]] = self._http.json("GET", "/api/v1/workers")["workers"]
        return workers

    def __repr__(self) -> str:
        return f"Farm({self.url!r})"


@contextlib.contextmanager
def _form_of(
    source: Any,
    radii: Optional[npt.ArrayLike],
    colors: Optional[npt.ArrayLike],
    scene_options: Mapping[str, Any],
    settings: Mapping[str, Any],
) -> Iterator[Form]:
    """Makes the form of a scene and its options. Its files exist until the end of the block."""
    if is_series(source):
        raise InputError("frames: these frames are no file: call submit() for each of them")
    if "frames" in settings and not isinstance(source, (str, os.PathLike, Mapping)):
        raise InputError("frames: only a file, or a scene that names one, has frames: call submit() for each frame")
    with tempfile.TemporaryDirectory(prefix="parray-") as folder:
        work = prepare(source, radii, colors, scene_options, settings, Path(folder), convert, as_file=True)
        settings = with_labels_of(work, settings, lambda _: True)
        scene, files = work.parts()
        asked = dict(work.asked)
        if "topology" in asked:
            names = Path(asked["topology"])
            asked["topology"] = "names-" + safe_name(names.name)
            files[asked["topology"]] = names
        form = Form()
        form.text("options", scene_bytes({**settings, **asked}), "application/json")
        if scene is not None:
            form.text("scene", scene, "application/json")
        for name, path in files.items():
            # With several files, the one of the particles must be the scene.
            form.file(name, path, "scene" if len(files) > 1 and path == work.source else "file")
        yield form


def _require_one_picture(options: Mapping[str, Any]) -> None:
    if options.get("frames") is not None:
        raise InputError("frames: render() returns one picture: use submit(), which returns the series")


def frames_text(frames: Union[str, int, Sequence[int]]) -> str:
    """Returns frames in the form of the farm. Raises InputError unless they are a range."""
    if isinstance(frames, str):
        return frames
    numbers = [frames] if isinstance(frames, int) else [int(number) for number in frames]
    if not numbers:
        raise InputError("frames: there are no frames: give at least one, such as frames=range(10)")
    step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
    if step <= 0 or numbers != list(range(numbers[0], numbers[-1] + 1, step)):
        raise InputError("frames: a series has frames at equal distances: give range(0, 100, 5), or call submit() for each")
    return f"{numbers[0]}:{numbers[-1]}:{step}"


class Job:
    """A job of a farm. `await job` waits for its picture."""

    def __init__(self, farm: Farm, id: int) -> None:
        self.farm = farm
        self.id = id
        self._http = farm._http
        self._path = f"/api/v1/jobs/{id}"

    def show(self) -> dict[str, Any]:
        """Returns all facts about the job in the form of `parray show --json`."""
        job: dict[str, Any] = self._http.json("GET", self._path)
        return job

    @property
    def state(self) -> str:
        """The state: queued, running, paused, finishing, done, failed or cancelled."""
        return str(self.show()["state"])

    @property
    def progress(self) -> Progress:
        return Progress.of(self.show())

    def picture(self) -> Picture:
        """Returns the finished or unfinished picture. Raises InputError if nothing was traced yet."""
        job = self.show()
        exr = self._http.body("GET", self._path + "/image.exr")
        done = job["state"] == "done"
        return Picture(exr, self._http.json("GET", self._path + "/report") if done else {"error": job.get("error")})

    def png(self) -> bytes:
        """Returns the finished or unfinished picture as a PNG file. Only that of a finished job has labels and
        postprocessing."""
        return self._http.body("GET", self._path + "/image.png")

    def thumbnail(self, width: int = 64) -> bytes:
        """Returns png() made smaller: `width` pixels wide, 16 to 1024. A picture that is not wider keeps its size."""
        return self._http.body("GET", f"{self._path}/image.png?width={width}")

    def wait(self, timeout: Optional[float] = None, progress: ProgressOption = None) -> Picture:
        """Waits until the job is done and returns its picture. `progress` is that of parray.render(). Raises RenderError
        if the job fails or is cancelled, and TimeoutError after `timeout` seconds. An exception does not stop the job."""
        with shower_for(progress) as shower:
            for pause in self._looks(timeout, shower, 30 if type(shower) is Shower else 2):
                time.sleep(pause)
        return self.picture()

    async def wait_async(self, timeout: Optional[float] = None, progress: ProgressOption = None) -> Picture:
        """Does the same as wait() for asyncio."""
        with shower_for(progress) as shower:
            looks = self._looks(timeout, shower, 2)  # a cancelled task leaves its thread for no longer than that
            while (pause := await asyncio.to_thread(next, looks, None)) is not None:
                await asyncio.sleep(pause)
        return await asyncio.to_thread(self.picture)

    def __await__(self) -> Generator[Any, None, Picture]:
        return self.wait_async().__await__()

    def _looks(self, timeout: Optional[float], shower: Shower, patience: int) -> Iterator[float]:
        """Requests the state of the job until it is done. Yields the seconds to wait before the next request. After some
        seconds each request waits on the server, for at most `patience` seconds."""
        begin = time.monotonic()
        job = self.show()
        while True:
            now = Progress.of(job)
            shower.show(now)
            if now.ended:
                break
            if shower.wants_preview and now.done > 0:
                with contextlib.suppress(ParRayError):  # nothing was traced yet
                    shower.preview(self.png())
            waited = time.monotonic() - begin
            if timeout is not None and waited >= timeout:
                raise TimeoutError(f"job {self.id} is not done after {timeout:g} s: the job continues")
            left = float("inf") if timeout is None else timeout - waited
            if waited >= 2 and left >= 1:
                with contextlib.suppress(Busy):
                    job = self._http.ask_once(f"{self._path}?wait={int(min(patience, left))}", self._http.patience)
                    continue
            yield min(max(waited / 20, 0.05), 2, left)
            job = self.show()
        if now.state != "done":
            reason = f": {job['reason']}" if job["reason"] else ""
            raise RenderError(f"job {self.id} {'failed' if now.state == 'failed' else 'was cancelled'}{reason}")

    def pause(self) -> None:
        """Stops giving work of the job to workers. Keeps the results so far."""
        self._http.json("POST", self._path + "/pause")

    def resume(self) -> None:
        """Continues a paused job."""
        self._http.json("POST", self._path + "/resume")

    def cancel(self) -> None:
        """Cancels the job. Has no effect on a job that has ended."""
        try:
            self._http.json("POST", self._path + "/cancel")
        except ParRayError:
            if self.state not in ("done", "failed", "cancelled"):
                raise

    def requeue(self) -> None:
        """Continues a job that failed or was cancelled."""
        self._http.json("POST", self._path + "/requeue")

    def set_priority(self, priority: int) -> None:
        """Sets the priority, 0 to 100. Of the jobs of a user, those with higher priority are served first."""
        self._http.json("PUT", self._path + "/priority", {"priority": priority})

    def forget(self) -> None:
        """Deletes a job that has ended, with its picture."""
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

