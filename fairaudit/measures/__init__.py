"""Exact measures of a law, each with its witness, and limits on them."""
