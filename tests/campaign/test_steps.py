"""Steps as people write them."""

import pytest

from labrig import LabrigError
from labrig.campaign import Procedure, RigInfo, Steps, dry_run
from tests.campaign.conftest import fake_config


def test_steps_without_a_yield_that_fail_say_where() -> None:
    """A plain function in place of a generator runs at once: its error is told with its place, too."""

    class Plain(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            raise ValueError("no yield here")

    with pytest.raises(LabrigError, match=r"^procedure plain failed at step 0: ValueError: no yield here \("):
        dry_run(Plain(), fake_config())
