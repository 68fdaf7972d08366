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

    def found() -> Any:
        page.wait_for_timeout(1)  # frames come while the browser is asked, and not while Python sleeps
        return next((frame for frame in page.frames if part in frame.url), None)

    return wait_for(found, f"no frame {part}")


def box_of(locator: Any) -> dict[str, float]:
    """Where an element is, as soon as it is drawn: while its document is loaded anew it is nowhere."""
    return wait_for(locator.bounding_box, "it is not drawn")
