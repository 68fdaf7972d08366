"""The error that every part of labrig raises for what a person can put right."""


class LabrigError(Exception):
    """Something is wrong with what labrig was given; the message is one line: what, where, what to do.

    The command line prints the message after ``labrig: `` and exits with `exit_code`, without a traceback.
    """

    exit_code = 2


class NothingToDoError(LabrigError):
    """What was asked for is not needed: good news, which a command ends with a code of its own for."""

    exit_code = 4
