"""Names of markers and chambers on a surface in space, as the camera sees them at first."""

import numpy as np

from labrig.view._fields import skin
from labrig.view._names_in_space import name_places, proud
from labrig.view._outlines import Outline
from labrig.view._surface_figure import surface_figure


def _torso():
    """Markers on half a cylinder, which turns away from who looks at it on either side, (M, 3) mm."""
    angle, height = np.meshgrid(np.radians([-80, -50, -20, 10, 45, 80]), [0.0, 60.0, 120.0, 180.0])
    return np.stack([70 * np.sin(angle).ravel(), -70 * np.cos(angle).ravel(), height.ravel()], axis=1)


def _screen(rest, surface):
    """To the right, up, and towards the camera, (3, 3), as a picture begins."""
    figure = surface_figure(["m"] * len(rest), rest, np.zeros(len(rest)), 1.0, "mm", surface)
    eye = figure["layout"]["scene"]["camera"]["eye"]
    back = np.array([eye[axis] for axis in "xyz"])
    back /= np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def test_no_name_is_partly_behind_the_surface():
    """Within the room of a name, to the camera's sides and up, no part of the skin is nearer to the camera than it."""
    rest = _torso()
    names = [f"m{k:02d}" for k in range(len(rest))]
    surface = skin(rest)
    right, up, back = _screen(rest, surface)
    corners = surface.vertices(rest)
    hidden = {"low": 0, "lifted": 0}
    for which, off in (
        ("low", 5 * proud(rest)),
        ("lifted", name_places(names, rest, surface, []).of_markers),
    ):
        for name in rest + off:
            beside = corners - name
            within = (abs(beside @ right) < 0.06 * 180) & (beside @ up > 0) & (beside @ up < 0.06 * 180)
            hidden[which] += bool((beside[within] @ back > 0).any())
    assert hidden["low"] > 0
    assert hidden["lifted"] == 0


def test_a_name_is_seen_where_its_marker_is():
    """A name comes straight towards the camera: beside what stands off the skin anyway, nothing moves on the screen."""
    rest = _torso()
    surface = skin(rest)
    lift = name_places(["m"] * len(rest), rest, surface, []).of_markers - 5 * proud(rest)
    right, up, back = _screen(rest, surface)
    np.testing.assert_allclose(lift @ np.stack([right, up], axis=1), 0.0, atol=1e-2)
    assert (lift @ back).max() > 1.0


def test_a_chamber_is_not_named_over_a_marker():
    """The name of a chamber whose middle is a marker goes aside on the surface, so that both can be read."""
    rest = _torso()
    surface = skin(rest)
    names = [f"m{k:02d}" for k in range(len(rest))]
    lines = [Outline(f"c{k}", np.zeros((0, 2, len(rest))), np.eye(len(rest))[k]) for k in (0, 8, 15, 23)]
    named = name_places(names, rest, surface, lines)
    right, up, _ = _screen(rest, surface)
    flat = np.stack([right, up], axis=1)
    markers = (rest + named.of_markers) @ flat + [0.0, 0.06 * 180]
    chambers = (rest[[0, 8, 15, 23]] + named.of_chambers) @ flat - [0.0, 0.06 * 180]
    each = [*zip(names, markers, strict=True), *zip("abcd", chambers, strict=True)]
    for n, own in enumerate(chambers):
        others = np.array([place for k, (_, place) in enumerate(each) if k != len(names) + n])
        over = (abs(others[:, 0] - own[0]) < 0.09 * 180) & (abs(others[:, 1] - own[1]) < 0.05 * 180)
        assert not over.any()


def test_what_is_named_beside_the_surface_is_said():
    """A name over the nearest corner above lies on the page, not on the colours of the surface; those inside do."""
    rest = _torso()
    beside = name_places([f"m{k:02d}" for k in range(len(rest))], rest, skin(rest), []).markers_beside
    assert beside[(rest[:, 2] == 180.0) & (rest[:, 0] > 60)].all()
    assert not beside[(rest[:, 2] == 60.0) & (abs(rest[:, 0]) < 60)].any()


def test_without_a_skin_or_chambers_names_stand_as_far_as_ever():
    """Markers that span no surface, and rigs whose chambers are not known, have names too."""
    rest = _torso()[:3]
    named = name_places(["a", "b", "c"], rest, None, [])
    np.testing.assert_allclose(named.of_markers, np.tile(5 * proud(rest), (3, 1)))
    assert named.of_chambers.shape == (0, 3)
