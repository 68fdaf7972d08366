"""The scripts of a page with surfaces: one camera for all of them, and picking captures and states."""

LINKED_CAMERAS = """
(() => {
  const scenes = [...document.querySelectorAll('.drawn')].filter(d => d.layout && d.layout.scene);
  let turning = false;
  const turn = (from, change) => {
    const camera = change['scene.camera'] || (change['scene.camera.eye'] && from.layout.scene.camera);
    if (!camera || turning) return;
    turning = true;
    Promise.all(scenes.filter(d => d !== from && d.offsetParent).map(d => Plotly.relayout(d, {'scene.camera': camera})))
      .finally(() => { turning = false; });
    scenes.forEach(d => { if (!d.offsetParent) d.layout.scene.camera = camera; });
  };
  scenes.forEach(d => {
    d.on('plotly_relayouting', change => turn(d, change));
    d.on('plotly_relayout', change => turn(d, change));
  });
})();
"""
"""Turning one surface of the page turns all of them."""

EXPLORER = """
document.querySelectorAll('.explorer').forEach(box => {
  const data = JSON.parse(box.querySelector('script').textContent), plots = [...box.querySelectorAll('.drawn')];
  const list = box.querySelector('select'), names = box.querySelector('input');
  const weigh = (row, at) => [0, 1, 2].map(a => row.reduce((sum, w, m) => sum + w * at[m][a], 0));
  const along = (points, a) => points.map(p => p && p[a]);
  const axes = points => ({x: along(points, 0), y: along(points, 1), z: along(points, 2)});
  const off = p => p.map((v, a) => v + data.off[a]);
  const above = (points, by) => points.map((p, n) => p.map((v, a) => v + by[n][a]));
  const shade = e => e === null ? null
    : Math.min(1, Math.log2(Math.max(1, e / data.floor)) / Math.log2(data.steps));
  const said = (name, e) => e === null ? name + ': not seen'
    : `${name}: ${Number(e.toPrecision(3))} ${data.units}<br>${(e / data.floor).toFixed(1)} floors`;
  const draw = () => {
    const n = Number(list.value), at = n < 0 ? data.rest : data.shapes[n];
    const skin = data.weight.map(row => weigh(row, at));
    const lines = data.ends.flatMap(pair => [...pair.map(row => off(weigh(row, at))), null]);
    const middles = above(data.middles.map(row => weigh(row, at)), data.above[1]);
    plots.forEach((plot, state) => {
      const error = n < 0 ? data.errors[state] : data.each[state][n];
      const traces = plot.data.map(t => ({...t}));
      Object.assign(traces[0], axes(at.map(off)), {hovertext: error.map((e, m) => said(data.names[m], e)),
        customdata: error, marker: {...traces[0].marker, color: error.map(shade)}});
      if (skin.length) {
        const known = error.map(e => e === null ? 0 : e);
        const over = data.weight.map(row => shade(Math.max(0, row.reduce((sum, w, m) => sum + w * known[m], 0))));
        Object.assign(traces[2], axes(skin), {intensity: over});
      }
      if (lines.length) { Object.assign(traces[3], axes(lines)); Object.assign(traces[4], axes(middles)); }
      Object.assign(traces[1], axes(above(at, data.above[0])), {visible: names.checked});
      Plotly.react(plot, traces, {...plot.layout, uirevision: 'kept'});
    });
  };
  list.onchange = names.onchange = draw;
  box.querySelectorAll('[data-go]').forEach(button => button.onclick = () => {
    const worst = list.querySelector('[data-worst]');
    if (button.dataset.go === 'worst') list.value = worst ? worst.value : '-1';
    else list.selectedIndex = Math.max(0, Math.min(list.length - 1, list.selectedIndex + Number(button.dataset.go)));
    draw();
  });
  const show = which => {
    box.querySelectorAll('.state').forEach((state, i) => state.hidden = which !== 'all' && which !== String(i));
    box.classList.toggle('one', which !== 'all');
    box.querySelectorAll('[data-show]').forEach(b => b.classList.toggle('on', b.dataset.show === which));
    plots.filter(p => p.offsetParent).forEach(p => {
      Plotly.Plots.resize(p);
      Plotly.relayout(p, {'scene.camera': p.layout.scene.camera});
    });
  };
  box.querySelectorAll('[data-show]').forEach(button => button.onclick = () => show(button.dataset.show));
  if (box.querySelector('[data-show]') && window.matchMedia('(max-width: 760px)').matches) show('0');
});
"""
"""What the lists and buttons of `surface_explorer` do."""
