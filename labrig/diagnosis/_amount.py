"""A number and its unit in a sentence."""


def two_digits(value: float) -> str:
    """A number in two digits, without an exponent up to a million: `120`, not `1.2e+02`."""
    return f"{float(f'{value:.2g}'):g}"


def amount(value: float, unit: str) -> str:
    """Two digits and the unit: `0.12 mm`; a unit of 1 is none."""
    return two_digits(value) if unit == "1" else f"{two_digits(value)} {unit}"
