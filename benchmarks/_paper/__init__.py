"""The source paper's experiments, one module each; `benchmarks/paper.py` runs them."""
