"""Procedures: what a lab user reads, copies and edits."""
