// node open_page.mjs NODE_MODULES DIR[=CHART,...]...: opens DIR/report.html of each results folder (DIR may be a page itself) in
// headless Chromium, points at every chart and fails if a tooltip is missing, a chart is empty, or the console or the
// network has anything to say. DIR=CHART,...: the page must have these charts.
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, ...folders] = process.argv.slice(2);
const { chromium } = createRequire(resolve(modules, "playwright-core/package.json"))("playwright-core");
const flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync"];

function expect(holds, text) {
  if (!holds) throw new Error(text);
}

async function centre(chart) {
  await chart.scrollIntoViewIfNeeded();
  const box = await chart.locator("canvas").boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2, width: box.width, height: box.height };
}

async function tooltipOf(page, chart) {
  const at = await centre(chart);
  const tooltip = page.locator("#vg-tooltip-element.visible");
  for (let step = 0; step < 80; ++step) {  // the timeline has no bar everywhere, and who waits long has none for a time
    const beside = step < 40 ? 0 : (step % 3 - 1) * 0.2 * at.height;
    await page.mouse.move(at.x + 4 * (step % 40) - 80, at.y + beside + step % 3);
    if (await tooltip.count()) return tooltip.innerText();
  }
  return "";
}

// A picture within a chart that the browser refuses would leave it white, without a word.
async function expectStressWaves(page, chart) {
  await chart.scrollIntoViewIfNeeded();
  const colours = await chart.locator("canvas").evaluate((canvas) => {
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    return new Set(new Uint32Array(pixels.buffer)).size;
  });
  expect(colours > 100, `the stress waves have only ${colours} colours`);
  const text = await tooltipOf(page, chart);
  expect(/axial position \[/.test(text) && /axial stress \[.*Pa\]\s*[−-]?\d/.test(text), `tooltip of the stress waves: ${text}`);
}

// The pointer finds the stress of the element below it, and the picture has the colours of its scale and dark lines.
async function expectDeformedBodies(page, chart) {
  await chart.scrollIntoViewIfNeeded();
  const { colours, dark, white } = await chart.locator("canvas").evaluate((canvas) => {
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    const seen = new Set(new Uint32Array(pixels.buffer));
    let dark = 0, white = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      if (pixels[i] + pixels[i + 1] + pixels[i + 2] < 150) ++dark;
      if (pixels[i] + pixels[i + 1] + pixels[i + 2] === 765) ++white;
    }
    return { colours: seen.size, dark: dark / (pixels.length / 4), white: white / (pixels.length / 4) };
  });
  expect(colours > 100, `the bodies have only ${colours} colours`);
  expect(dark > 0.001 && dark < 0.3, `a share of ${dark} of the bodies' picture is dark`);
  expect(white > 0.1 && white < 0.95, `a share of ${white} of the bodies' picture is white`);
  const place = await page.evaluate(() => {
    const chart = JSON.parse(document.getElementById("charts").textContent).find((c) => c.id === "deformed_bodies");
    const row = chart.rows[Math.floor(chart.rows.length / 2)];
    return { x: row[0], y: row[1], body: row[4], width: chart.spec.width, height: chart.spec.height };
  });
  const box = await chart.locator("canvas").boundingBox();
  // The legend above moves the plot down, by what the canvas is higher than the plot and its margin of 5 px below.
  await page.mouse.move(box.x + 5 + place.x, box.y + box.height - 5 - place.height + place.y);
  const tooltip = page.locator("#vg-tooltip-element.visible");
  await tooltip.waitFor({ timeout: 5000 });
  const text = await tooltip.innerText();
  expect(/time \[.*s\]/.test(text) && /stress \[.*Pa\]\s*[−-]?\d/.test(text) && text.includes(place.body),
    `tooltip of the deformed bodies: ${text}`);
  await page.mouse.move(5, 5);
}

async function dragEnlargesAllChartsOverTime(page) {
  const overTime = await page.evaluate(() =>
    JSON.parse(document.getElementById("charts").textContent).find((chart) => chart.link === "time").id);
  const at = await centre(page.locator("#" + overTime));
  const range = () => page.evaluate(() => views.filter((v) => v.link === "time")
    .map((v) => [v.view.signal("from"), v.view.signal("to")]));
  const before = await range();
  await page.mouse.move(at.x - 100, at.y);
  await page.mouse.down();
  await page.mouse.move(at.x + 100, at.y, { steps: 5 });
  await page.mouse.up();
  await page.waitForFunction((from) => views[0].view.signal("from") !== from, before[0][0], { timeout: 5000 });
  const left = await page.evaluate(() => views[0].view.signal("zoom_x"));
  expect(left.length === 0 || left[0] === left[1], "the dragged rectangle stays on the chart");
  const enlarged = await range();
  for (const [from, to] of enlarged) {
    expect(from === enlarged[0][0] && to === enlarged[0][1], "the charts over time are enlarged differently");
    expect(to - from < 0.5 * (before[0][1] - before[0][0]), `dragging did not enlarge: ${from} to ${to}`);
  }
  await page.mouse.dblclick(at.x, at.y);
  expect(JSON.stringify(await range()) === JSON.stringify(before), "a double click does not go back");
}

async function check(browser, argument) {
  const [folder, wanted] = argument.split("=");
  const page = await browser.newPage({ viewport: { width: 1200, height: 900 } });
  const complaints = new Set();
  page.on("console", (message) => complaints.add(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => complaints.add(`error: ${error}`));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) complaints.add(`request of ${request.url()}`);
  });
  await page.goto(pathToFileURL(folder.endsWith(".html") ? resolve(folder) : resolve(folder, "report.html")).href);
  await page.waitForSelector("body[data-drawn]", { state: "attached" });
  const charts = page.locator(".chart");
  const count = await charts.count();
  expect(count > 0, "no charts");
  const drawn = await charts.locator("canvas").count();
  expect(drawn === count, `only ${drawn} of ${count} charts are drawn: ${[...complaints].join("\n")}`);
  const ids = await charts.evaluateAll((found) => found.map((chart) => chart.id));
  for (let i = 0; i < count; ++i) {
    const text = await tooltipOf(page, charts.nth(i));
    expect(/\d/.test(text), `no tooltip with a value on ${ids[i]}`);
    await page.mouse.move(5, 5);
    if (ids[i].startsWith("axial_stress")) await expectStressWaves(page, charts.nth(i));
    if (ids[i] === "deformed_bodies") await expectDeformedBodies(page, charts.nth(i));
  }
  for (const id of wanted ? wanted.split(",") : []) expect(ids.includes(id), `no chart ${id} among ${ids.join(", ")}`);
  if (await page.evaluate(() => views.some((v) => v.link === "time"))) await dragEnlargesAllChartsOverTime(page);
  expect(complaints.size === 0, [...complaints].join("\n"));
  console.log(`${folder}: ${ids.join(", ")}`);
  if (process.env.SCREENSHOT) await page.screenshot({ path: resolve(folder, "report.png"), fullPage: true });
  await page.close();
}

const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: flags });
try {
  for (const folder of folders) {
    try {
      await check(browser, folder);
    } catch (error) {
      console.error(`${folder}: ${error.message}`);
      process.exitCode = 1;
    }
  }
} finally {
  await browser.close();
}
