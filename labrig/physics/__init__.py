"""The simulators that a rig's models start from: pressures in, the shape of the inflated surface out."""

from labrig.physics._rig_file import of_rig_file, read_rig_file
from labrig.physics._shell import Shell, Solution, load_shell
from labrig.physics._shell_file import shipped_shells
from labrig.physics._shell_parameters import ShellParameter
from labrig.physics._shell_plant import ShellBody, load_body, plant_shell
from labrig.physics._shell_rig import has_shell, load_model_shell, rig_shell
from labrig.physics._shell_surface import ShellSurface, load_surface
from labrig.physics._shell_system import History
from labrig.physics._simulate import simulate
from labrig.physics._simulations import Simulations, open_simulations
from labrig.physics._surface import Surface, reduced_surface

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
