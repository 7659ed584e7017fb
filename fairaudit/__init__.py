"""fairaudit: exact, certified fairness audits of decision tables.

The names below load on first use, so that importing the package costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {
    "Certificate": "fairaudit.certificate",
    "Claim": "fairaudit.audit",
    "Columns": "fairaudit.law",
    "Distance": "fairaudit.fairness",
    "InputError": "fairaudit.exact",
    "Constant": "fairaudit.mechanism",
    "Identity": "fairaudit.mechanism",
    "Law": "fairaudit.law",
    "Mechanism": "fairaudit.mechanism",
    "Policy": "fairaudit.policy",
    "Product": "fairaudit.mechanism",
    "RandomizedResponse": "fairaudit.mechanism",
    "Ratio": "fairaudit.fairness",
    "ReleaseStore": "fairaudit.release_store",
    "Result": "fairaudit.audit",
    "Target": "fairaudit.audit",
    "Utility": "fairaudit.utility",
    "UtilityClass": "fairaudit.utility_class",
    "Witness": "fairaudit.fairness",
    "calibrate": "fairaudit.calibration",
    "calibrate_policy": "fairaudit.calibration",
    "certify": "fairaudit.audit",
    "compose": "fairaudit.privacy",
    "delta": "fairaudit.privacy",
    "design": "fairaudit.filter_design",
    "design_model_free": "fairaudit.filter_design",
    "example": "fairaudit.tables.examples",
    "certify_worst_case": "fairaudit.worst_utility_certificate",
    "frontier": "fairaudit.filter_design",
    "merge_labels": "fairaudit.tables.labels",
    "policy_source": "fairaudit.policy",
    "pure_dp": "fairaudit.privacy",
    "read_allocation": "fairaudit.allocation",
    "read_csv": "fairaudit.tables.csv",
    "read_log": "fairaudit.tables.engines",
    "read_mechanism": "fairaudit.tables.mechanisms",
    "sample_policy": "fairaudit.policy",
    "trade_off": "fairaudit.privacy",
    "worst_case": "fairaudit.worst_utility",
}

__all__ = [*_HOME, "__version__"]

if TYPE_CHECKING:
    from fairaudit.allocation import read_allocation as read_allocation
    from fairaudit.audit import Claim as Claim
    from fairaudit.audit import Result as Result
    from fairaudit.audit import Target as Target
    from fairaudit.audit import certify as certify
    from fairaudit.calibration import calibrate as calibrate
    from fairaudit.calibration import calibrate_policy as calibrate_policy
    from fairaudit.certificate import Certificate as Certificate
    from fairaudit.exact import InputError as InputError
    from fairaudit.fairness import Distance as Distance
    from fairaudit.fairness import Ratio as Ratio
    from fairaudit.fairness import Witness as Witness
    from fairaudit.filter_design import design as design
    from fairaudit.filter_design import design_model_free as design_model_free
    from fairaudit.filter_design import frontier as frontier
    from fairaudit.law import Columns as Columns
    from fairaudit.law import Law as Law
    from fairaudit.mechanism import Constant as Constant
    from fairaudit.mechanism import Identity as Identity
    from fairaudit.mechanism import Mechanism as Mechanism
    from fairaudit.mechanism import Product as Product
    from fairaudit.mechanism import RandomizedResponse as RandomizedResponse
    from fairaudit.policy import Policy as Policy
    from fairaudit.policy import policy_source as policy_source
    from fairaudit.policy import sample_policy as sample_policy
    from fairaudit.privacy import compose as compose
    from fairaudit.privacy import delta as delta
    from fairaudit.privacy import pure_dp as pure_dp
    from fairaudit.privacy import trade_off as trade_off
    from fairaudit.release_store import ReleaseStore as ReleaseStore
    from fairaudit.tables.csv import read_csv as read_csv
    from fairaudit.tables.engines import read_log as read_log
    from fairaudit.tables.examples import example as example
    from fairaudit.tables.labels import merge_labels as merge_labels
    from fairaudit.tables.mechanisms import read_mechanism as read_mechanism
    from fairaudit.utility import Utility as Utility
    from fairaudit.utility_class import UtilityClass as UtilityClass
    from fairaudit.worst_utility import worst_case as worst_case
    from fairaudit.worst_utility_certificate import certify_worst_case as certify_worst_case


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'fairaudit' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
