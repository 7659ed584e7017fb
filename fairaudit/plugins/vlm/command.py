"""`fairaudit experiment list|run|status|certify|plot`. Imports nothing heavy before it runs.

Each action answers as it goes, of `run` for each decision maker; as JSON an answer is one line.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli import plugins
from fairaudit.cli.options import add_command, add_limits, confidence_option, given_limits
from fairaudit.cli.output import Answer, add_format, note
from fairaudit.errors import InputError, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from fairaudit.plugins.vlm.experiment import Experiment, Model
    from fairaudit.plugins.vlm.journal import Journal
    from fairaudit.plugins.vlm.report import Found

HELP = "ask a language model, keep every answer, and certify what it does"
EXTENSIONS = "fairaudit.experiment_commands"
DESCRIPTION = """\
Run an experiment on a language model or an embedded decision maker: an experiment file says who stands in which slot, what is asked,
through which filters, and how often. Every answer is kept before it is read, so that a run can be stopped and resumed at any moment and
pays for nothing twice; the end is a certificate. Everything is kept in one folder, named after the experiment."""
EPILOG = """\
exit codes: 0 done, and of certify within the targets; 1 of certify: a target is exceeded; 2 bad input; 3 of run and status: answers are
missing, of certify: inconclusive

examples:
  fairaudit experiment list
  fairaudit experiment plot epsilon-a                      runs the embedded decision maker, certifies, draws
  fairaudit experiment run my.toml --dry-run               how many calls, how many tokens, what cost
  OPENAI_API_KEY=… fairaudit experiment run document-delivery --base-url https://api.openai.com/v1 --model gpt-4o --max-cost 5"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "experiment", None, HELP, DESCRIPTION, EPILOG)
    actions = parser.add_subparsers(metavar="ACTION", required=True, parser_class=type(parser))
    listing = actions.add_parser("list", help="experiment files that ship with fairaudit", allow_abbrev=False)
    listing.set_defaults(run=_list)
    add_format(listing)
    for name, work, said in (
        ("run", _run, "ask what has no answer yet"),
        ("status", _status, "what has been asked, answered and spent"),
        ("certify", _certify, "tables, certificates and verdicts from the answers"),
        ("plot", _plot, "draw the figure, after running and certifying what is missing (embedded decision makers only)"),
    ):
        action = actions.add_parser(name, help=said, description=said[0].upper() + said[1:] + ".", allow_abbrev=False)
        action.set_defaults(run=work)
        _options(action, name)
    for extension in plugins(EXTENSIONS):
        extension.add(actions)


def _answer(action: str, result: dict[str, Any], text: Callable[[], str] | None = None, **rest: Any) -> Answer:
    from fairaudit.plugins.vlm.report import filled_text

    return Answer("experiment", result=lambda: {"action": action, **result}, text=text or (lambda: filled_text(action, **result)), **rest)


OUTPUT = {
    "certify": ("DIR", "where tables and certificates go (default: the folder of the journal)"),
    "plot": ("FILE", "where the figure goes: .png, .svg or .pdf (default: figure.png in the folder of the journal)"),
}


def _options(action: argparse.ArgumentParser, name: str) -> None:
    add_format(action)
    action.add_argument("file", metavar="FILE", help="experiment file (.toml), or the name of one that ships with fairaudit")
    action.add_argument(
        "--folder", metavar="DIR", help="where journal, tables, certificates and figure are (default: the experiment's name)"
    )
    action.add_argument("--trials", metavar="N", type=int, help="answers per cell, instead of the number in the file")
    who = action.add_argument_group("decision maker (default: the models in the file)")
    who.add_argument("--model", metavar="NAME", help="one of the file, or with --base-url any model there")
    who.add_argument("--base-url", metavar="URL", help="OpenAI-compatible endpoint, such as http://localhost:8000/v1")
    who.add_argument("--key-env", metavar="NAME", help="environment variable that holds the key (default OPENAI_API_KEY)")
    who.add_argument("--maker", choices=("stand-in", "minilm"), help="an embedded decision maker instead")
    if name in ("run", "plot"):
        spending = action.add_argument_group("limits")
        spending.add_argument("--requests-per-minute", metavar="N", type=float)
        spending.add_argument("--tokens-per-minute", metavar="N", type=float)
        spending.add_argument("--concurrency", metavar="N", type=int, help="requests in flight at the most (default 4)")
        spending.add_argument("--timeout", metavar="S", type=float, help="seconds for one answer (default 120)")
        spending.add_argument("--retries", metavar="N", type=int, help="attempts after the first one (default 6)")
        spending.add_argument("--price-input", metavar="P", type=float, help="price of a million tokens sent")
        spending.add_argument("--price-output", metavar="P", type=float, help="price of a million tokens received")
        spending.add_argument("--max-cost", metavar="M", type=float, help="stop before this is spent, in the currency of the prices")
        spending.add_argument("--max-tokens", metavar="N", type=int, help="stop before this many tokens are spent")
    if name == "run":
        action.add_argument(
            "--ask-again", action="store_true", help="ask again what met with faults of the server only (web pages, cut replies, …)"
        )
        spending.add_argument(
            "--max-unreadable", metavar="N", type=int, default=20,
            help="stop, or ask on a terminal, after so many answers in a row that choose nothing (default 20; 0: never)",
        )  # fmt: skip
        action.add_argument(
            "--dry-run", action="store_true", help="say how many calls, tokens and what cost, and show a prompt; ask nothing"
        )
    if name in ("certify", "plot"):
        action.add_argument("--confidence", metavar="C", help="confidence of intervals (default 0.95); 'none' judges the table itself")
        action.add_argument("-o", "--output", metavar=OUTPUT[name][0], help=OUTPUT[name][1])
    if name == "certify":
        add_limits(action.add_argument_group("targets (by default those of the file)"))


