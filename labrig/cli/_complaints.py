"""What is said of an error, in one line, and the exit code that goes with it."""

import errno

USAGE = 2
UNEXPECTED = 1
INTERRUPTED = 130


class StoppedError(Exception):
    """Somebody ended it, by Ctrl-C; the text says what is known by then, and how to go on."""

    exit_code = INTERRUPTED


def complaint(error: Exception) -> str:
    """One line for a person: what is wrong, where, and what to do."""
    if isinstance(error, OSError) and error.strerror:
        return _of_a_path(error)
    if getattr(error, "exit_code", None) is None:
        return (
            f"unexpected {type(error).__name__}: {_line(str(error))}{_notes(error)} "
            "(run again with --debug and report it)"
        )
    if (said := getattr(error, "format_message", None)) is None:
        return _line(str(error))
    context = getattr(error, "ctx", None)
    return _line(said()) + (f" (see {context.command_path} --help)" if context is not None else "")


def exit_code(error: Exception) -> int:
    """What the command ends with: the error's own code, 2 for a path that is of no use, 1 for the unexpected."""
    code = getattr(error, "exit_code", None)
    if code is None:
        return USAGE if isinstance(error, OSError) and error.strerror else UNEXPECTED
    return int(code)


def _of_a_path(error: OSError) -> str:
    """A file or folder that cannot be used; whatever a command forgot to look at itself ends here."""
    if error.filename is None:
        return f"{error.strerror}; --debug says where"
    path = error.filename
    if isinstance(error, FileNotFoundError):
        return f"there is no {path}"
    if isinstance(error, IsADirectoryError):
        return f"{path} is a folder, where a file is needed"
    if isinstance(error, NotADirectoryError | FileExistsError):
        return f"{path}: a file is where a folder is needed; choose another name"
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"{path} cannot be written: {error.strerror}; make room there, or choose another place"
    return f"{path} can be neither made nor read: {error.strerror}; choose another place"


def _notes(error: Exception) -> str:
    return "".join(f"; {_line(note)}" for note in getattr(error, "__notes__", ()))


def _line(text: str) -> str:
    return " ".join(text.split())
