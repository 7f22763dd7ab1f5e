// Draws the charts of <script id="charts"> with what chart_spec.js, before it in the page, makes of them.
"use strict";

const views = [];  // {link, view, from, to, rows}

// Charts over time have the time as their first column, and draw and scale only what lies in the range.
function hasSomethingIn(chart, from, to) {
  if (chart.link !== "time") return true;
  const inside = chart.rows.filter((row) => from <= row[0] && row[0] <= to);
  return inside.filter((row) => row.slice(1).some((value) => value !== null)).length > 1;
}

function showRange(link, from, to) {
  const linked = views.filter((other) => other.link === link);
  if (from !== null && !linked.every((other) => hasSomethingIn(other, from, to))) return;
  for (const other of linked) {
    other.view.signal("from", from ?? other.from).signal("to", to ?? other.to).runAsync();
  }
}

// A dragged interval is not kept as a selection: it becomes the range of all charts that are linked.
function enlargeOnDrag(chart, view) {
  const field = chart.link === "time" ? "zoom_time" : "zoom_begin";
  let dragged = null;
  view.addSignalListener(field, (name, range) => { dragged = range; });
  window.addEventListener("pointerup", async () => {
    if (!dragged || dragged[0] === dragged[1]) return;
    const [from, to] = dragged[0] < dragged[1] ? dragged : [dragged[1], dragged[0]];
    dragged = null;
    await view.signal("zoom_x", [0, 0]).runAsync();  // before the range, from which it would be computed anew
    dragged = null;
    showRange(chart.link, from, to);
  });
  view.addEventListener("dblclick", () => showRange(chart.link, null, null));
}

async function draw(chart) {
  const { view } = await vegaEmbed("#" + chart.id, withData(chart), {
    mode: "vega-lite",
    renderer: "canvas",
    actions: { export: true, source: false, compiled: false, editor: false },
    downloadFileName: chart.id,
    config: chartConfig,
  });
  if (chart.link === "") return;  // nothing to enlarge
  views.push({ link: chart.link, rows: chart.rows, view, from: view.signal("from"), to: view.signal("to") });
  enlargeOnDrag(chart, view);
}

async function drawAll() {
  for (const chart of JSON.parse(document.getElementById("charts").textContent)) {
    try {
      await draw(chart);
    } catch (error) {
      document.getElementById(chart.id).textContent = "This chart could not be drawn: " + error.message;
      console.error(error);
    }
  }
  document.body.dataset.drawn = "true";
}

drawAll();
