"""Requests to a coordinator. They are repeated until an answer comes. Problems become exceptions."""

from __future__ import annotations

import http.client
import json
import re
import time
import uuid
from collections.abc import Iterator, Mapping
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Optional, Union

from .errors import InputError, ParRayError, RenderError

_TIMEOUT = 60  # seconds of silence in one request


class Form:
    """A body of type multipart/form-data (RFC 7578). Reads its files during sending. Each attempt iterates over it."""

    def __init__(self) -> None:
        self._boundary = uuid.uuid4().hex
        self._parts: list[tuple[bytes, Union[bytes, Path]]] = []

    def text(self, name: str, value: bytes, content_type: str) -> None:
        self._add(f'name="{name}"', content_type, value)

    def file(self, name: str, path: Path, part: str = "file") -> None:
        """Adds a file as a part. `name` may contain letters, digits, '.', '_' and '-'."""
        if not path.is_file():
            raise InputError(f"{path}: no such file: check the path")
        self._add(f'name="{part}"; filename="{name}"', "application/octet-stream", path)

    def _add(self, disposition: str, content_type: str, body: Union[bytes, Path]) -> None:
        head = f"--{self._boundary}\r\nContent-Disposition: form-data; {disposition}\r\nContent-Type: {content_type}\r\n\r\n"
        self._parts.append((head.encode(), body))

    @property
    def _end(self) -> bytes:
        return f"--{self._boundary}--\r\n".encode()

    @property
    def headers(self) -> dict[str, str]:
        def size(body: Union[bytes, Path]) -> int:
            return body.stat().st_size if isinstance(body, Path) else len(body)

        length = sum(len(head) + size(body) + 2 for head, body in self._parts) + len(self._end)
        return {"Content-Type": f"multipart/form-data; boundary={self._boundary}", "Content-Length": str(length)}

    def __iter__(self) -> Iterator[bytes]:
        for head, body in self._parts:
            yield head
            if isinstance(body, bytes):
                yield body
            else:
                with body.open("rb") as file:
                    while chunk := file.read(1 << 20):
                        yield chunk
            yield b"\r\n"
        yield self._end


class Busy(RenderError):
    """The server has no room for this request now (status 503)."""


class Http:
    def __init__(self, url: str, token: Optional[str], patience: float) -> None:
        found = re.fullmatch(r"(https?)://(\[[0-9a-fA-F:.]+\]|[^][/?#@:]+)(?::([0-9]{1,5}))?(/[^?#]*)?", url)
        if not found:
            raise InputError(f"{url}: give http://HOST:PORT or https://HOST:PORT of a parray-coordinator --http")
        scheme, host, port, prefix = found.groups()
        self._url = url.rstrip("/")
        self._prefix = (prefix or "").rstrip("/")
        self._host, self._port = host.strip("[]"), int(port) if port else None
        self._kind = http.client.HTTPSConnection if scheme == "https" else http.client.HTTPConnection
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self.patience = patience

    def json(self, method: str, path: str, body: Any = None, headers: Mapping[str, str] = {}) -> Any:
        """Returns the JSON of the answer. `body` is a Form, or an object that is sent as JSON."""
        return self._parsed(path, self.body(method, path, body, headers))

    def ask_once(self, path: str, patience: float) -> Any:
        """Returns the JSON of GET `path`. Waits for a server that does not answer only for `patience` seconds. Raises
        Busy if it has no room."""
        return self._parsed(path, self._repeat("GET", path, None, self._headers, patience, waits=False))

    def body(self, method: str, path: str, body: Any = None, headers: Mapping[str, str] = {}) -> bytes:
        """Returns the body of the answer. Repeats the request until an answer comes: all requests here are idempotent."""
        headers = {**self._headers, **headers}
        if body is not None and not isinstance(body, Form):
            body = json.dumps(body).encode()
            headers["Content-Type"] = "application/json"
        return self._repeat(method, path, body, headers, self.patience)

    def _parsed(self, path: str, answer: bytes) -> Any:
        try:
            return json.loads(answer)
        except ValueError as error:
            raise RenderError(
                f"{self._url}{path}: the answer is not JSON: check that this is the address of parray-coordinator --http"
            ) from error

    def _repeat(
        self, method: str, path: str, body: Any, headers: Mapping[str, str], patience: float, waits: bool = True
    ) -> bytes:
        """Repeats the request until an answer comes, at most for `patience` seconds. `waits`: also repeats it if the server
        has no room; otherwise raises Busy then."""
        end = time.monotonic() + patience
        pause = 0.1
        while True:
            last = time.monotonic() + pause > end
            try:
                status, answer = self._ask(method, path, body, headers)
            except (OSError, http.client.HTTPException) as error:
                if last:
                    raise RenderError(
                        f"no answer from {self._url} for {patience:g} s ({error or type(error).__name__}): "
                        "check that parray-coordinator --http listens there"
                    ) from error
            else:
                if status < 300:
                    return answer
                problem = _problem(status, answer, self._url + path)
                if status == 503 and not waits:
                    raise Busy(str(problem))
                if status != 503 or last:
                    raise problem
            time.sleep(pause)
            pause = min(2 * pause, 2)

    def _ask(self, method: str, path: str, body: Any, headers: Mapping[str, str]) -> tuple[int, bytes]:
        """Returns status and body of the answer. Does not follow redirections, because a token is for one server."""
        with closing(self._kind(self._host, self._port, timeout=_TIMEOUT)) as connection:
            # A server may answer and close the connection before it has read the whole request.
            with suppress(BrokenPipeError, ConnectionResetError):
                connection.request(method, self._prefix + path, body, headers)
            answer = connection.getresponse()
            return answer.status, answer.read()


def _problem(status: int, answer: bytes, url: str) -> ParRayError:
    """Returns, but does not raise, the exception for the problem that the server describes (RFC 9457)."""
    try:
        problem = json.loads(answer)
    except ValueError:
        problem = None
    if not isinstance(problem, dict) or not problem.get("detail"):
        return RenderError(f"{url}: status {status}")
    return (InputError if problem.get("exit_status") == 2 else RenderError)(str(problem["detail"]))
