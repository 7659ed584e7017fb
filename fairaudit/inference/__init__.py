"""What draws say of the population, process or law that they come from, at a stated confidence, for finite samples.

A **cell** is a set of independent draws of a number in a known range, all with the same mean. Expected utilities are **forms**, weighted
sums of cell means; a **block** is a set of forms that are compared with each other. Every cell gets a lower and an upper end, each wrong
with at most a stated probability, its level.

* What is compared: `cells`, `comparisons`; made by `draws`, `table_comparisons`, `policy_comparisons`.
* How an error is split: `levels`, and nowhere else.
* Ends of one cell: `tails` (on `rounding`), `ends`; in floats, for searches, `float_tails`.
* A ratio from them: `quotients`; joined by the regions `box` and `product_region`, or pair by pair in `pair_region` (on `pair_exact`) and
  `contrast_region` (on `symmetric_betting`); chosen in `ratio_intervals`, with an `interval` as the result and `verdicts` on targets.
* Other quantities: `differences`, `rates` given the true label, `estimated_population`, `hypothesis_tests`.
* Streams, at every moment at once: `betting`, the regions `anytime_box` and `anytime_product` (found by `anytime_search`), joined in
  `anytime`; `changes`.
* Before the draws: `planning`.
"""
