"""Check a certificate of the format ``fairaudit-certificate/1``.

This folder stands alone: it uses the Python standard library only, imports nothing of the package that writes
certificates, and runs from a copy of itself under any name::

    python -I -S checker CERTIFICATE.json [--table FILE] [--require within] [--verbose | --quiet]

It reads the certificate and the decision table, computes every figure again from the table, and says in one paragraph what is true
and what is assumed, before that each statement that is false, and with ``--verbose`` each statement.  All decisions are made in
integers; no floating-point number occurs.  With ``--attestation FILE`` it also compares what somebody attests of the certificate.

What is trusted: Python's integers, ``fractions``, ``json`` and ``hashlib``; and, for the claims ``by`` T1, T2 and so on,
the theorems of those names.  Nothing that the certificate says is.  What the sentences under ``assumptions`` say cannot be checked,
and they are repeated for the reader; but each claim has to list those that it rests on, word by word, and no others.  A true
certificate is true *of its table*; that the table is genuine is not checked.

Exit codes: 0 every statement is true (and the required verdict is there); 1 a statement is false, or the required
verdict is not there; 2 not a complete certificate of this format, not readable, or wrong usage; 3 the table is not embedded and
was not given, or the attestation is in an envelope, whose signature no checker of the standard library can check.

The files can be read in this order, in which each imports only from those before it:

==============  ================================================================================================================
text            ``text``, ``work``: what is said to people, and how much work a document may make
JSON            ``json_values``
rationals       ``rationals``
logarithms      ``logarithms``
table           ``laws``, ``header``: laws of the decision, and the first line of a table
filters         ``filters``
figures         ``figures``, ``rates``, ``table``, ``rows``, ``metrics``: what the lines of a table add up to, and what is stated of it
claims          ``sentences``, ``claims``: what they assume, and their rules; ``summary``: how they are said; then by family
of classes      ``utility_class``, ``program``, ``worst_case``
of populations  ``moved_ends``, ``intervals``, ``tails``, ``plain_ends``, ``samples``, ``pair_exact``, ``split``, ``regions``,
                ``difference_regions``, ``betting``, ``paired_betting``, ``symmetric_betting``, ``contrasts``,
                ``difference_contrasts``, ``joint_betting``, ``meanings`` of decisions that are not known, ``passing``, ``interval_proofs``
of unknowns     ``unknown_evidence``, ``unknown_groups``
of policies     ``declared``, ``policy_evidence``, ``likelihoods``, ``sides``, ``policy_facts``, ``bounds``, ``suprema``, ``ranges``,
                ``floored``, ``near``
of drift        ``drifts``, ``drift``
of objections   ``undecided``, ``hidden_context``; then ``judgement`` of claims of all families
certificate     ``left_out``, ``preparation``, ``evaluation``, ``certificate``, ``outline``, ``assumptions``, ``targets``
other formats   ``proxy_ranges``, ``proxies``, ``conjunctions``, ``subgroup_statement``, ``subgroups``; then ``verification`` of all
command         ``attestation``: who made a certificate, of which files; ``command``
==============  ================================================================================================================
"""

from .attestation import Signed, check_attestation
from .certificate import CERTIFICATE_FORMAT
from .command import Refusal, examine, main
from .json_values import without_page
from .summary import attested_paragraph, exit_code, lines, paragraph, summary_line
from .text import Attested, Finding, FormatError, Incomplete, NotAnAttestation, Report, TableNeeded, TooMuch, printable
from .verification import check

__all__ = [
    "CERTIFICATE_FORMAT",
    "Attested",
    "Finding",
    "FormatError",
    "Incomplete",
    "NotAnAttestation",
    "Refusal",
    "Report",
    "Signed",
    "TableNeeded",
    "TooMuch",
    "attested_paragraph",
    "check",
    "check_attestation",
    "examine",
    "exit_code",
    "lines",
    "main",
    "paragraph",
    "printable",
    "summary_line",
    "without_page",
]
