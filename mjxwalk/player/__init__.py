"""A page on which walkers walk: recorded here, packed small, and drawn in 3D by a browser.

`shown_walkers` chooses the walkers, `recording` lets them walk, `bodies` says what they look like,
`packing` makes it small and `page` writes it into one file with the program in `bundle`, whose
sources are in `web`.
"""
