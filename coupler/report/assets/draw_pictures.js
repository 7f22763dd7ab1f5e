// node -e SCRIPT FOLDER < PAGE: draws the charts of a page that ricochet made just now to FOLDER/<id>.svg, with the
// libraries in the page.
// Title and note of the chart, which stand beside it in the page, join the picture; what only answers to a pointer (layers
// with the name "pointer") is left out.
"use strict";
const fs = require("fs");
const [folder] = process.argv.slice(1);

const scripts = [...fs.readFileSync(0, "utf8").matchAll(/<script([^>]*)>([^]*?)<\/script>/g)];
const stored = scripts.find((script) => script[1].includes("id=\"charts\""));
if (!stored) {
  console.error("the page holds no charts");
  process.exit(1);
}

// Evaluated as in a browser, where libraries find no module system and become properties of the global object.
function library(name, result) {
  const code = scripts.find((script) => script[2].startsWith(`/*! ${name}\n`))[2];
  return new Function("exports", "module", "define", `${code}\nreturn ${result};`).call(globalThis);
}
const vega = library("vega", "globalThis.vega");
const vegaLite = library("vega-lite", "globalThis.vegaLite");
const { chartConfig, withData } = library("chart_spec", "{ chartConfig, withData }");

function lines(text, width) {
  const result = [""];
  for (const word of text.split(" ")) {
    const last = result.at(-1);
    if (last !== "" && last.length + 1 + word.length > width) result.push(word);
    else result[result.length - 1] = last === "" ? word : `${last} ${word}`;
  }
  return result;
}

async function draw(chart) {
  const spec = withData(chart);
  spec.layer = spec.layer.filter((layer) => layer.name !== "pointer");
  spec.title = { text: chart.title, anchor: "start", fontSize: 15, offset: 12 };
  const width = Math.max(spec.width, 600);
  if (chart.note) Object.assign(spec.title, { subtitle: lines(chart.note, width / 5.7), subtitleColor: "#555555" });
  const config = { ...chartConfig, mark: { aria: false }, padding: 8 };
  const view = new vega.View(vega.parse(vegaLite.compile(spec, { config }).spec), { renderer: "none" });
  view.logLevel(vega.Error);
  fs.writeFileSync(`${folder}/${chart.id}.svg`, await view.toSVG());
}

(async () => {
  for (const chart of JSON.parse(stored[2])) {
    if (!/^[A-Za-z0-9_]+$/.test(chart.id)) throw new Error("a chart whose name is no name of a file");
    await draw(chart);
  }
})();
