"""Steps as people write them: with numbers of NumPy's, and with other things where a text is meant."""

import json

import numpy as np
import pytest

from labrig import LabrigError
from labrig.campaign import Note, Procedure, Record, RigInfo, Settle, Step, Steps, dry_run
from labrig.campaign._steps import step_from_dict
from tests.campaign.conftest import fake_config


@pytest.mark.parametrize(
    "step",
    [
        Settle(np.int64(2)),  # type: ignore[arg-type]
        Settle(np.float32(1.5)),  # type: ignore[arg-type]
        Record(np.arange(1, 3)[0], repeat=np.int64(3), label=np.float32(0.5)),  # type: ignore[arg-type]
        Record(1.0, label=("a", 1)),  # type: ignore[arg-type]
    ],
)
def test_numbers_of_numpys_are_kept_in_the_log(step: Step) -> None:
    """`for settle_s in np.arange(...)` is an ordinary procedure: a step is written, and read again as it was."""
    written = json.dumps(step.to_dict())
    assert step_from_dict(json.loads(written)) == step


def test_a_note_is_a_text() -> None:
    """A number that is noted is a line for people, as the log needs it."""
    assert [Note(7).text, Note(np.float64(3.5)).text] == ["7", "3.5"]  # type: ignore[arg-type]


def test_steps_without_a_yield_that_fail_say_where() -> None:
    """A plain function in place of a generator runs at once: its error is told with its place, too."""

    class Plain(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            raise ValueError("no yield here")

    with pytest.raises(LabrigError, match=r"^procedure plain failed at step 0: ValueError: no yield here \("):
        dry_run(Plain(), fake_config())
