"""`import labrig` is quick, and shows what there is."""

import inspect
import pydoc
import re
import subprocess
import sys

import labrig


def test_every_public_name_is_there_and_documented() -> None:
    """dir() lists them, each can be used, and each says what it does."""
    assert dir(labrig) == sorted(labrig.__all__)
    for name in labrig.__all__:
        thing = getattr(labrig, name)
        if name != "__version__":
            assert (inspect.getdoc(thing) or "").strip(), name


def test_functions_say_what_they_take_and_raise() -> None:
    """Whoever asks help() of a function learns its arguments and its errors."""
    for name in labrig.__all__:
        thing = getattr(labrig, name)
        if inspect.isfunction(thing) and thing.__module__.startswith("labrig.api"):
            text = inspect.getdoc(thing) or ""
            for parameter in inspect.signature(thing).parameters:
                assert parameter in text, f"{name}: {parameter}"
            assert "Raises" in text, name


def test_help_shows_every_name() -> None:
    """help(labrig) has a section for each function and class, although they are imported when they are first used."""
    text = pydoc.plain(pydoc.render_doc(labrig))
    for name in labrig.__all__:
        thing = getattr(labrig, name)
        if inspect.isclass(thing) or inspect.isfunction(thing):
            assert re.search(rf"\n    (class )?{name}\(", text), name


def test_importing_labrig_imports_nothing_heavy() -> None:
    """No numpy, no pandas, no xarray before they are needed."""
    heavy = ("numpy", "pandas", "xarray", "plotly", "scipy")
    code = f"import labrig, sys; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    """As for any module."""
    assert not hasattr(labrig, "nothing_of_the_kind")
