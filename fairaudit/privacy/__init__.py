"""The exact privacy of a filter: ordered pairs, currencies, trade-off curves, composition."""
