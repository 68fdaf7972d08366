"""A number and its unit in a sentence."""


def amount(value: float, unit: str) -> str:
    """Two digits and the unit: `0.12 mm`; a unit of 1 is none."""
    return f"{value:.2g}" if unit == "1" else f"{value:.2g} {unit}"
