"""What benchmarks/ik.py measures."""
