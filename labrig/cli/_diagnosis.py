"""Commands: diagnosis."""
