"""`fairaudit experiment run|status|certify|plot FILE`. Imports nothing heavy before it runs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from fairaudit.cli import plugins
from fairaudit.cli.options import add_limits, given_limits

if TYPE_CHECKING:
    from pathlib import Path

    from fairaudit.plugins.vlm.experiment import Experiment, Model
    from fairaudit.plugins.vlm.journal import Journal

HELP = "ask a language model, keep every answer, and certify what it does"
EXTENSIONS = "fairaudit.experiment_commands"
DESCRIPTION = """\
Run an experiment on a language model or an embedded decision maker: an experiment file says who stands in which slot, what is asked,
through which filters, and how often. Every answer is kept before it is read, so that a run can be stopped and resumed at any moment and
pays for nothing twice; the end is a certificate. Everything is kept in one folder, named after the experiment."""
EPILOG = """\
examples:
  fairaudit experiment list
  fairaudit experiment plot epsilon-a                      runs the embedded decision maker, certifies, draws
  fairaudit experiment run my.toml --dry-run               how many calls, how many tokens, what cost
  OPENAI_API_KEY=… fairaudit experiment run document-delivery --base-url https://api.openai.com/v1 --model gpt-4o --max-cost 5"""


def add(commands: Any) -> None:
    """Declare the options."""
    form = argparse.RawDescriptionHelpFormatter
    parser = commands.add_parser("experiment", help=HELP, description=DESCRIPTION, epilog=EPILOG, formatter_class=form, allow_abbrev=False)
    actions = parser.add_subparsers(metavar="ACTION", required=True, parser_class=type(parser))
    listing = actions.add_parser("list", help="experiment files that ship with fairaudit", allow_abbrev=False)
    listing.set_defaults(run=_list)
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


def _options(action: argparse.ArgumentParser, name: str) -> None:
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
            "--dry-run", action="store_true", help="say how many calls, tokens and what cost, and show a prompt; ask nothing"
        )
    if name in ("certify", "plot"):
        action.add_argument("--confidence", metavar="C", help="confidence of intervals (default 0.95); 'none' judges the table itself")
    if name == "certify":
        action.add_argument("--format", choices=("text", "json"), default="text", help="what to print")
        add_limits(action.add_argument_group("targets (by default those of the file)"))


def _list(arguments: argparse.Namespace) -> int:  # noqa: ARG001
    from fairaudit.plugins.vlm.experiment import bundled, read_experiment

    for name in bundled():
        found = read_experiment(name)
        print(f"{name}\n    {found.title}\n    {found.source}")
    return 0


def _models(experiment: Experiment, arguments: argparse.Namespace) -> list[Model]:
    """The models that the options name, with what they say instead of the file."""
    from fairaudit.errors import InputError, nearest
    from fairaudit.plugins.vlm.experiment import Model, with_overrides

    changes = {
        name: getattr(arguments, name, None)
        for name in (
            "key_env", "requests_per_minute", "tokens_per_minute", "concurrency", "timeout", "retries", "price_input", "price_output",
        )
    }  # fmt: skip
    if arguments.maker is not None:
        if arguments.base_url or arguments.model:
            raise InputError("--maker goes without --model and --base-url; it is a decision maker of its own")
        return [with_overrides(Model(arguments.maker, arguments.maker), changes)]
    if arguments.base_url is not None:
        if arguments.model is None:
            raise InputError("--base-url needs --model NAME, the model to ask there")
        known = [m for m in experiment.models if m.name == arguments.model and m.maker == "endpoint"]
        return [
            with_overrides(
                known[0] if known else Model(arguments.model, base_url=arguments.base_url), {**changes, "base_url": arguments.base_url}
            )
        ]
    found = [m for m in experiment.models if arguments.model in (None, m.name)]
    if not found:
        listed = [m.name for m in experiment.models]
        raise InputError(
            f"the file has no model {arguments.model!r}; {nearest(arguments.model, listed)}"
            if arguments.model
            else "the file has no [[model]]; name one with --base-url and --model, or --maker stand-in"
        )
    return [with_overrides(m, changes) for m in found]


def _open(arguments: argparse.Namespace, *, create: bool) -> tuple[Experiment, Path, Journal]:
    from fairaudit.errors import InputError
    from fairaudit.plugins.vlm.experiment import read_experiment
    from fairaudit.plugins.vlm.journal import Journal
    from fairaudit.plugins.vlm.run import folder_of

    experiment = read_experiment(arguments.file, trials=arguments.trials)
    folder = folder_of(experiment, arguments.folder)
    if create:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"the folder {folder} cannot be made: {error.strerror}") from None
    return experiment, folder, Journal(folder / "journal.sqlite", experiment.digest, experiment.trials, create=create)


def _run(arguments: argparse.Namespace) -> int:
    from fairaudit.plugins.vlm.run import Budget, run
    from fairaudit.words import plain

    if arguments.dry_run:
        return _dry_run(arguments)
    experiment, folder, journal = _open(arguments, create=True)
    code = 0
    with journal:
        models = _models(experiment, arguments)
        journal.claim()
        for model in models:
            report = run(experiment, model, journal, budget=Budget(arguments.max_cost, arguments.max_tokens))
            print(plain(f"{model.key}: {report.answered} of {report.total} answers are in {folder}/journal.sqlite"))
            if report.stopped:
                print(plain(f"  stopped: {report.stopped}; run again with a larger one to go on"))
            for line in report.unanswered[:5]:
                print(plain(f"  no answer: {line}"))
            if len(report.unanswered) > 5:
                print(f"  … and {len(report.unanswered) - 5} more; run again to ask them once more")
            code = code if report.complete else 3
    return code


