"""A PostgreSQL server for tests, where there is one."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

import pytest
from logs import log


def absent(what: str) -> NoReturn:
    """Skip for want of a server, or fail where FAIRAUDIT_SERVERS=1 demands it."""
    if os.environ.get("FAIRAUDIT_SERVERS") == "1":
        pytest.fail(what)
    pytest.skip(what)


@pytest.fixture(scope="session")
def postgres() -> Iterator[str]:
    """URL of a server that was started for all tests, with the log in a table of two parts of a name."""
    folders = sorted(Path("/usr/lib/postgresql").glob("*/bin"), key=lambda path: int(path.parent.name) if path.parent.name.isdigit() else 0)
    found = shutil.which("initdb")
    if found is None and not folders:
        absent("PostgreSQL is not installed on this machine (initdb was not found)")
    psycopg = pytest.importorskip("psycopg", reason="psycopg is not installed")
    programs = Path(found).parent if found else folders[-1]
    user: dict[str, str] = {}
    folder = Path(tempfile.mkdtemp(prefix="fairaudit-postgres-"))
    if os.geteuid() == 0:  # the server refuses to run as root
        try:
            shutil.chown(folder, "postgres", "postgres")
        except LookupError:
            folder.rmdir()
            absent("PostgreSQL does not run as root, and there is no user postgres")
        user = {"user": "postgres", "group": "postgres"}
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    secret = folder / "secret"
    secret.write_text("a:secret\n")
    secret.chmod(0o644)

    def run(*words: str) -> None:
        subprocess.run([str(programs / words[0]), *words[1:]], check=True, capture_output=True, cwd="/", **user)  # type: ignore[call-overload]

    try:
        run(
            "initdb",
            "-D",
            f"{folder}/data",
            "-U",
            "auditor",
            "-A",
            "scram-sha-256",
            f"--pwfile={secret}",
            "--no-sync",
            "-E",
            "UTF8",
            "--locale=C",
        )
        options = f"-k {folder} -c listen_addresses=127.0.0.1 -p {port} -c fsync=off"
        run("pg_ctl", "-D", f"{folder}/data", "-w", "-l", f"{folder}/log", "-o", options, "start")
        url = f"postgresql://auditor:a%3Asecret@127.0.0.1:{port}/postgres"
        with psycopg.connect(url) as connection:
            connection.execute("create schema logs")
            connection.execute(
                'create table logs."Decisions" (answer text, sex text, dept text, age numeric(5, 1), run bigint, score float8)'
            )
            with connection.cursor() as cursor:
                cursor.executemany(
                    'insert into logs."Decisions" values (%(answer)s, %(sex)s, %(dept)s, %(age)s, %(run)s, %(age)s)',
                    log(),
                )
        yield url
    finally:
        with contextlib.suppress(subprocess.CalledProcessError):
            run("pg_ctl", "-D", f"{folder}/data", "-m", "immediate", "stop")
        shutil.rmtree(folder, ignore_errors=True)
