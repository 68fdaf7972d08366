"""What the tests in a real browser share."""

from typing import Any

from tests.waiting import wait_for

NO_WEBGL = """const getContext = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
    return kind.includes("webgl") ? null : getContext.call(this, kind, ...more);
};"""
"""A script after which a page is in a browser that draws nothing in space, as over many remote desktops."""


def frame_at(page: Any, part: str) -> Any:
    """The frame of a page whose address has this part, as soon as it is there."""
    return wait_for(
        lambda: next((frame for frame in page.frames if part in frame.url), None), f"no frame {part}"
    )


def box_of(locator: Any) -> dict[str, float]:
    """Where an element is, as soon as it is drawn: while its document is loaded anew it is nowhere."""
    return wait_for(locator.bounding_box, "it is not drawn")