def _dry_run(arguments: argparse.Namespace) -> int:
    from fairaudit.plugins.vlm.experiment import read_experiment
    from fairaudit.plugins.vlm.journal import Journal
    from fairaudit.plugins.vlm.run import estimate, folder_of
    from fairaudit.words import plain

    experiment = read_experiment(arguments.file, trials=arguments.trials)
    path = folder_of(experiment, arguments.folder) / "journal.sqlite"
    journal = Journal(path, experiment.digest, experiment.trials, create=False) if path.is_file() else None
    cells = experiment.cells()
    for model in _models(experiment, arguments):
        found = estimate(experiment, model, journal)
        print(plain(f"{found.model}: {found.calls} calls, {found.answered} of them answered already"))
        if model.maker == "endpoint":
            cost = f", at the most about {found.cost:.2f} in the currency of its prices" if model.price_input or model.price_output else ""
            print(f"  still about {found.input_tokens} tokens to send and at the most {found.output_tokens} to receive{cost}")
    system, user = experiment.prompt(*cells[0])
    print(f"\nThe first of {len(cells)} prompts")
    print("\n".join(f"  {plain(line)}" for line in f"{system}\n\n{user}".splitlines()))
    for option, picture in experiment.pictures(cells[0][0]):
        print(plain(f"  [image for {option}: {picture}]"))
    return 0


def _status(arguments: argparse.Namespace) -> int:
    from fairaudit.plugins.vlm.analyse import tables
    from fairaudit.plugins.vlm.journal import described
    from fairaudit.words import plain

    experiment, folder, journal = _open(arguments, create=False)
    complete = True
    with journal:
        print(plain(experiment.title))
        print(plain(f"  {folder}/journal.sqlite, {experiment.trials} answers per cell, experiment {experiment.digest[:12]}"))
        for model in journal.models():
            total, done = journal.size(model)
            tokens, cost, lost = journal.spent(model)
            complete = complete and total == done
            print(plain(f"{model}: {done} of {total} answered, {tokens} tokens, {cost:.4f} spent"))
            for table in tables(experiment, journal, model) if done else []:
                kinds = ", ".join(f"{n} {kind}" for kind, n in sorted(table.kinds.items()))
                print(f"  {'answers' if table.setting < 0 else f'setting {table.setting + 1}'}: {kinds}")
            results = ", ".join(f"{n} {plain(result)}" for result, n in journal.attempt_results(model).items() if result != "answered")
            if results:
                print(f"  attempts without an answer: {results}")
            if lost:
                print(f"  {lost} requests were sent and their answer never came back; they may have been paid for and count as spent:")
        for entry in journal.unknown_fate():
            print(plain(f"    {described(entry)}"))
    return 0 if complete else 3


def _certify(arguments: argparse.Namespace) -> int:
    from fairaudit.plugins.vlm.report import certify_all, said

    experiment, folder, journal = _open(arguments, create=False)
    with journal:
        models = [m for m in journal.models() if m in _keys(experiment, arguments, journal)]
        targets = given_limits(arguments) or None
        found = certify_all(experiment, journal, models, folder, confidence=_confidence(arguments.confidence), targets=targets)
    print(said(found, arguments.format))
    return {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3}[found.verdict]


def _plot(arguments: argparse.Namespace) -> int:
    from fairaudit.plugins.vlm.plot import draw
    from fairaudit.plugins.vlm.report import certify_all
    from fairaudit.plugins.vlm.run import run
    from fairaudit.words import plain

    experiment, folder, journal = _open(arguments, create=True)
    with journal:
        if not journal.models() or arguments.maker or arguments.model:
            journal.claim()
            for model in _models(experiment, arguments):
                if model.maker != "endpoint":
                    run(experiment, model, journal)
        models = [m for m in journal.models() if m in _keys(experiment, arguments, journal)]
        found = certify_all(experiment, journal, models, folder, confidence=_confidence(arguments.confidence), targets=None)
    path = draw(experiment, found, folder / "figure.png")
    print(plain(f"{len(found.written)} tables and certificates are in {folder}"))
    print(plain(f"The figure is {path}"))
    return 0


def _keys(experiment: Experiment, arguments: argparse.Namespace, journal: Journal) -> list[str]:
    if arguments.model is None and arguments.maker is None and arguments.base_url is None:
        return journal.models()
    return [model.key for model in _models(experiment, arguments)]


def _confidence(given: str | None) -> Any:
    from fairaudit.errors import InputError, shown
    from fairaudit.inference.levels import confidence_level

    if given == "none":
        return None
    try:
        return confidence_level(given or "0.95")
    except InputError:
        raise InputError(f"--confidence {shown(given)} is not accepted; a number between 0 and 1 such as 0.95 is, or 'none'") from None
