"""The comment of the GitHub Action: one on the pull request for each name of a gate, made by the first run, written anew by later ones."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

LONGEST = 60_000
"""Characters; a comment has at most 65,536."""

PAGES = 30


def main(given: Mapping[str, str]) -> int:
    """Write the comment. Where that fails, the job goes on: the gate has been judged already."""
    event = json.loads(Path(given["GITHUB_EVENT_PATH"]).read_text("utf-8"))
    number = event.get("pull_request", {}).get("number")
    if not isinstance(number, int):
        print("This run is of no pull request, so that there is nothing to comment on.")
        return 0
    try:
        print(f"The comment was {written(given, number)}.")
    except (OSError, ValueError, KeyError, TypeError) as error:
        code = error.code if isinstance(error, HTTPError) else None
        hint = "; it needs `pull-requests: write`, which a pull request from a fork never has" if code in (401, 403, 404) else ""
        print(f"::warning title=Fairness gate::The comment could not be written: {f'HTTP {code}' if code else type(error).__name__}{hint}")
    return 0


def written(given: Mapping[str, str], number: int) -> str:
    """Make the comment, or write the one that is there anew."""
    marker = f"<!-- fairness-gate {sha256(given.get('GATE_NAME', '').encode()).hexdigest()[:16]} -->"
    body = {"body": f"{marker}\n{fitted(Path(given['GATE_SUMMARY']).read_text('utf-8'), link(given))}"}
    issues = f"/repos/{given['GITHUB_REPOSITORY']}/issues"
    mine = login(given)
    for found in comments(given, f"{issues}/{number}/comments"):
        user = found.get("user") or {}
        own = user.get("type") == "Bot" if mine is None else user.get("login") == mine
        if own and str(found.get("body", "")).startswith(marker):
            asked(given, "PATCH", f"{issues}/comments/{int(found['id'])}", body)
            return "updated"
    asked(given, "POST", f"{issues}/{number}/comments", body)
    return "made"


def login(given: Mapping[str, str]) -> str | None:
    """Who the token is of; None for an app, such as the one of workflows, which may not ask."""
    try:
        return str(asked(given, "GET", "/user")["login"])
    except HTTPError:
        return None


def comments(given: Mapping[str, str], path: str) -> Iterator[dict[str, Any]]:
    """All comments, page by page."""
    for page in range(1, PAGES + 1):
        found = asked(given, "GET", f"{path}?per_page=100&page={page}")
        yield from found
        if len(found) < 100:
            return


def asked(given: Mapping[str, str], method: str, path: str, body: Mapping[str, str] | None = None) -> Any:
    """Ask the interface of the server."""
    headers = {
        "Authorization": f"Bearer {given['GITHUB_TOKEN']}",
        "Accept": "application/vnd.github+json",
        "Content-Type": "application/json",
        "X-GitHub-Api-Version": "2022-11-28",
    }
    data = None if body is None else json.dumps(body).encode("utf-8")
    request = Request(given["GITHUB_API_URL"] + path, data=data, headers=headers, method=method)  # noqa: S310
    with urlopen(request, timeout=30) as answer:  # noqa: S310
        return json.load(answer)


def link(given: Mapping[str, str]) -> str:
    """Where certificate and page are kept."""
    run = f"{given['GITHUB_SERVER_URL']}/{given['GITHUB_REPOSITORY']}/actions/runs/{given['GITHUB_RUN_ID']}"
    return f"\n\n[Certificate and page]({run}) are kept with the run.\n"


def fitted(text: str, end: str) -> str:
    """The lines that fit into a comment, and the end."""
    if len(text) <= LONGEST:
        return text + end
    kept = text[:LONGEST].rpartition("\n")[0]
    return f"{kept}\n\n{'</details>' if '<details>' in kept else ''}\n\n…{end}"


if __name__ == "__main__":
    sys.exit(main(os.environ))
