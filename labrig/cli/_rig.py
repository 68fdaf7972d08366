"""Commands: rig."""
