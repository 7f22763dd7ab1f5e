// node open_page.mjs NODE_MODULES DIR[=CHART,...]...: opens DIR/report.html of each results folder (DIR may be a page itself) in
// headless Chromium, points at every chart and fails if a tooltip is missing, a chart is empty, or the console or the
// network has anything to say. DIR=CHART,...: the page must have these charts.
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, ...folders] = process.argv.slice(2);
const { chromium } = createRequire(resolve(modules, "playwright-core/package.json"))("playwright-core");
const flags = ["--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
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

// How many colours the bodies' canvas has, which share of it is not white, and a number that tells pictures apart.
function pictureOf(page) {
  return page.evaluate(() => {
    const source = bodyViewer.renderer.domElement, copy = document.createElement("canvas");
    Object.assign(copy, { width: source.width, height: source.height });
    const context = copy.getContext("2d");
    context.drawImage(source, 0, 0);
    const pixels = new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
    let drawn = 0, hash = 0;
    for (const pixel of pixels) {
      if (pixel !== 0xffffffff) ++drawn;
      hash = (Math.imul(hash, 31) + pixel) | 0;
    }
    return { colours: new Set(pixels).size, drawn: drawn / pixels.length, hash };
  });
}

// A scene that has not run has no times; each kind of element and each mark has its colour in the picture and in the legend.
async function expectKindsAndMarks(page) {
  expect(!(await page.getByLabel("time", { exact: true }).isVisible()), "there is a slider for a single time");
  const missing = await page.evaluate(() => {
    const canvas = bodyViewer.renderer.domElement, copy = document.createElement("canvas");
    Object.assign(copy, { width: canvas.width, height: canvas.height });
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add("#" + [0, 1, 2].map((c) => data[i + c].toString(16).padStart(2, "0")).join(""));
    return bodyViewer.bodies.marks.filter((mark) => !seen.has(mark.colour)).map((mark) => mark.name);
  });
  expect(missing.length === 0, `no dots of ${missing.join(", ")}`);
  const named = await page.locator(".legend span").allInnerTexts(), marks = await page.evaluate(() => bodyViewer.bodies.marks.length);
  expect(named.length === marks + 2 && named.includes("contact") && named.some((name) => /: integrated implicitly/.test(name)),
    `the legend has ${named.join(", ")}`);
}

// A body that yields is coloured by its plastic strain, too, and bodies that press each other by that pressure.
async function expectFields(page) {
  const fields = page.locator("select.field");
  expect(await fields.count() === await page.evaluate(() => (bodyViewer.bodies.fields.length > 1 ? 1 : 0)), "no choice of colours");
  if (!(await fields.count())) return;
  const offered = await fields.locator("option").allInnerTexts();
  const time = page.getByLabel("time", { exact: true });
  await time.fill(await time.getAttribute("max"));  // at the start there is neither
  const before = await pictureOf(page);
  for (const [name, unit] of [["equivalent plastic strain", "%"], ["contact pressure", ".?Pa"]].filter(([name]) => offered.includes(name))) {
    await fields.selectOption(name);
    expect((await pictureOf(page)).hash !== before.hash, `${name} has the colours of stress`);
    expect(new RegExp(`${name} \\[${unit}\\]`).test(await page.locator(".legend").innerText()), "the legend is that of stress");
  }
}

// Every contact of the scene whose bodies press each other has a button, one with a rigid obstacle, too.
async function expectContacts(page) {
  const { names, wanted, pressed } = await page.evaluate(() => {
    const { bodies, touching, fields } = bodyViewer.bodies, told = touching ?? [];
    return { names: bodyViewer.bodies.contacts().map((contact) => contact.name),
      wanted: [...new Set(told.map((pair) => pair.filter((b) => b >= 0).map((b) => bodies[b].name).join(" – ")))],
      pressed: fields.some((field) => field.key === "contact_pressure_pa") };
  });
  if (pressed) expect(wanted.length > 0 && names.join() === wanted.join(), `contacts ${wanted} have the buttons ${names}`);
}

// One body alone shows the surface that the other one hides.
async function expectOneBody(page) {
  const choice = page.locator("select.bodies"), all = await pictureOf(page);
  const wanted = await page.evaluate(() => {
    const { solid, kinds, bodies } = bodyViewer.bodies;
    return solid && !kinds && bodies.length > 1;
  });
  expect((await choice.count()) === (wanted ? 1 : 0), "no choice of bodies, or one too many");
  if (!wanted) return;
  for (const name of (await choice.locator("option").allInnerTexts()).slice(1)) {
    await choice.selectOption(name);
    const one = await pictureOf(page);
    expect(one.hash !== all.hash && one.drawn > 0.002 && one.drawn < all.drawn, `"${name}" alone: ${JSON.stringify(one)}`);
  }
  await choice.selectOption("all");
  expect((await pictureOf(page)).hash === all.hash, "not all bodies are back");
}

// The bodies are seen, and answer to a drag, to buttons, to the pointer and to the time; a telephone shows the page, too.
async function expectDeformedBodies(page) {
  const canvas = page.locator("#deformed_bodies canvas");
  await canvas.scrollIntoViewIfNeeded();
  const first = await pictureOf(page);
  expect(first.colours > 8 && first.drawn > 0.005 && first.drawn < 0.95, `the bodies: ${JSON.stringify(first)}`);
  const box = await canvas.boundingBox(), x = box.x + box.width / 2, y = box.y + box.height / 2;
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y + 40, { steps: 4 });
  await page.mouse.up();
  const dragged = await pictureOf(page);
  expect(dragged.hash !== first.hash && dragged.drawn > 0.002, "a drag does not move the bodies");
  await page.getByRole("button", { name: "Whole" }).click();
  expect((await pictureOf(page)).hash === first.hash, "the button does not go back to the whole");
  const contact = page.locator("button.contact").first();
  if (await contact.count()) {
    await contact.click();
    expect((await pictureOf(page)).hash !== first.hash, "the button does not go to the contact");
    await page.mouse.move(x + 9, y + 9);
    await page.mouse.move(x + 8, y + 8);
    const text = await page.locator(".pointed").innerText().catch(() => "");
    const at = await page.locator(".pointed").isVisible();
    const said = await page.evaluate(() => bodyViewer.bodies.kinds) ? /: integrated (ex|im)plicitly/ : /stress [−-]?[\d.e+-]+ .*Pa/;
    expect(!at || said.test(text), `the pointer finds: ${text}`);
    await page.getByRole("button", { name: "Whole" }).click();
  }
  const section = page.locator("select.section");
  if (await section.count()) {
    await section.selectOption("x");
    expect((await pictureOf(page)).hash !== first.hash, "the section cuts nothing");
    await section.selectOption("none");
  }
  await expectOneBody(page);
  await expectContacts(page);
  if (await page.evaluate(() => bodyViewer.bodies.kinds)) {
    await expectKindsAndMarks(page);
  } else {
    const time = page.getByLabel("time", { exact: true });
    await time.fill((await time.inputValue()) === "0" ? await time.getAttribute("max") : "0");
    expect((await pictureOf(page)).hash !== first.hash, "another time has the same picture");
    await expectFields(page);
  }
  await page.setViewportSize({ width: 390, height: 800 });
  await page.waitForFunction(() => bodyViewer.width < 390);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  expect(wide <= 390, `a page of 390 px is ${wide} px wide`);
  if (process.env.SCREENSHOT) await page.screenshot({ path: `${process.env.SCREENSHOT}.phone.png` });
  await page.setViewportSize({ width: 1200, height: 900 });
  await page.mouse.move(5, 5);
}

