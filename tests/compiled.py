"""Compile once what each process of the tests would compile for itself: the kernels of shells, and the tests.

It takes half a minute of one core, while the checks keep the other one busy.
"""

import os
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from labrig.physics import load_shell

if __name__ == "__main__":
    shell = load_shell("membrane4")
    shell.solve(0.1 * shell.max_kpa)
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere):
        pytest.main(["--collect-only"])  # what is wrong with a test, the tests will say
