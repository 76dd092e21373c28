"""`mjxwalk bench`: how fast the engines are here, against each other and against the CPU's peak.

`measuring` runs it all, and `results` says what comes out.
"""
