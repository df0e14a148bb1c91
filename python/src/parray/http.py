"""Requests to a coordinator: repeated until answered, problems as exceptions, forms streamed from disk."""

from __future__ import annotations

import http.client
import json
import time
import urllib.error
import urllib.request
import uuid
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any, NoReturn, Optional, Union

from .errors import InputError, RenderError

_TIMEOUT = 60  # seconds of silence in one request


class Form:
    """multipart/form-data (RFC 7578), whose files are read while they are sent. Iterated once for each try."""

    def __init__(self) -> None:
        self._boundary = uuid.uuid4().hex
        self._parts: list[tuple[bytes, Union[bytes, Path]]] = []

    def text(self, name: str, value: bytes, content_type: str) -> None:
        self._add(f'name="{name}"', content_type, value)

    def file(self, name: str, path: Path) -> None:
        """`name`: letters, digits, '.', '_' and '-'."""
        if not path.is_file():
            raise InputError(f"{path}: no such file: check the path")
        self._add(f'name="file"; filename="{name}"', "application/octet-stream", path)

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


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """A token is for the server that it was given for."""

    def redirect_request(
        self, req: urllib.request.Request, fp: IO[bytes], code: int, msg: str, headers: Any, newurl: str
    ) -> None:
        return None


class Http:
    def __init__(self, url: str, token: Optional[str], patience: float) -> None:
        if not url.startswith(("http://", "https://")):
            raise InputError(f"{url}: give http://HOST:PORT or https://HOST:PORT, as parray-coordinator --http has it")
        self._url = url.rstrip("/")
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._patience = patience
        self._opener = urllib.request.build_opener(_NoRedirect)

    def json(self, method: str, path: str, body: Any = None, headers: Mapping[str, str] = {}) -> Any:
        """`body`: a Form, or what becomes JSON."""
        return json.loads(self.bytes(method, path, body, headers))

    def bytes(self, method: str, path: str, body: Any = None, headers: Mapping[str, str] = {}) -> bytes:
        """The answer's body. Every request here may be repeated: again and again, the same comes of it."""
        headers = {**self._headers, **headers}
        if body is not None and not isinstance(body, Form):
            body = json.dumps(body).encode()
            headers["Content-Type"] = "application/json"
        end = time.monotonic() + self._patience
        pause = 0.1
        while True:
            try:
                request = urllib.request.Request(self._url + path, body, headers, method=method)
                with self._opener.open(request, timeout=_TIMEOUT) as answer:
                    data: bytes = answer.read()
                    return data
            except urllib.error.HTTPError as error:
                problem = _problem(error)
                if error.code != 503 or time.monotonic() + pause > end:
                    _fail(problem, error)
            except (OSError, http.client.HTTPException) as error:
                if time.monotonic() + pause > end:
                    reason = getattr(error, "reason", error)
                    raise RenderError(
                        f"no answer from {self._url} for {self._patience:g} s ({reason}): "
                        "does parray-coordinator --http listen there?"
                    ) from error
            time.sleep(pause)
            pause = min(2 * pause, 2)


def _problem(error: urllib.error.HTTPError) -> dict[str, Any]:
    """What the server says of it (RFC 9457)."""
    with error:
        try:
            problem = json.loads(error.read())
            return problem if isinstance(problem, dict) else {}
        except (OSError, ValueError, http.client.HTTPException):
            return {}


def _fail(problem: Mapping[str, Any], error: urllib.error.HTTPError) -> NoReturn:
    text = str(problem.get("detail") or f"{error.url}: status {error.code}, {error.reason}")
    raise (InputError if problem.get("exit_status") == 2 else RenderError)(text) from None
