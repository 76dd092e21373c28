"""One page on one run or several: what they did, and the numbers of the paper beside it.

`command` is `mjxwalk report`; `sources` reads runs and studies and refuses those that cannot be
averaged; `building` puts the sections together, one module each; `page` writes HTML and CSV.
"""
