"""The simulators that a rig's models start from: pressures in, the shape of the inflated surface out."""

from labrig.physics._shell import Shell, Solution, load_shell
from labrig.physics._shell_file import shipped_shells
from labrig.physics._shell_parameters import ShellParameter
from labrig.physics._shell_system import History
from labrig.physics._surface import Surface, load_surface

__all__ = [
    "History",
    "Shell",
    "ShellParameter",
    "Solution",
    "Surface",
    "load_shell",
    "load_surface",
    "shipped_shells",
]
