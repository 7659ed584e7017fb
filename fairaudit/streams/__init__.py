"""Streams of decisions: what was counted, what it shows at any moment, a state that survives, readers of growing files.

`tail` reads bytes of a log, `readers` make decisions of lines, `labels` cells of decisions; what cannot be counted goes to `letters`.
`state` keeps the counts, `subjects` make laws of them, `looks` judge; `stream` holds it together, under `settings` that never change.
"""
