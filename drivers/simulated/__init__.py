"""The simulated rig: devices that behave like the real ones, over one shared plant."""
