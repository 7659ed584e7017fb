"""A client for OpenAI-compatible endpoints: limits that are kept, retries that are recorded, keys that go nowhere but to the server."""

from __future__ import annotations

import asyncio
import base64
import email.utils
import json
import random
import re
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from fairaudit.errors import InputError, shown
from fairaudit.libraries import library
from fairaudit.plugins.vlm.answers import answer_schema
from fairaudit.plugins.vlm.experiment import Experiment, Model, environment_key
from fairaudit.plugins.vlm.images import image_name
from fairaudit.plugins.vlm.tokens import CAPS
from fairaudit.tables.evaluations.replies import explanation, fault, parsed

if TYPE_CHECKING:
    from httpx import AsyncClient

__all__ = ["Bucket", "Client", "Failure", "Reply", "key_pattern", "request_body", "retry_after"]

BACKOFF = 0.5
RETRIED = frozenset({408, 409, 425, 429})
MAYBE_PAID = frozenset({408, 502, 504, 520, 524})
MAX_BODY = 10_000_000
SECRET = 8
OTHER_NAME = re.compile(rb"(?i)unsupported|not (?:supported|permitted|allowed)|unrecogni|unknown|instead")
TICK = 1e-6
WITHHELD = b'{"error": {"message": "what came held the key in such a way that the key cannot be cut out of it, and is not kept"}}'


@dataclass(frozen=True)
class Reply:
    """An answer, or a refusal, as it came."""

    status: int
    content_type: str
    body: bytes


@dataclass(frozen=True)
class Failure:
    """No answer.

    `why` has the server's own words after a semicolon; `lost`: it may have been paid for although nothing came; `again`: whether another
    attempt can help; `wait`: how long the server asks to wait; `reply`: what came instead of an answer, with a status of success.
    """

    why: str
    lost: bool = False
    again: Literal["later", "now", "never"] = "later"
    wait: float = 0.0
    reply: Reply | None = None


