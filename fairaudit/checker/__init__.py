"""Check a certificate of the format ``fairaudit-certificate/1``.

This folder stands alone: it uses the Python standard library only, imports nothing of the package that writes
certificates, and runs from a copy of itself under any name::

    python -I -S checker CERTIFICATE.json [--table FILE] [--require within]

It reads the certificate and the decision table, computes every figure again from the table, and says of each statement
in the certificate whether it is true.  All decisions are made in integers; no floating-point number occurs.

What is trusted: Python's integers, ``fractions``, ``json`` and ``hashlib``; and, for the claims ``by`` T1, T2 and so on,
the theorems of those names.  Nothing that the certificate says is.  What the sentences under ``assumptions`` say cannot be checked,
and they are repeated for the reader; but each claim has to list those that it rests on, word by word, and no others.  A true
certificate is true *of its table*; that the table is genuine is not checked.

Exit codes: 0 every statement is true (and the required verdict is there); 1 a statement is false, or the required
verdict is not there; 2 not a complete certificate of this format, not readable, or wrong usage; 3 the table is not embedded and
was not given.

Each module imports only from those before it in this order, in which they can be read:
errors, work, text, findings, json_values, rationals, logarithms, affine, laws, filters, header, figures, rates, table,
rows, sentences, claims, utility_class, program, membership, worst_case, stated_metrics, intervals, tails, samples,
boxes, ladders, betting, interval_proofs, facts, population, bounds, judgement, spelling, preparation, certificate,
preparation_checks, assumptions, statements, change, targets, verification, command.
"""

from .certificate import CERTIFICATE_FORMAT
from .command import main
from .errors import FormatError, Incomplete, TableNeeded, TooMuch
from .findings import Finding, Report
from .text import printable
from .verification import check

__all__ = ["CERTIFICATE_FORMAT", "Finding", "FormatError", "Incomplete", "Report", "TableNeeded", "TooMuch", "check", "main", "printable"]
