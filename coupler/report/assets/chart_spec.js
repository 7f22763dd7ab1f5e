// From an entry of <script id="charts">, {id, title, note, link, columns, rows, spec} (see chart.hpp), to a Vega-Lite
// specification: what the page and the pictures (draw_pictures.js) share.
"use strict";

const chartConfig = {
  font: "system-ui, sans-serif",
  background: "#ffffff",
  axis: { labelFontSize: 12, titleFontSize: 12, titleFontWeight: "normal", gridColor: "#e4e4e4" },
  axisY: { minExtent: 66, titlePadding: 8 },
  legend: { orient: "top", labelFontSize: 12, labelLimit: 300, symbolSize: 900, symbolStrokeWidth: 2 },
  view: { stroke: "#999999" },
};

function named(columns, row) {
  return Object.fromEntries(columns.map((column, i) => [column, row[i]]));
}

function withData(chart) {
  return { ...chart.spec, data: { values: chart.rows.map((row) => named(chart.columns, row)) } };
}