// A browser without WebGL says so in words.
async function expectWordsWithoutWebGl(browser, address) {
  const page = await browser.newPage();
  await page.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
  await page.goto(address);
  const text = await page.locator("#deformed_bodies").innerText();
  expect(text.includes("This browser has no WebGL 2"), `without WebGL the page says: ${text}`);
  await page.close();
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
  const wantedCount = await page.evaluate(() => JSON.parse(document.getElementById("charts").textContent).length);
  expect(count === wantedCount && (count > 0 || folder.endsWith("scene.html")), `${count} charts`);
  const drawn = await charts.locator("canvas").count();
  expect(drawn === count, `only ${drawn} of ${count} charts are drawn: ${[...complaints].join("\n")}`);
  const ids = await charts.evaluateAll((found) => found.map((chart) => chart.id));
  for (let i = 0; i < count; ++i) {
    const text = await tooltipOf(page, charts.nth(i));
    expect(/\d/.test(text), `no tooltip with a value on ${ids[i]}`);
    await page.mouse.move(5, 5);
    if (ids[i].startsWith("axial_stress")) await expectStressWaves(page, charts.nth(i));
  }
  if (await page.locator("#deformed_bodies").count()) {
    ids.push("deformed_bodies");
    await expectDeformedBodies(page);
    await expectWordsWithoutWebGl(browser, page.url());
  }
  if (folder.endsWith("solids")) expect(await page.locator("select.field").count() === 1, "the solids do not yield");
  for (const id of wanted ? wanted.split(",") : []) expect(ids.includes(id), `no chart ${id} among ${ids.join(", ")}`);
  if (count > 0 && await page.evaluate(() => views.some((v) => v.link === "time"))) await dragEnlargesAllChartsOverTime(page);
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
