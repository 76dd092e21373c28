"""What walkers did and how runs went, as tables, figures and numbers beside a paper's.

Plain numpy and pandas over recordings (`mjxwalk.replay`), genotypes and metrics of runs.
"""
