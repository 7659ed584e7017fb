"""`fairaudit attest`: sign the attestation of a certificate, or make a pair of keys to sign with."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, add_format

if TYPE_CHECKING:
    from fairaudit.attestations.envelope import Envelope
    from fairaudit.attestations.keys import PublicKey

DESCRIPTION = """\
Sign the attestation of a certificate (`certify --attest` writes it), or make a pair of keys to sign with:

  fairaudit attest --new-key key.pem                    writes key.pem, which stays yours, and key.pub.pem, for everybody
  fairaudit attest attestation.json --sign-key key.pem  writes attestation.dsse.json
  fairaudit attest attestation.dsse.json --sign-key …   adds one more signature to that file

A signature says that what is signed is unaltered since the holder of the key signed it, and nothing else. A passphrase is asked for on
the terminal, or taken from FAIRAUDIT_KEY_PASSPHRASE; there is no option for it."""

EPILOG = "exit codes: 0 done; 2 bad input"

VARIABLE = "FAIRAUDIT_KEY_PASSPHRASE"


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "attest", run, CORE["attest"], DESCRIPTION, EPILOG)
    parser.add_argument("attestation", metavar="FILE", nargs="?", help="the attestation; one that is signed gets one more signature")
    parser.add_argument("--sign-key", metavar="KEY.pem", help="the private key (Ed25519, PKCS#8), which nobody else may be able to read")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="where to write what is signed (by default the name with .dsse.json; what is signed already stays in its file)",
    )
    parser.add_argument("--new-key", metavar="KEY.pem", help="make a pair of keys: KEY.pem and KEY.pub.pem, never over another file")
    parser.add_argument(
        "--passphrase",
        action="store_true",
        help="with --new-key: protect it by a passphrase, made and shown once on the terminal",
    )
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer:
    """Sign, or make keys."""
    from fairaudit.errors import InputError

    if arguments.new_key is not None:
        if any(given is not None for given in (arguments.attestation, arguments.sign_key, arguments.output)):
            raise InputError("--new-key makes keys and signs nothing; leave FILE, --sign-key and -o away")
        return _made(arguments.new_key, protected=arguments.passphrase)
    if arguments.passphrase:
        raise InputError(f"--passphrase goes with --new-key; that of --sign-key is asked for, or taken from {VARIABLE}")
    if arguments.attestation is None:
        raise InputError("nothing to sign is named; give FILE and --sign-key KEY.pem, or --new-key KEY.pem; see fairaudit attest --help")
    if arguments.sign_key is None:
        raise InputError("no key to sign with is named; add --sign-key KEY.pem, which fairaudit attest --new-key KEY.pem makes")
    return _signed(arguments.attestation, arguments.sign_key, arguments.output)


def _made(path: str, *, protected: bool) -> Answer:
    """Make a pair of keys; a passphrase that was made is shown on the terminal, and nowhere else."""
    from fairaudit.attestations.keys import new_key, new_passphrase
    from fairaudit.errors import InputError
    from fairaudit.words import plain

    given = os.environ.get(VARIABLE) or None
    if protected and given is None and (sys.stderr is None or not sys.stderr.isatty()):
        raise InputError(f"--passphrase shows the passphrase on a terminal, and there is none; set {VARIABLE} instead")
    passphrase = given or (new_passphrase() if protected else None)
    made = new_key(path, passphrase)
    if passphrase is not None and given is None:
        print(f"The passphrase of {plain(str(made.private))}, shown this once: {passphrase}", file=sys.stderr)
    how = "protected by a passphrase" if made.encrypted else "protected by nothing but the rights of the file"
    sentence = f"{made.private} signs and stays yours ({how}); {made.public} is for everybody who checks, by a way that they trust."
    return Answer(
        "key",
        sentence=sentence,
        result=lambda: {"private": str(made.private), "public": str(made.public), "keyid": made.id, "encrypted": made.encrypted},
        text=lambda: f"{plain(sentence)}\nIts digest, by which it is recognised: {made.id}",
    )


def _signed(name: str, key: str, output: str | None) -> Answer:
    from fairaudit.attestations.envelope import Envelope
    from fairaudit.attestations.keys import public_key_of, read_private_key
    from fairaudit.attestations.strict import MAX_BYTES
    from fairaudit.attestations.verification import read_attestation, stated_in
    from fairaudit.cli.destinations import refuse_output
    from fairaudit.errors import InputError, naming
    from fairaudit.files import write_atomically
    from fairaudit.words import plain

    raw = read_attestation(name)
    statement, found = stated_in(raw, name)
    # What is signed already is written again in its place, with all that it holds and one more signature.
    target = output or (_beside(name) if found is None else name)
    if output is not None and not output.lower().endswith(".json"):
        raise InputError(f"{output} does not end in .json, as what is signed does; name a file FILE.dsse.json")
    refuse_output(target, [name] if found is None else [], "the attestation")
    refuse_output(target, [key], "the key")
    envelope = found or Envelope(raw)
    private = read_private_key(key, lambda: _passphrase(key))
    with naming(name):
        signed = envelope.signed(private)
    text = signed.text.encode("ascii")
    if len(text) > MAX_BYTES:
        raise InputError(f"{name} is too long to be signed: with its signature it has more than {MAX_BYTES} bytes")
    _refuse_loss(target, signed, key)
    write_atomically(Path(target), [text])
    public, others = public_key_of(private), len(signed.signatures) - 1
    kept = f" {others} other signature{'s' * (others != 1)} stay{'s' * (others == 1)}, not checked." if others else ""
    sentence = f"{target} is {'now' if target == name else f'{name},'} signed by the key {public.id}.{kept}"
    subjects = [subject.name for subject in statement.subjects]
    check = ["fairaudit", "verify", subjects[0], "--attestation", target, "--key", _public_beside(key, public)]
    return Answer(
        "attest",
        sentence=sentence,
        result=lambda: {"file": target, "keyid": public.id, "signatures": len(signed.signatures), "subjects": subjects},
        text=lambda: f"{plain(sentence)}\nTo check it: {plain(shlex.join(check))}",
    )


def _beside(name: str) -> str:
    """Name the signed file after that of the attestation."""
    from fairaudit.errors import InputError

    path = Path(name)
    if path.name.endswith(".dsse.json"):
        raise InputError(f"{path} is not signed, although its name ends as that of a signed one; add -o FILE for what is signed")
    return str(path.with_name(f"{path.name.removesuffix('.json')}.dsse.json"))


def _refuse_loss(target: str, signed: Envelope, key: str) -> None:
    """Refuse to write over anything but the same attestation, and over signatures that what is to be written does not have."""
    from fairaudit.attestations.envelope import Envelope, read_envelope
    from fairaudit.attestations.verification import read_attestation
    from fairaudit.errors import InputError

    if not Path(target).exists():
        return
    try:
        raw = read_attestation(target)
        there = read_envelope(raw) or Envelope(raw)
    except InputError:
        there = Envelope(b"")
    if there.payload != signed.payload:
        raise InputError(f"{target} is there already and holds something else than this attestation; name another file with -o FILE")
    values = {signature.value for signature in signed.signatures}
    lost = sum(signature.value not in values for signature in there.signatures)
    if lost:
        command = shlex.join(["fairaudit", "attest", target, "--sign-key", key])
        raise InputError(
            f"{target} is there already and holds {lost} signature{'s' * (lost != 1)} of the same attestation that would be lost; "
            f"sign that file, and it gets one more: {command}"
        )


def _public_beside(key: str, public: PublicKey) -> str:
    """The file of the public key, where it lies beside the private one."""
    from fairaudit.attestations.keys import read_public_key
    from fairaudit.errors import InputError

    beside = str(Path(key).with_suffix(".pub.pem"))
    try:
        return beside if read_public_key(beside) == public else "PUB.pem"
    except InputError:
        return "PUB.pem"


def _passphrase(key: str) -> str:
    """Take the passphrase from the environment, or ask for it on the terminal, where it is not shown."""
    from getpass import getpass

    from fairaudit.errors import InputError
    from fairaudit.words import plain

    if given := os.environ.get(VARIABLE):
        return given
    if sys.stdin is None or not sys.stdin.isatty():
        raise InputError(f"{key} is protected by a passphrase, and nobody can be asked; set {VARIABLE}")
    try:
        return getpass(f"Passphrase of {plain(key)}: ")
    except EOFError:
        raise InputError(f"no passphrase of {key} was given") from None
