"""What draws say of the population, process or law that they come from, at a stated confidence, for finite samples.

A **cell** is a set of independent draws of a number in a known range, all with the same mean. Expected utilities are **forms**, weighted
sums of cell means; a **block** is a set of forms that are compared with each other. Every cell gets a lower and an upper end, each wrong
with at most a stated probability, its level.
"""
