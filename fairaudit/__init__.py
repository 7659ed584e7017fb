"""fairaudit: exact, certified fairness audits of decision tables.

The names below load on first use, so that importing the package costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {
    "Certificate": "fairaudit.certificates.certificate",
    "Claim": "fairaudit.audits.claims",
    "Columns": "fairaudit.model.layout",
    "Distance": "fairaudit.measures.distances",
    "InputError": "fairaudit.errors",
    "Constant": "fairaudit.model.mechanism",
    "Identity": "fairaudit.model.mechanism",
    "Law": "fairaudit.model.law",
    "Mechanism": "fairaudit.model.mechanism",
    "Policy": "fairaudit.model.policy",
    "Product": "fairaudit.model.mechanism",
    "RandomizedResponse": "fairaudit.model.mechanism",
    "Ratio": "fairaudit.measures.ratios",
    "ReleaseStore": "fairaudit.model.release_store",
    "Result": "fairaudit.audits.result",
    "Target": "fairaudit.audits.targets",
    "Utility": "fairaudit.model.utility",
    "UtilityClass": "fairaudit.model.utility_class",
    "Witness": "fairaudit.measures.ratios",
    "calibrate": "fairaudit.filters.calibration",
    "calibrate_policy": "fairaudit.filters.calibration_with_policy",
    "certify": "fairaudit.audits.certify",
    "compose": "fairaudit.privacy.composition",
    "delta": "fairaudit.privacy.epsilon_delta",
    "design": "fairaudit.filters.with_policy",
    "design_model_free": "fairaudit.filters.model_free",
    "example": "fairaudit.tables.examples",
    "certify_worst_case": "fairaudit.audits.worst_utility",
    "frontier": "fairaudit.filters.frontiers",
    "merge_labels": "fairaudit.tables.labels",
    "policy_source": "fairaudit.model.policy",
    "pure_dp": "fairaudit.privacy.epsilon_delta",
    "read_allocation": "fairaudit.model.allocation",
    "read_csv": "fairaudit.tables.csv",
    "read_log": "fairaudit.tables.engines.logs",
    "read_mechanism": "fairaudit.model.mechanism_file",
    "sample_policy": "fairaudit.model.policy",
    "trade_off": "fairaudit.privacy.trade_offs",
    "worst_case": "fairaudit.worst.methods",
}

__all__ = [*_HOME, "__version__"]

if TYPE_CHECKING:
    from fairaudit.audits.certify import certify as certify
    from fairaudit.audits.claims import Claim as Claim
    from fairaudit.audits.result import Result as Result
    from fairaudit.audits.targets import Target as Target
    from fairaudit.audits.worst_utility import certify_worst_case as certify_worst_case
    from fairaudit.certificates.certificate import Certificate as Certificate
    from fairaudit.errors import InputError as InputError
    from fairaudit.filters.calibration import calibrate as calibrate
    from fairaudit.filters.calibration_with_policy import calibrate_policy as calibrate_policy
    from fairaudit.filters.frontiers import frontier as frontier
    from fairaudit.filters.model_free import design_model_free as design_model_free
    from fairaudit.filters.with_policy import design as design
    from fairaudit.measures.distances import Distance as Distance
    from fairaudit.measures.ratios import Ratio as Ratio
    from fairaudit.measures.ratios import Witness as Witness
    from fairaudit.model.allocation import read_allocation as read_allocation
    from fairaudit.model.law import Law as Law
    from fairaudit.model.layout import Columns as Columns
    from fairaudit.model.mechanism import Constant as Constant
    from fairaudit.model.mechanism import Identity as Identity
    from fairaudit.model.mechanism import Mechanism as Mechanism
    from fairaudit.model.mechanism import Product as Product
    from fairaudit.model.mechanism import RandomizedResponse as RandomizedResponse
    from fairaudit.model.mechanism_file import read_mechanism as read_mechanism
    from fairaudit.model.policy import Policy as Policy
    from fairaudit.model.policy import policy_source as policy_source
    from fairaudit.model.policy import sample_policy as sample_policy
    from fairaudit.model.release_store import ReleaseStore as ReleaseStore
    from fairaudit.model.utility import Utility as Utility
    from fairaudit.model.utility_class import UtilityClass as UtilityClass
    from fairaudit.privacy.composition import compose as compose
    from fairaudit.privacy.epsilon_delta import delta as delta
    from fairaudit.privacy.epsilon_delta import pure_dp as pure_dp
    from fairaudit.privacy.trade_offs import trade_off as trade_off
    from fairaudit.tables.csv import read_csv as read_csv
    from fairaudit.tables.engines.logs import read_log as read_log
    from fairaudit.tables.examples import example as example
    from fairaudit.tables.labels import merge_labels as merge_labels
    from fairaudit.worst.methods import worst_case as worst_case


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'fairaudit' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
