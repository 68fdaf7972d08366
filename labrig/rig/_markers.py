"""The names of markers: each once, and those of rig.yaml found among those of a driver."""

from collections.abc import Sequence


def twice(names: Sequence[str]) -> str | None:
    """The first name that stands twice; None where each stands once."""
    return next((name for at, name in enumerate(names) if name in names[:at]), None)


def order_in(own: Sequence[str], wanted: Sequence[str]) -> list[int] | None:
    """Where each of the `wanted` markers stands among a driver's `own`; None where they are the same.

    Raises `ValueError` that says which are missing, or named twice.
    """
    if (name := twice(own)) is not None:
        raise ValueError(f"names the marker {name} twice")
    if not wanted or tuple(own) == tuple(wanted):
        return None
    if missing := [name for name in wanted if name not in own]:
        raise ValueError(
            f"does not name {', '.join(missing)} of rig.yaml's markers (it names {', '.join(own) or 'none'})"
        )
    return [list(own).index(name) for name in wanted]
