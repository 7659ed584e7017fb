"""What each theorem of docs/theory.md guarantees of a fairness measure, with its evidence: one module per theorem, beside its proof.

Two theorems say something of what stands on lower floors, and have their code there: T6, the suprema over utilities that ignore the group,
is `measures.ratios.local_supremum` and `global_supremum`; T9, more noise in randomized response is never less fair, is a fact about
`model.mechanism.RandomizedResponse` and `Product` that computes nothing. Their tests are beside those of the others.

What a certificate can claim, `registry` says; `applicable` asks each of its theorems about a `case`.
"""
