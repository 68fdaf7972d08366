"""Commands: campaign."""
