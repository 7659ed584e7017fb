"""Exact numbers: rationals, enclosures of their logarithms, passes over big arrays with a rigorous error."""
