"""Who is answered: this computer's browser, from the page that this run served, and nobody else.

Written as plain ASGI, so that no request reaches the application before all checks.
"""

from __future__ import annotations

import asyncio
import hmac
import json
from collections.abc import Awaitable, Callable, MutableMapping
from contextlib import suppress
from typing import Any, Final

from symbody.builder.settings import BuilderSettings

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

TOKEN_HEADER: Final = "x-symbody-token"
_DRAINED: Final = 4  # times the size of a body, of one that is refused
DEEPEST: Final = 100  # levels of JSON
_POLICY: Final = "; ".join(
    (
        "default-src 'self'",
        "script-src 'self'",
        "style-src 'self' 'unsafe-inline'",  # libraries of diagrams and formulas place things by style=
        "img-src 'self' data: blob:",
        "font-src 'self' data:",
        "connect-src 'self'",
        "worker-src 'self' blob:",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
_NO_BRACKETS: Final = bytes(mark for mark in range(256) if mark not in b"[]{}")
_HEADERS: Final = (
    (b"content-security-policy", _POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
)


class LocalOnly:
    """An application behind all checks: Host, Origin, token, type, size, depth and time of a request."""

    def __init__(self, application: Application, settings: BuilderSettings) -> None:
        self._application = application
        self._settings = settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] == "lifespan":
            await self._application(scope, receive, send)
            return
        send_guarded = _with_headers(send)
        if scope["type"] != "http":
            await send_guarded({"type": "websocket.close", "code": 1008})
            return
        headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
        repeated = len(headers) < len(scope["headers"]) and _repeats(scope, b"host")
        refused = (400, "several Host headers") if repeated else self._refusal_of(scope, headers)
        if refused is not None:
            await self._drain(receive)
            await _refuse(send_guarded, *refused)
            return
        content = await self._content(receive, headers) if scope["method"] == "POST" else b""
        if isinstance(content, tuple):
            await _refuse(send_guarded, *content)
            return
        await self._application(scope, _replay(content, receive), send_guarded)

    def _refusal_of(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str] | None:
        """Return the status and the reason of a refusal by what stands in front of the body."""
        if headers.get("host", "").lower() not in self._settings.hosts:
            return 403, "the Host header names another computer"
        origin = headers.get("origin")
        if origin is not None and origin not in {f"http://{host}" for host in self._settings.hosts}:
            return 403, "the request comes from another page"
        site = headers.get("sec-fetch-site", "same-origin")
        if scope["method"] == "GET":
            is_entry = scope["path"] == "/" and headers.get("sec-fetch-mode", "navigate") == "navigate"
            return (
                None if is_entry or site in ("same-origin", "none") else (403, "it comes from another page")
            )
        if scope["method"] != "POST":
            return 405, f"the method {scope['method'][:20]} is not supported"
        return self._refusal_of_post(headers, site)

    def _refusal_of_post(self, headers: dict[str, str], site: str) -> tuple[int, str] | None:
        if site not in ("same-origin", "none"):
            return 403, "the request comes from another page"
        if headers.get("content-type", "").split(";")[0].strip().lower() != "application/json":
            return 415, "only application/json is accepted"
        token = headers.get(TOKEN_HEADER, "").encode("latin-1")
        if not hmac.compare_digest(token, self._settings.token.encode()):
            return 401, "the request has no token of this run: reload the page"
        length = headers.get("content-length", "0")
        if not length.isdecimal() or len(length) > 12 or int(length) > self._settings.limits.body:
            return 413, f"a request has at most {self._settings.limits.body} bytes"
        return None

    async def _drain(self, receive: Receive) -> None:
        """Take in a body that is refused, as far as it is not huge: who still sends hears no answer."""
        limits, count = self._settings.limits, 0
        with suppress(TimeoutError):
            async with asyncio.timeout(limits.receive):
                while count < _DRAINED * limits.body:
                    message = await receive()
                    count += len(message.get("body", b""))
                    if message["type"] == "http.disconnect" or not message.get("more_body", False):
                        return

    async def _content(self, receive: Receive, headers: dict[str, str]) -> bytes | tuple[int, str]:
        """Return the body, or status and reason of a refusal."""
        limits = self._settings.limits
        parts = bytearray()
        try:
            async with asyncio.timeout(limits.receive):
                while True:
                    message = await receive()
                    if message["type"] == "http.disconnect":
                        return 400, "the request was cut off"
                    parts += message.get("body", b"")
                    if len(parts) > limits.body:
                        await self._drain(receive)
                        return 413, f"a request has at most {limits.body} bytes"
                    if not message.get("more_body", False):
                        break
        except TimeoutError:
            return 408, "the request took too long to arrive"
        content = bytes(parts)
        return content if nesting_depth(content) <= DEEPEST else (400, "the request is nested too deeply")


def nesting_depth(content: bytes) -> int:
    """Return how many brackets are open at once in a JSON text.

    >>> nesting_depth(b'{"a": [[1], "[[[["]}')
    3
    """
    depth = deepest = 0
    for k, part in enumerate(content.replace(b"\\\\", b"").replace(b'\\"', b"").split(b'"')):
        if k % 2:
            continue  # inside quotes
        for mark in part.translate(None, _NO_BRACKETS):
            depth += 1 if mark in b"[{" else -1
            deepest = max(deepest, depth)
    return deepest


def _repeats(scope: Scope, name: bytes) -> bool:
    names: list[bytes] = [key for key, _ in scope["headers"]]
    return names.count(name) > 1


def _replay(content: bytes, receive: Receive) -> Receive:
    """Return what hands a body out that was received already."""
    messages = [{"type": "http.request", "body": content, "more_body": False}]

    async def replay() -> Message:
        return messages.pop() if messages else await receive()

    return replay


def _with_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            present = {name.lower() for name, _ in message.get("headers", ())}
            added = [(name, value) for name, value in _HEADERS if name not in present]
            if b"cache-control" not in present:
                added.append((b"cache-control", b"no-store"))
            message["headers"] = [*message.get("headers", ()), *added]
        await send(message)

    return send_with_headers


async def _refuse(send: Send, status: int, what: str) -> None:
    problem = {"severity": "error", "pointer": "", "element": "", "code": "builder.refused", "what": what,
               "why": "", "fix": "", "line": None, "repair": None}  # fmt: skip
    body = json.dumps({"problems": [problem]}).encode()
    headers = [
        (b"content-type", b"application/json"),
        (b"content-length", str(len(body)).encode()),
        (b"connection", b"close"),
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
