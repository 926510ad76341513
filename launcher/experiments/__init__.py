"""Experiments: the lab and the estimators joined in one process, judged against the simulated truth."""
