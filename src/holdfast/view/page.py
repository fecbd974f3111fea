"""The HTML page around the 3D picture; its security policy forbids all network requests."""

from __future__ import annotations

from typing import Final

PAGE: Final = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval';
 style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:">
<title>$title</title>
<style>
* { box-sizing: border-box; }
html, body { height: 100%; margin: 0; }
body { display: flex; flex-direction: column; color: #14171c; background: #fff;
  font: 15px/1.4 system-ui, "Segoe UI", "DejaVu Sans", Arial, sans-serif; }
header { padding: 14px 22px 10px; border-bottom: 1px solid #dfe2e7; }
h1 { font-size: 22px; margin: 0; }
header p { margin: 2px 0 0; color: #59606b; }
main { flex: 1; min-height: 0; display: flex; }
#plot { flex: 1; min-width: 0; }
aside { width: 290px; padding: 14px 20px; border-right: 1px solid #dfe2e7; overflow-y: auto; }
h2 { font-size: 15px; margin: 18px 0 6px; }
h2:first-child { margin-top: 0; }
label { display: flex; align-items: center; gap: 8px; padding: 2px 0; cursor: pointer; }
label i { width: 22px; height: 14px; border: 1px solid #14171c55; flex: none; }
button { font: inherit; padding: 4px 12px; margin: 0 6px 6px 0; border: 1px solid #b9bec7; border-radius: 5px;
  background: #f5f6f8; cursor: pointer; }
ol { margin: 0; padding: 0; list-style: none; counter-reset: push; }
li { counter-increment: push; display: flex; gap: 8px; padding: 3px 0; }
li::before { content: counter(push); flex: none; width: 21px; height: 21px; border-radius: 50%; background: #14171c;
  color: #fff; font-size: 12px; font-weight: 700; text-align: center; line-height: 21px; }
</style>
</head>
<body>
<header><h1>$title</h1><p>$subtitle</p></header>
<main>
<aside>
<h2>Look</h2>
<button data-view="front">from above</button><button data-view="back">from below</button>
<label><input type="checkbox" id="glass">see-through bodies</label>
<h2>Show</h2>
$switches
$weakest
</aside>
<div id="plot"></div>
</main>
<script>$plotly</script>
<script id="data" type="application/json">$data</script>
<script>
(function () {
  var data = JSON.parse(document.getElementById("data").textContent), plot = document.getElementById("plot");
  var bodies = [];
  data.traces.forEach(function (trace, number) {
    if (trace.cell_texts) {
      trace.text = [];
      trace.cell_counts.forEach(function (count, cell) {
        for (var k = 0; k < count; k++) { trace.text.push(trace.cell_texts[cell]); }
      });
    }
    if (trace.solid_body) { bodies.push(number); }
    delete trace.cell_texts; delete trace.cell_counts; delete trace.solid_body;
  });
  data.layout.scene.annotations = data.badges;
  Plotly.newPlot(plot, data.traces, data.layout, {responsive: true, displaylogo: false, scrollZoom: true});
  function show(box) {
    Plotly.restyle(plot, {visible: box.checked}, box.dataset.traces.split(",").map(Number));
    if (box.dataset.role === "pushes") {
      Plotly.relayout(plot, {"scene.annotations": box.checked ? data.badges : []});
    }
  }
  document.querySelectorAll("input[data-traces]").forEach(function (box) {
    box.onchange = function () { show(box); };
  });
  document.getElementById("glass").onchange = function () {
    Plotly.restyle(plot, {opacity: this.checked ? 0.3 : 1}, bodies);
  };
  document.querySelectorAll("button[data-view]").forEach(function (button) {
    button.onclick = function () {
      var fixed = document.querySelector("input[data-role=fixed]"), above = button.dataset.view === "front";
      if (fixed && fixed.checked !== above) { fixed.checked = above; show(fixed); }
      Plotly.relayout(plot, {"scene.camera": data.views[button.dataset.view]});
    };
  });
})();
</script>
</body>
</html>
"""