def _list(arguments: argparse.Namespace) -> Iterator[Answer]:  # noqa: ARG001
    from fairaudit.plugins.vlm.experiment import bundled, read_experiment

    found = [(name, read_experiment(name)) for name in bundled()]
    yield _answer(
        "list",
        {"experiments": [{"name": name, "title": entry.title, "source": entry.source} for name, entry in found]},
        sentence=f"{len(found)} experiments ship with fairaudit.",
    )


def _models(experiment: Experiment, arguments: argparse.Namespace) -> list[Model]:
    """The models that the options name, with what they say instead of the file."""
    from dataclasses import fields

    from fairaudit.plugins.vlm.experiment import Model, with_overrides

    changes = {entry.name: getattr(arguments, entry.name, None) for entry in fields(Model) if entry.name not in ("name", "maker")}
    found = [model for model in experiment.models if arguments.model in (None, model.name)]
    if arguments.maker is not None:
        if arguments.base_url or arguments.model:
            raise InputError("--maker goes without --model and --base-url; it is a decision maker of its own")
        found = [Model(arguments.maker, arguments.maker)]
    elif arguments.base_url is not None:
        if arguments.model is None:
            raise InputError("--base-url needs --model NAME, the model to ask there")
        known = [model for model in found if model.maker == "endpoint"]
        found = known[:1] or [Model(arguments.model, base_url=arguments.base_url)]
    elif not found:
        listed = [m.name for m in experiment.models]
        raise InputError(
            f"the file has no model {arguments.model!r}; {nearest(arguments.model, listed)}"
            if arguments.model
            else "the file has no [[model]]; name one with --base-url and --model, or --maker stand-in"
        )
    return [with_overrides(model, changes) for model in found]


def _open(arguments: argparse.Namespace, *, create: bool) -> tuple[Experiment, Path, Journal]:
    from fairaudit.plugins.vlm.experiment import read_experiment
    from fairaudit.plugins.vlm.journal import Journal

    experiment = read_experiment(arguments.file, trials=arguments.trials)
    folder = Path(arguments.folder or experiment.name)
    if create:
        _made(folder)
    return experiment, folder, Journal(folder / "journal.sqlite", experiment.digest, experiment.trials, create=create)


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"the folder {folder} cannot be made: {error.strerror}") from None
    return folder


def _run(arguments: argparse.Namespace) -> Iterator[Answer]:
    from fairaudit.plugins.vlm.run import Budget, run

    if arguments.dry_run:
        yield _dry_run(arguments)
        return
    experiment, folder, journal = _open(arguments, create=True)
    code = 0
    with journal:
        models = _models(experiment, arguments)
        journal.claim()
        for model in models:
            report = run(
                experiment, model, journal, budget=Budget(arguments.max_cost, arguments.max_tokens),
                ask_again=arguments.ask_again, max_unreadable=arguments.max_unreadable, go_on=_go_on,
            )  # fmt: skip
            code = code if report.complete else 3
            path = f"{folder}/journal.sqlite"
            result = {"model": model.key, "journal": path, **vars(report), "notes": list(report.notes.values())}
            said = f"{model.key}: {report.answered} of {report.total} answers are in {path}."
            yield _answer("run", result, sentence=said, code=code)


