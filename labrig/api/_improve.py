"""improve: effects added to a model, fitted and judged."""

from typing import TYPE_CHECKING, Any, ClassVar

from labrig.api._answer import Answer
from labrig.api._inputs import model_of, names_of, runs_of

if TYPE_CHECKING:
    from labrig.model import Model


class Improvement(Answer):
    """A model with effects added: `error["base"]` before, `error["model"]` after, on held-out captures."""

    name: ClassVar[str] = "improve"

    @property
    def added(self) -> list[str]:
        """The names of the effects that were added."""
        return list(self.summary["effects"])

    @property
    def drop(self) -> float:
        """The share of what could be explained that the effects explain, 0 to 1."""
        return float(self.summary["drop"])

    @property
    def model(self) -> "Model":
        """The new model; `model.save("improved.yaml")` writes it."""
        assert self._result.improved is not None
        return self._result.improved


def improve(runs: Any, model: Any, add: Any, *, force: bool = False) -> Improvement:
    """Fit effects together and add them to a model.

    Args:
        runs: one run or a list, as paths or as `labrig.open_run` gives them; of one rig.
        model: a model.yaml's path, or what `labrig.Model.load` gives.
        add: the name of an effect, or several.
        force: add them even if they do not lower the held-out error.

    Raises:
        LabrigError: an effect does not exist, cannot act on these runs, is in the model already, or does not help.

    Example:
        >>> better = labrig.improve("runs/first", "model.yaml", "hysteresis")
        >>> better.error["model"] < better.error["base"]
        True
        >>> better.model.save("improved.yaml")
    """
    from labrig import diagnosis

    names = names_of(add, "an effect to add")
    return Improvement(diagnosis.improve(runs_of(runs), model_of(model), names, force=force))
