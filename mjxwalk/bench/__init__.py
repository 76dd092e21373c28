"""`mjxwalk bench`: how fast the engines are here, against each other and against the CPU's peak.

`measuring` runs it all, `results` says what comes out, `showing` prints it. Nothing is imported
here, since the command's module has to be read without JAX.
"""
