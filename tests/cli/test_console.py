"""What commands print stands as it was meant."""

import io

from labrig.cli._console import new_console


def test_a_word_between_colons_is_no_emoji() -> None:
    """A campaign's key names its class, and `confounded` is one."""
    printed = io.StringIO()
    new_console(file=printed, width=80).print("sixth:confounded:9300000", "[b]run:smile:[/b]")
    assert printed.getvalue() == "sixth:confounded:9300000 run:smile:\n"
