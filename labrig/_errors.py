"""The error that every part of labrig raises for what a person can put right."""


class LabrigError(Exception):
    """Something is wrong with what labrig was given; the message is one line: what, where, what to do.

    The command line prints the message after ``labrig: `` and exits with `exit_code`, without a traceback.
    """

    __module__ = "labrig"
    exit_code = 2

    def _render_traceback_(self) -> list[str]:
        """What IPython and Jupyter print of it: where in the reader's own code, and the message."""
        from labrig_drivers import short_traceback

        return short_traceback(self)


class NothingToDoError(LabrigError):
    """What was asked for is not needed: good news, which a command ends with a code of its own for."""

    __module__ = "labrig"
    exit_code = 4
