"""Pictures and films of runs: they see labelled results only, simulated or measured.

Every function takes a run and returns a :class:`matplotlib.figure.Figure` made without pyplot: nothing global is
changed, nothing has to be closed, and the figure shows itself in a notebook.
"""
