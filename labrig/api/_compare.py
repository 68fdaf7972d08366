"""compare: a model as it stands against measurements."""

from typing import TYPE_CHECKING, Any, ClassVar

from labrig.api._answer import Answer
from labrig.api._inputs import model_of, runs_of

if TYPE_CHECKING:
    from labrig.model import Model


class Comparison(Answer):
    """How far a model is from measurements, and where: `error["model"]` against `error["floor"]`."""

    name: ClassVar[str] = "compare"


def compare(runs: Any, model: "Model | Any") -> Comparison:
    """Errors of a model as it stands, without any fit of effects: how large, and where.

    Args:
        runs: one run or a list, as paths or as `labrig.open_run` gives them; of one rig.
        model: a model.yaml's path, or what `labrig.Model.load` gives.

    Raises:
        LabrigError: a run or the model cannot be read, or they do not fit together.

    Example:
        >>> found = labrig.compare("runs/first", "model.yaml")
        >>> found.error["model"] > found.error["floor"]
        True
    """
    from labrig import diagnosis

    return Comparison(diagnosis.compare(runs_of(runs), model_of(model)))