def _go_on(why: str) -> bool:
    """Ask on a terminal whether to go on; elsewhere nobody is there to say so."""
    from fairaudit.words import plain

    if not (sys.stdin and sys.stdin.isatty() and sys.stderr.isatty()):
        return False
    print(f"\n{plain(why)}\nGo on all the same? [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _dry_run(arguments: argparse.Namespace) -> Answer:
    from fairaudit.plugins.vlm.experiment import read_experiment
    from fairaudit.plugins.vlm.journal import Journal
    from fairaudit.plugins.vlm.run import estimate

    experiment = read_experiment(arguments.file, trials=arguments.trials)
    path = Path(arguments.folder or experiment.name) / "journal.sqlite"
    journal = Journal(path, experiment.digest, experiment.trials, create=False) if path.is_file() else None
    cells = experiment.cells()
    listed = [estimate(experiment, model, journal) for model in _models(experiment, arguments)]
    system, user = experiment.prompt(*cells[0])
    pictures = [(option, str(picture)) for option, picture in experiment.pictures(cells[0][0])]
    return _answer(
        "dry-run",
        {"models": listed, "prompts": len(cells), "first_prompt": {"system": system, "user": user, "images": pictures}},
        sentence=f"{sum(entry['calls'] for entry in listed)} calls, of which nothing was asked now.",
    )


def _status(arguments: argparse.Namespace) -> Iterator[Answer]:
    experiment, folder, journal = _open(arguments, create=False)
    with journal:
        models = [_state_of(experiment, journal, model) for model in journal.models()]
        fates = journal.unknown_fate()
        unknown = [f"{e['request'][:12]} trial {e['trial']} of {shown(e['model'])}, sent {e['moment']}: {e['result']}" for e in fates]
    complete = all(found["answered"] == found["total"] for found in models)
    yield _answer(
        "status",
        {
            "experiment": experiment.title,
            "digest": experiment.digest,
            "journal": f"{folder}/journal.sqlite",
            "trials": experiment.trials,
            "models": models,
            "unknown_fate": unknown,
        },
        sentence=f"{sum(m['answered'] for m in models)} of {sum(m['total'] for m in models)} questions have an answer.",
        code=0 if complete else 3,
    )


def _state_of(experiment: Experiment, journal: Journal, model: str) -> dict[str, Any]:
    """What has been asked of a decision maker, answered and spent."""
    from fairaudit.plugins.vlm.analyse import tables

    total, done = journal.size(model)
    tokens, cost, lost = journal.spent(model)
    return {
        "model": model,
        "answered": done,
        "total": total,
        "tokens": tokens,
        "cost": cost,
        "answers": [
            {"setting": None if table.setting < 0 else table.setting + 1, "kinds": dict(sorted(table.kinds.items())), "note": table.note}
            for table in (tables(experiment, journal, model) if done else [])
        ],
        "attempts": {result: n for result, n in journal.attempt_results(model).items() if result != "answered"},
        "lost": lost,
        "faults": journal.unanswered_faults(model),
    }


def _certify(arguments: argparse.Namespace) -> Iterator[Answer]:
    from fairaudit.plugins.vlm.report import said

    experiment, folder, journal = _open(arguments, create=False)
    with journal:
        into = _made(Path(arguments.output)) if arguments.output else folder
        found = _certified(experiment, arguments, journal, into, given_limits(arguments) or None)
    code = {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3, "depends": 3}[found.verdict]
    yield _found(found, "certify", lambda: said(found), code=code)


def _found(found: Found, action: str, text: Callable[[], str] | None = None, code: int = 0, **more: Any) -> Answer:
    """All figures, and which decision makers were asked and gave no answer, with how to ask them."""
    from fairaudit.plugins.vlm.report import figures

    models = len({model for model, _, _ in found.findings})
    judged = "no target was set" if found.verdict == "none" else f"the verdict is {found.verdict}"
    said = f"{found.experiment.title}: {len(found.findings)} findings about {models} decision maker{'s' * (models > 1)}; {judged}."
    left_out = [f"{model} has no answers and is left out; run with its --model and --base-url asks again" for model in found.silent]
    result = {**figures(found), "written": found.written, **more}
    return _answer(action, result, text, verdict=found.verdict, sentence=said, notes=left_out, code=code)


def _plot(arguments: argparse.Namespace) -> Iterator[Answer]:
    from fairaudit.plugins.vlm.makers import embedded
    from fairaudit.plugins.vlm.plot import check_picture, draw
    from fairaudit.plugins.vlm.run import run

    picture = check_picture(Path(arguments.output)) if arguments.output else None
    experiment, folder, journal = _open(arguments, create=True)
    with journal:
        if not journal.models() or arguments.maker or arguments.model:
            journal.claim()
            makers = [model for model in _models(experiment, arguments) if model.maker != "endpoint"]
            for model in makers:
                try:
                    embedded(experiment, model)
                except InputError as error:
                    if len(makers) == 1 or model.maker != "minilm":
                        raise
                    note(f"the figure leaves {model.name} out: {error}")
                    continue
                run(experiment, model, journal)
        found = _certified(experiment, arguments, journal, folder)
    yield _found(found, "plot", figure=draw(experiment, found, picture or folder / "figure.png"))


def _certified(experiment: Experiment, arguments: argparse.Namespace, journal: Journal, folder: Path, targets: Any = None) -> Found:
    from fairaudit.plugins.vlm.report import certify_all

    wanted = journal.models()
    if arguments.model is not None or arguments.maker is not None or arguments.base_url is not None:
        named = [model.key for model in _models(experiment, arguments)]
        wanted = [key for key in wanted if key in named]
    return certify_all(experiment, journal, wanted, folder, confidence=confidence_option(arguments.confidence), targets=targets)
