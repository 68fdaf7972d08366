"""The simulators that a rig's models start from: pressures in, the shape of the inflated surface out."""

from typing import TYPE_CHECKING

from labrig._lazy import lazy

if TYPE_CHECKING:
    from labrig.physics._load_surface import load_surface
    from labrig.physics._rig_file import has_shell, of_rig_file, read_rig_file
    from labrig.physics._shell import Shell, Solution, load_shell
    from labrig.physics._shell_file import shipped_shells
    from labrig.physics._shell_parameters import ShellParameter
    from labrig.physics._shell_plant import ShellBody, load_body, plant_shell
    from labrig.physics._shell_rig import load_model_shell, rig_shell
    from labrig.physics._shell_surface import ShellSurface
    from labrig.physics._shell_system import History
    from labrig.physics._simulate import simulate
    from labrig.physics._simulations import Simulations, open_simulations
    from labrig.physics._surface import Surface, reduced_surface

_LAZY = {
    "History": "_shell_system",
    "Shell": "_shell",
    "ShellBody": "_shell_plant",
    "ShellParameter": "_shell_parameters",
    "ShellSurface": "_shell_surface",
    "Simulations": "_simulations",
    "Solution": "_shell",
    "Surface": "_surface",
    "has_shell": "_rig_file",
    "load_body": "_shell_plant",
    "load_model_shell": "_shell_rig",
    "load_shell": "_shell",
    "load_surface": "_load_surface",
    "of_rig_file": "_rig_file",
    "open_simulations": "_simulations",
    "plant_shell": "_shell_plant",
    "read_rig_file": "_rig_file",
    "reduced_surface": "_surface",
    "rig_shell": "_shell_rig",
    "shipped_shells": "_shell_file",
    "simulate": "_simulate",
}
"""A rig with a reduced surface does not wait for compilers and solvers that only shells need."""

__all__ = [
    "History",
    "Shell",
    "ShellBody",
    "ShellParameter",
    "ShellSurface",
    "Simulations",
    "Solution",
    "Surface",
    "has_shell",
    "load_body",
    "load_model_shell",
    "load_shell",
    "load_surface",
    "of_rig_file",
    "open_simulations",
    "plant_shell",
    "read_rig_file",
    "reduced_surface",
    "rig_shell",
    "shipped_shells",
    "simulate",
]

__getattr__ = lazy(__name__, _LAZY)
