"""Exact induced law of 2,400 groups behind three filters, against a float einsum. Nothing passes or fails on time.

Run: python tests/benchmarks/filters.py
"""

from __future__ import annotations

from itertools import product

import numpy as np
from timing import median

from fairaudit import Law, Policy, Product, RandomizedResponse
from fairaudit.model.layout import Columns

SIZES = (10, 12, 20)
CONTEXTS, DECISIONS = 50, 20


def main() -> None:
    generator = np.random.default_rng(0)
    values = [[f"{name}{i}" for i in range(k)] for name, k in zip("abc", SIZES, strict=True)]
    groups = list(product(*values))
    counts = generator.multinomial(1000, np.ones(DECISIONS) / DECISIONS, (CONTEXTS, len(groups)))
    contexts = [str(i) for i in range(CONTEXTS)]
    law = Law.from_array(counts, kind="counts", groups=groups, contexts=contexts, columns=Columns("u", ("a", "b", "c"), ("x",)))
    filters = Product({name: RandomizedResponse(v, keep_probability="0.7") for name, v in zip("abc", values, strict=True)})
    policy = Policy(law)

    floats = counts.reshape(CONTEXTS, *SIZES, DECISIONS) / 1000
    tables = [np.full((k, k), 0.3 / (k - 1)) + np.eye(k) * (0.7 - 0.3 / (k - 1)) for k in SIZES]
    formula = "xabcu,ia,jb,kc->xijku"
    path = np.einsum_path(formula, floats, *tables, optimize="optimal")[0]
    reference = median(lambda: np.einsum(formula, floats, *tables, optimize=path), 7)
    exact = median(lambda: policy.behind(group=filters).law, 7)
    induced = policy.behind(group=filters).law
    rows = induced.weights / induced.weights.sum(axis=1, keepdims=True)
    error = np.abs(rows - np.einsum(formula, floats, *tables, optimize=path).reshape(rows.shape)).max()
    print(f"einsum over the three factors  {reference:.3f} s")
    print(f"exact induced law              {exact:.3f} s   {exact / reference:.2f} x (at most 1.5); einsum is off by at most {error:.1e}")


if __name__ == "__main__":
    main()
