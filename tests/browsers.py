"""What the tests in a real browser share."""

NO_WEBGL = """const getContext = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
    return kind.includes("webgl") ? null : getContext.call(this, kind, ...more);
};"""
"""A script after which a page is in a browser that draws nothing in space, as over many remote desktops."""
