"""Still pictures: whole, in the format that the name asks for, with and without a surface."""

import numpy as np
import pytest
from PIL import Image

from labrig.diagnosis import Result
from labrig.view import write_picture


def pixels(path):
    """The picture's colours, (height, width, 3)."""
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def test_before_is_redder_than_after(make_result, tmp_path):
    """The surface before stands left in the colours of a large error, the one after beside it in those of a small."""
    picture = pixels(write_picture(make_result(), tmp_path / "out" / "still.png"))
    width = picture.shape[1]
    left, right = picture[150:, : width * 28 // 100], picture[150:, width * 34 // 100 : width * 56 // 100]

    def bruised(part):
        return int(((part[..., 0] < 150) & (part[..., 0] > 1.4 * part[..., 1] + 20)).sum())

    assert bruised(left) > 20_000
    assert bruised(left) > 10 * bruised(right)


@pytest.mark.parametrize(("name", "start"), [("x.pdf", b"%PDF"), ("x.svg", b"<?xml")])
def test_the_ending_names_the_format(make_result, tmp_path, name, start):
    """Pictures for papers come as vectors."""
    assert write_picture(make_result(), tmp_path / name).read_bytes().startswith(start)


def test_without_geometry(make_result, fields, tmp_path):
    """A run of forces is drawn by the error of its captures."""
    result = make_result(fields=fields.drop_vars("rest_mm"))
    assert pixels(write_picture(result, tmp_path / "still.png")).std() > 5


def test_a_comparison(fields, tmp_path):
    """A comparison has one surface and no after."""
    summary = {"units": "mm", "error": {"model": 1.2, "floor": 0.1}, "where": [], "warnings": []}
    result = Result(summary, fields, [("model", 1.2), ("floor", 0.1)], [], [])
    picture = pixels(write_picture(result, tmp_path / "still.png"))
    middle = picture[250:600, picture.shape[1] * 36 // 100 : picture.shape[1] * 54 // 100]
    assert (middle == 255).all()


def test_a_picture_that_fails_leaves_nothing(make_result, tmp_path):
    """A format that does not exist leaves nothing half-written."""
    with pytest.raises(ValueError, match="Format 'nonsense' is not supported"):
        write_picture(make_result(), tmp_path / "still.nonsense")
    assert list(tmp_path.iterdir()) == []