class Bucket:
    """A token bucket: in any minute at most `per_minute` are let through, however they arrive.

    It holds at most a sixtieth of the limit (or `largest`, one request), and refills by what is left of the limit.
    """

    def __init__(self, per_minute: float | None, largest: float = 1.0, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._size = max(largest, (per_minute or 0) / 60)
        self._rate = None if per_minute is None else (per_minute - self._size) / 60
        if self._rate is not None and self._rate <= 0:
            raise InputError(f"a limit of {per_minute:g} per minute is less than two requests need; raise it")
        self._level, self._then = self._size, clock()
        self._blocked_until = 0.0
        self._queue = asyncio.Lock()

    def block(self, seconds: float) -> None:
        """Let nothing through for some time, because the server said so."""
        self._blocked_until = max(self._blocked_until, self._clock() + seconds)

    async def take(self, amount: float = 1.0) -> None:
        """Wait until `amount` is there, in the order of arrival, and take it."""
        async with self._queue:
            while True:
                now = self._clock()
                pause = self._blocked_until - now
                if self._rate is not None:
                    self._level = min(self._size, self._level + (now - self._then) * self._rate)
                    self._then = now
                    pause = max(pause, (min(amount, self._size) - self._level) / self._rate)
                if pause <= 0:
                    self._level -= amount if self._rate is not None else 0.0
                    return
                await asyncio.sleep(pause + TICK)


class Client(AsyncExitStack):
    """One endpoint, used as an asynchronous context manager.

    `meaning` gives what a reply decides: the key is not cut out of a reply that would then decide something else.
    """

    def __init__(self, model: Model, meaning: Callable[[Reply], object]) -> None:
        super().__init__()
        httpx = library("httpx", "vlm")
        self.model, self._meaning = model, meaning
        self._key = environment_key(model)
        if not self._key.isprintable() or not self._key.isascii():
            raise InputError(f"the environment variable {model.key_env} does not hold a key: keys are printable ASCII")
        self._pattern = key_pattern(self._key)
        self._names = dict(zip(CAPS, CAPS, strict=True))
        try:
            self._http: AsyncClient = httpx.AsyncClient(
                timeout=httpx.Timeout(model.timeout),
                limits=httpx.Limits(max_connections=model.concurrency),
                headers={"Authorization": f"Bearer {self._key}", "User-Agent": "fairaudit"},
            )
        except (ImportError, ValueError, httpx.InvalidURL) as error:
            raise InputError(f"the proxy that the environment names cannot be used: {self._clean(error)}") from None
        self.push_async_callback(self._http.aclose)

    async def send(self, body: Mapping[str, Any], name: str) -> Reply | Failure:
        """Send a request once; `name` goes along as its idempotency key, so that a server that knows such keys answers a retry for free."""
        import httpx

        url = self.model.base_url.rstrip("/") + "/chat/completions"
        named = {self._names.get(key, key): value for key, value in body.items()}
        content = json.dumps(named, ensure_ascii=False, separators=(",", ":")).encode()
        headers = {"Content-Type": "application/json", "Idempotency-Key": name}
        try:
            async with asyncio.timeout(self.model.timeout), self._http.stream("POST", url, content=content, headers=headers) as answer:
                received = bytearray()
                async for chunk in answer.aiter_bytes():
                    received += chunk
                    if len(received) > MAX_BODY:
                        return Failure(f"a reply of more than {MAX_BODY} bytes", lost=True)
        except (httpx.ConnectError, httpx.ConnectTimeout, httpx.PoolTimeout, httpx.UnsupportedProtocol) as error:
            return Failure(f"no connection; {self._clean(error)}")
        except (httpx.TimeoutException, TimeoutError):
            return Failure(f"no complete answer within {self.model.timeout:g} s", lost=True)
        except (httpx.InvalidURL, ValueError, OverflowError) as error:
            return Failure(f"the address cannot be used; {self._clean(error)}", again="never")
        except (httpx.HTTPError, httpx.StreamError) as error:
            return Failure(f"the connection broke; {self._clean(error)}", lost=True)
        kind, where = (self._clean(answer.headers.get(name, "")) for name in ("content-type", "location"))
        raw = Reply(answer.status_code, kind, bytes(received))
        reply = Reply(raw.status, kind, self.redact(raw.body))
        if self._spelled(reply.body) or (reply.body != raw.body and self._meaning(reply) != self._meaning(raw)):
            reply = Reply(raw.status, "application/json", WITHHELD)
        return self._judged(reply, retry_after(answer.headers.get("retry-after")), where)

    def _judged(self, reply: Reply, wait: float, where: str) -> Reply | Failure:
        wrong = fault(reply.status, reply.content_type, reply.body)
        if not wrong:
            return reply
        said = f"it redirects to {shown(where, 200)}" if 300 <= reply.status < 400 and where else explanation(reply.body)
        why = f"{wrong}; {said}" if said else wrong
        if 200 <= reply.status < 300:
            return Failure(why, wait=wait, reply=reply)
        other = any(cap.encode() in reply.body for cap in CAPS) and OTHER_NAME.search(reply.body)
        if reply.status in (400, 422) and other and self._names[CAPS[0]] == CAPS[0]:
            self._names = dict(zip(CAPS, reversed(CAPS), strict=True))
            return Failure(why, again="now")
        again = (reply.status in RETRIED or reply.status >= 500) and b"insufficient_quota" not in reply.body
        return Failure(why, lost=reply.status in MAYBE_PAID, again="later" if again else "never", wait=wait)

    def redact(self, raw: bytes) -> bytes:
        """A text of the server without the key, should it repeat it."""
        return raw if self._pattern is None else self._pattern.sub(b"[key]", raw)

    def _spelled(self, body: bytes) -> bool:
        """Whether pieces of a reply spell the key when they are put together: parts of a content, or events of a stream."""
        if self._pattern is None:
            return False
        pieces: defaultdict[str, list[str]] = defaultdict(list)

        def walk(value: Any, name: str) -> None:
            if isinstance(value, dict):
                for key, entry in value.items():
                    walk(entry, key)
            elif isinstance(value, list):
                for entry in value:
                    walk(entry, name)
            elif isinstance(value, str):
                pieces[name].append(value)

        for text in (body, *(line.removeprefix(b"data:") for line in body.splitlines() if line.startswith(b"data:"))):
            try:
                walk(parsed(text), "")
            except (ValueError, RecursionError):
                continue
        return any(self._pattern.search("".join(found).encode("utf-8", "replace")) for found in pieces.values() if len(found) > 1)

    def _clean(self, said: Exception | str) -> str:
        text = said if isinstance(said, str) else str(said) or type(said).__name__
        return self.redact(text.encode("utf-8", "replace")).decode("utf-8", "replace")


def key_pattern(key: str) -> re.Pattern[bytes] | None:
    """What finds a key in a text; None for a key of less than 8 characters, which cannot be told from a word.

    It finds it as it is, in hexadecimal digits and in base64; each character may be escaped for JSON, a URL or HTML, lines may be broken
    anywhere, and the end of the text may cut it off.

    Examples
    --------
    >>> key_pattern("sk-secret-12").sub(b"[key]", b'{"a": "sk-secret-12", "b": "sk%2Dsecret%2D12", "c": "c2stc2VjcmV0LTEy"}')
    b'{"a": "[key]", "b": "[key]", "c": "[key]"}'
    >>> key_pattern("none")
    """
    if len(key) < SECRET:
        return None
    forms = [key, key.encode().hex()]
    for before in range(3):
        coded = base64.b64encode(b" " * before + key.encode()).decode()
        forms.append(coded[(0, 2, 3)[before] : (before + len(key)) * 8 // 6])
    return re.compile("|".join(map(_written, forms)).encode(), re.IGNORECASE)


def _written(form: str) -> str:
    broken = r"(?:[\s\0]|\\{1,8}[nrt]|%0[ad]){0,8}"
    pieces = []
    for char in form:
        other = {"+": "-", "/": "_"}.get(char, "")
        code = f"{ord(char):02x}"
        pieces.append(
            rf"(?:\\{{0,8}}[{re.escape(char + other)}]|\\{{1,8}}u00{code}|%(?:25)?{code}|&#0{{0,4}}{ord(char)};|&#x0{{0,4}}{code};)"
        )
    return pieces[0] + "".join(f"{broken}{piece}" if i < SECRET else rf"(?:{broken}{piece}|\Z)" for i, piece in enumerate(pieces) if i)


def retry_after(header: str | None) -> float:
    """Seconds that a server asks to wait, from a number or a date; 0 if it does not say.

    Examples
    --------
    >>> retry_after("1.5"), retry_after("86400"), retry_after("soon"), retry_after(None), retry_after("-3")
    (1.5, 86400.0, 0.0, 0.0, 0.0)
    """
    if header is None:
        return 0.0
    try:
        seconds = float(header)
    except ValueError:
        try:
            seconds = email.utils.parsedate_to_datetime(header).timestamp() - time.time()
        except (ValueError, TypeError, OverflowError):
            return 0.0
    return max(0.0, seconds) if seconds == seconds else 0.0


def pause_before(retry: int, asked: float) -> float:
    """How long to wait before a retry: exponential with full jitter above a half, and never less than the server asks."""
    backoff: float = min(60.0, BACKOFF * 2**retry)
    return max(asked, backoff * random.uniform(0.5, 1.0))  # noqa: S311


def request_body(experiment: Experiment, model: Model, context: str, slots: tuple[tuple[str, ...], ...]) -> dict[str, Any]:
    """The body of a request; images are named by their SHA-256, as the journal keeps them."""
    system, user = experiment.prompt(context, slots)
    content: list[dict[str, Any]] = [{"type": "text", "text": user}]
    for option, path in experiment.pictures(context):
        picture = {"type": "image_url", "image_url": {"url": image_name(path)}}
        content += [{"type": "text", "text": f"Image for {option}:"}, picture]
    body: dict[str, Any] = {"model": model.name}
    body["messages"] = [{"role": "system", "content": system}] if system else []
    body["messages"].append({"role": "user", "content": user if len(content) == 1 else content})
    if experiment.answer in ("json", "choice") and model.structured:
        schema = {"name": "choice", "strict": True, "schema": answer_schema(experiment)}
        body["response_format"] = {"type": "json_schema", "json_schema": schema}
    if experiment.answer == "logprobs":
        body |= {"logprobs": True, "top_logprobs": 20, "max_tokens": 1, "temperature": 1}
    return body | dict(model.parameters)
