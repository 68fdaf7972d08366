"""The commit that somebody's files were at, for the record."""

import subprocess


def git_commit() -> str | None:
    """The commit of the folder that labrig was started in, if it is a git repository."""
    try:
        answer = subprocess.run(
            ["git", "rev-parse", "HEAD"], capture_output=True, text=True, timeout=5, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return answer.stdout.strip() or None
