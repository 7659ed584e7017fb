"""fairaudit: exact, certified fairness audits of decision tables.

The names below load on first use, so that importing the package costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_NAMES = {
    "fairaudit.attestations.recount": (
        "Recount",
        "recount",
    ),
    "fairaudit.attestations.verification": ("verify",),
    "fairaudit.audits.certify": ("certify",),
    "fairaudit.audits.claims": ("Claim",),
    "fairaudit.audits.from_table": ("audit",),
    "fairaudit.audits.result": ("Result",),
    "fairaudit.audits.subgroups": (
        "Subgroup",
        "Subgroups",
        "subgroups",
    ),
    "fairaudit.audits.targets": ("Target",),
    "fairaudit.audits.worst_utility": ("certify_worst_case",),
    "fairaudit.certificates.certificate": ("Certificate",),
    "fairaudit.certificates.compare": ("CertificateComparison",),
    "fairaudit.checker": ("Finding",),
    "fairaudit.errors": (
        "FairauditError",
        "FalseCertificate",
        "Infeasible",
        "InputError",
        "ManyRowsError",
        "RowsLost",
        "TableNeeded",
    ),
    "fairaudit.exact.rationals": ("Number",),
    "fairaudit.filters.calibration": (
        "Calibration",
        "calibrate",
    ),
    "fairaudit.filters.calibration_with_policy": ("calibrate_policy",),
    "fairaudit.filters.calibration_with_utility": ("calibrate_utility",),
    "fairaudit.filters.design_result": ("Design",),
    "fairaudit.filters.frontiers": (
        "Frontier",
        "frontier",
    ),
    "fairaudit.filters.model_free": ("design_model_free",),
    "fairaudit.filters.with_policy": ("design",),
    "fairaudit.filters.with_utility": ("design_utility",),
    "fairaudit.inference.comparisons": ("Comparison",),
    "fairaudit.inference.hypothesis_tests": (
        "EpsilonRefutation",
        "NoiseFloor",
        "noise_floor",
        "refute_epsilon",
    ),
    "fairaudit.inference.interval": ("Interval",),
    "fairaudit.inference.planning": (
        "Planning",
        "plan",
    ),
    "fairaudit.measures.distances": ("Distance",),
    "fairaudit.measures.ratios": (
        "Ratio",
        "Witness",
    ),
    "fairaudit.model.allocation": (
        "Allocation",
        "read_allocation",
    ),
    "fairaudit.model.law": ("Law",),
    "fairaudit.model.layout": ("Columns",),
    "fairaudit.model.mechanism": (
        "Constant",
        "Identity",
        "Mechanism",
        "Product",
        "RandomizedResponse",
    ),
    "fairaudit.model.mechanism_file": ("read_mechanism",),
    "fairaudit.model.policy": (
        "Deployment",
        "Policy",
        "policy_source",
        "sample_policy",
    ),
    "fairaudit.model.release_store": ("ReleaseStore",),
    "fairaudit.model.utility": (
        "Utility",
        "UtilityTable",
    ),
    "fairaudit.model.utility_class": (
        "Ball",
        "Family",
        "LinearRow",
        "UtilityClass",
    ),
    "fairaudit.privacy.composition": (
        "Composition",
        "compose",
    ),
    "fairaudit.privacy.currencies": (
        "ApproxDP",
        "PureDP",
    ),
    "fairaudit.privacy.epsilon_delta": (
        "delta",
        "pure_dp",
    ),
    "fairaudit.privacy.trade_offs": (
        "Profile",
        "TradeOff",
        "trade_off",
    ),
    "fairaudit.reports.report": ("report",),
    "fairaudit.streams.looks": ("Look",),
    "fairaudit.streams.opening": ("monitor",),
    "fairaudit.streams.stream": ("Monitor",),
    "fairaudit.tables.binning": ("Bins",),
    "fairaudit.tables.csv": (
        "CsvTable",
        "read_csv",
    ),
    "fairaudit.tables.engines.logs": ("read_log",),
    "fairaudit.tables.engines.tallies": ("tally",),
    "fairaudit.tables.examples": (
        "Example",
        "example",
    ),
    "fairaudit.tables.labels": ("merge_labels",),
    "fairaudit.tables.tally": ("Tally",),
    "fairaudit.theorems.bound": ("Bound",),
    "fairaudit.verified.comparison": ("compare",),
    "fairaudit.verified.verification": ("Verification",),
    "fairaudit.worst.methods": ("worst_case",),
    "fairaudit.worst.result": ("WorstCase",),
}
"""Public names by the module that they live in."""

_HOME = {name: module for module, names in _NAMES.items() for name in names}

__all__ = [*_HOME, "__version__"]

if TYPE_CHECKING:
    import fairaudit.metrics  # noqa: F401
    from fairaudit.attestations.recount import Recount as Recount
    from fairaudit.attestations.recount import recount as recount
    from fairaudit.attestations.verification import verify as verify
    from fairaudit.audits.certify import certify as certify
    from fairaudit.audits.claims import Claim as Claim
    from fairaudit.audits.from_table import audit as audit
    from fairaudit.audits.result import Result as Result
    from fairaudit.audits.subgroups import Subgroup as Subgroup
    from fairaudit.audits.subgroups import Subgroups as Subgroups
    from fairaudit.audits.subgroups import subgroups as subgroups
    from fairaudit.audits.targets import Target as Target
    from fairaudit.audits.worst_utility import certify_worst_case as certify_worst_case
    from fairaudit.certificates.certificate import Certificate as Certificate
    from fairaudit.certificates.compare import CertificateComparison as CertificateComparison
    from fairaudit.checker import Finding as Finding
    from fairaudit.errors import FairauditError as FairauditError
    from fairaudit.errors import FalseCertificate as FalseCertificate
    from fairaudit.errors import Infeasible as Infeasible
    from fairaudit.errors import InputError as InputError
    from fairaudit.errors import ManyRowsError as ManyRowsError
    from fairaudit.errors import RowsLost as RowsLost
    from fairaudit.errors import TableNeeded as TableNeeded
    from fairaudit.exact.rationals import Number as Number
    from fairaudit.filters.calibration import Calibration as Calibration
    from fairaudit.filters.calibration import calibrate as calibrate
    from fairaudit.filters.calibration_with_policy import calibrate_policy as calibrate_policy
    from fairaudit.filters.calibration_with_utility import calibrate_utility as calibrate_utility
    from fairaudit.filters.design_result import Design as Design
    from fairaudit.filters.frontiers import Frontier as Frontier
    from fairaudit.filters.frontiers import frontier as frontier
    from fairaudit.filters.model_free import design_model_free as design_model_free
    from fairaudit.filters.with_policy import design as design
    from fairaudit.filters.with_utility import design_utility as design_utility
    from fairaudit.inference.comparisons import Comparison as Comparison
    from fairaudit.inference.hypothesis_tests import EpsilonRefutation as EpsilonRefutation
    from fairaudit.inference.hypothesis_tests import NoiseFloor as NoiseFloor
    from fairaudit.inference.hypothesis_tests import noise_floor as noise_floor
    from fairaudit.inference.hypothesis_tests import refute_epsilon as refute_epsilon
    from fairaudit.inference.interval import Interval as Interval
    from fairaudit.inference.planning import Planning as Planning
    from fairaudit.inference.planning import plan as plan
    from fairaudit.measures.distances import Distance as Distance
    from fairaudit.measures.ratios import Ratio as Ratio
    from fairaudit.measures.ratios import Witness as Witness
    from fairaudit.model.allocation import Allocation as Allocation
    from fairaudit.model.allocation import read_allocation as read_allocation
    from fairaudit.model.law import Law as Law
    from fairaudit.model.layout import Columns as Columns
    from fairaudit.model.mechanism import Constant as Constant
    from fairaudit.model.mechanism import Identity as Identity
    from fairaudit.model.mechanism import Mechanism as Mechanism
    from fairaudit.model.mechanism import Product as Product
    from fairaudit.model.mechanism import RandomizedResponse as RandomizedResponse
    from fairaudit.model.mechanism_file import read_mechanism as read_mechanism
    from fairaudit.model.policy import Deployment as Deployment
    from fairaudit.model.policy import Policy as Policy
    from fairaudit.model.policy import policy_source as policy_source
    from fairaudit.model.policy import sample_policy as sample_policy
    from fairaudit.model.release_store import ReleaseStore as ReleaseStore
    from fairaudit.model.utility import Utility as Utility
    from fairaudit.model.utility import UtilityTable as UtilityTable
    from fairaudit.model.utility_class import Ball as Ball
    from fairaudit.model.utility_class import Family as Family
    from fairaudit.model.utility_class import LinearRow as LinearRow
    from fairaudit.model.utility_class import UtilityClass as UtilityClass
    from fairaudit.privacy.composition import Composition as Composition
    from fairaudit.privacy.composition import compose as compose
    from fairaudit.privacy.currencies import ApproxDP as ApproxDP
    from fairaudit.privacy.currencies import PureDP as PureDP
    from fairaudit.privacy.epsilon_delta import delta as delta
    from fairaudit.privacy.epsilon_delta import pure_dp as pure_dp
    from fairaudit.privacy.trade_offs import Profile as Profile
    from fairaudit.privacy.trade_offs import TradeOff as TradeOff
    from fairaudit.privacy.trade_offs import trade_off as trade_off
    from fairaudit.reports.report import report as report
    from fairaudit.streams.looks import Look as Look
    from fairaudit.streams.opening import monitor as monitor
    from fairaudit.streams.stream import Monitor as Monitor
    from fairaudit.tables.binning import Bins as Bins
    from fairaudit.tables.csv import CsvTable as CsvTable
    from fairaudit.tables.csv import read_csv as read_csv
    from fairaudit.tables.engines.logs import read_log as read_log
    from fairaudit.tables.engines.tallies import tally as tally
    from fairaudit.tables.examples import Example as Example
    from fairaudit.tables.examples import example as example
    from fairaudit.tables.labels import merge_labels as merge_labels
    from fairaudit.tables.tally import Tally as Tally
    from fairaudit.theorems.bound import Bound as Bound
    from fairaudit.verified.comparison import compare as compare
    from fairaudit.verified.verification import Verification as Verification
    from fairaudit.worst.methods import worst_case as worst_case
    from fairaudit.worst.result import WorstCase as WorstCase


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name == "metrics":
        return import_module("fairaudit.metrics")
    if name not in _HOME:
        raise AttributeError(f"module 'fairaudit' has no attribute {name!r}", name=name, obj=import_module("fairaudit"))
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
