"""`mjxwalk bench`: how fast the engines are here, against C MuJoCo, MJX and the CPU's peak.

`measuring` runs it all, and `results` says what comes out.
"""
