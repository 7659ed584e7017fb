"""What each theorem guarantees of a fairness measure, with its evidence: one module per theorem, beside its proof."""
