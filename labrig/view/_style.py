"""Colours and the style sheet that reports, recordings and still pictures share."""

INK = "#1d2530"
MUTED = "#66717f"
LINE = "#e3e0d8"
PAPER = "#fcfbf8"
BEFORE = "#c0563a"
AFTER = "#1f6f8b"
CEILING = "#d8a23a"
FLOOR = "#8d97a3"
UP = "#c0563a"
DOWN = "#1f6f8b"
GROUPS = (UP, DOWN, "#7a5ba6", "#4f8a4b", CEILING, FLOOR)

# Error on the surface: from the colour of the paper model to a bruise.
ERROR_SCALE = ((0.0, "#e9ece6"), (0.25, "#f3cf9b"), (0.5, "#e58b55"), (0.75, "#b93c3f"), (1.0, "#5c123c"))

VERDICT_COLOURS = {
    "nothing missing": "#4f8a4b",
    "identified": AFTER,
    "several effects": AFTER,
    "confounded": "#a9761a",
    "unknown effect": "#7a5ba6",
    "too few data": FLOOR,
    "comparison": MUTED,
    "improved model": AFTER,
}

CSS = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0; background: #fcfbf8; color: #1d2530; font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto,
  "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1020px; margin: 0 auto; padding: 44px 32px 72px; }
.over { color: #66717f; font-size: 14px; display: flex; gap: 14px; align-items: baseline; flex-wrap: wrap; }
.badge { color: #fff; border-radius: 999px; padding: 2px 12px; font-size: 13px; font-weight: 600; }
h1 { font: 600 34px/1.22 "Iowan Old Style", "Palatino Linotype", Palatino, Georgia, serif; margin: 14px 0 12px;
  max-width: 22em; letter-spacing: -0.01em; }
h2 { font: 600 21px/1.3 "Iowan Old Style", "Palatino Linotype", Palatino, Georgia, serif; margin: 52px 0 4px; }
h3 { font-size: 15px; margin: 0 0 2px; }
p { margin: 8px 0; max-width: 46em; }
p.lead { font-size: 18px; }
p.about { color: #66717f; margin: 2px 0 12px; font-size: 15px; }
.answers { display: grid; grid-template-columns: 1fr 1fr; gap: 28px; margin: 22px 0 0; }
.answers p { margin: 2px 0; font-size: 15.5px; }
.figures { display: flex; flex-wrap: wrap; gap: 14px; margin: 26px 0 4px; }
.figure { border-left: 3px solid; padding: 2px 26px 2px 14px; }
.figure b { display: block; font-size: 28px; line-height: 1.2; font-weight: 600; font-variant-numeric: tabular-nums; }
.figure b small { font-size: 16px; font-weight: 400; color: #66717f; }
.figure span { color: #66717f; font-size: 13.5px; }
.warnings { border-left: 3px solid #d8a23a; background: #faf3e1; padding: 10px 16px; margin: 24px 0 0;
  font-size: 15px; }
.warnings p { margin: 3px 0; }
table { border-collapse: collapse; width: 100%; font-size: 14.5px; font-variant-numeric: tabular-nums; margin: 8px 0; }
th { text-align: left; font-weight: 600; color: #66717f; font-size: 13px; border-bottom: 1px solid #c9c5bb;
  padding: 6px 14px 6px 0; }
td { border-bottom: 1px solid #e3e0d8; padding: 7px 14px 7px 0; vertical-align: top; }
td:first-child, td.bars { white-space: nowrap; }
td.number, th.number { text-align: right; white-space: nowrap; }
tr.chosen td:first-child { font-weight: 600; color: #1f6f8b; }
tr.more { display: none; }
.call { border-radius: 999px; padding: 1px 9px; font-size: 12.5px; white-space: nowrap; }
.call.sure { background: #1f6f8b; color: #fff; } .call.possible { background: #f3e2bd; color: #6d4c0c; }
.call.not-it { background: #eceae3; color: #66717f; }
p.values { margin: 2px 0 8px; max-width: 52em; } td.values { min-width: 17em; }
.parameters { color: #47525f; font-size: 13.5px; }
.bar { display: inline-block; height: 9px; border-radius: 2px; background: #1f6f8b; vertical-align: 1px; }
.bar.pale { background: #bcd2da; }
.scroll { overflow-x: auto; }
.plots { display: grid; grid-template-columns: 1fr 1fr; gap: 22px 30px; }
.plot { min-width: 0; }
.plot p.about { min-height: 2.6em; margin: 0 0 4px; font-size: 14px; line-height: 1.3; }
.explorer.one .plots { grid-template-columns: 1fr; }
.explorer [hidden] { display: none; }
.controls { display: flex; flex-wrap: wrap; gap: 8px 16px; align-items: center; font-size: 14px; color: #47525f; }
.controls select { font: inherit; max-width: 15em; padding: 2px 4px; }
.controls button { font: inherit; border: 1px solid #c9c5bb; background: #fff; padding: 2px 10px; cursor: pointer;
  margin-left: -1px; } .controls button.on { background: #1f6f8b; border-color: #1f6f8b; color: #fff; }
.scale { max-width: 420px; margin: 10px 0 4px; font-size: 12.5px; color: #47525f; }
.scale .colours { height: 10px; border-radius: 2px; margin: 2px 0; }
.scale .marks { display: flex; justify-content: space-between; line-height: 1.3; }
.scale .marks span { flex: 0 0 0; white-space: nowrap; display: flex; flex-direction: column; align-items: center; }
.scale .marks span:first-child { align-items: flex-start; } .scale .marks span:last-child { align-items: flex-end; }
details { margin: 6px 0; }
summary { cursor: pointer; color: #66717f; font-size: 14px; }
footer { margin-top: 64px; border-top: 1px solid #e3e0d8; padding-top: 14px; color: #66717f; font-size: 14px; }
footer dt { font-weight: 600; color: #47525f; } footer dd { margin: 0 0 6px; max-width: 50em; }
code { font: 13.5px ui-monospace, "SF Mono", Consolas, "DejaVu Sans Mono", monospace; background: #f1eee6;
  padding: 1px 5px; border-radius: 3px; }
.narrow { display: none; } .narrow p { font-size: 14px; margin: 6px 0; }
.lying { display: block; height: 12px; border-radius: 2px; margin-top: 2px; }
@media (max-width: 760px) { table { font-size: 13px; } th { font-size: 12px; } th, td { padding-right: 7px; }
  th.number { white-space: normal; }
  td.values { min-width: 38em; } svg.wide { display: none; } .narrow { display: block; }
  .answers, .plots, .explorer .plots { grid-template-columns: minmax(0, 1fr); } main { padding: 24px 16px 48px; }
  h1 { font-size: 27px; } }
@media print { main { max-width: none; } h2 { break-after: avoid; } .plot, table { break-inside: avoid; } }
"""
