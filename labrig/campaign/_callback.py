"""A function that is told how far a run is."""

import warnings
from collections.abc import Callable

from labrig.campaign._observe import Observer, Progress
from labrig.campaign._session import Control


class Callback(Observer):
    """A plain function that wants to know the progress."""

    def __init__(self, function: Callable[[Progress], None], control: Control) -> None:
        self._function, self._control = function, control

    def progress(self, progress: Progress) -> None:
        try:
            self._function(progress)
        except KeyboardInterrupt:
            self._control.end("stopped by progress")
        except Exception as error:
            what = f"progress: {type(error).__name__}: {error}; it is not called again, and the run goes on"
            warnings.warn(what, RuntimeWarning, stacklevel=2)
            raise
