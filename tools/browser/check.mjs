// Opens pages (.html) and drawings (.svg) in a headless browser and measures what the rules of the look ask
// for: no label overlaps or is cut, contrast, size of text, no sideways scroll, no message, no request,
// the marks that scripts rely on.
//
//   node check.mjs [--shots DIR] [--expect-failure] FILE...
//
// Exit code 0: all files pass (with --expect-failure: every file fails), else 1.

import { readFileSync, statSync, mkdirSync } from "node:fs";
import { basename, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const WIDTHS = [350, 538, 1120, 1280];
const PAPER = 702; // A4 less the margins of the page, in pixels
const MOST_BYTES = 2_000_000;
const LEAST_CONTRAST = 4.5;
const LEAST_TEXT = 9.5;

const args = process.argv.slice(2);
const expectFailure = take("--expect-failure");
const shots = takeValue("--shots");
if (args.length === 0) {
  console.error("usage: node check.mjs [--shots DIR] [--expect-failure] FILE...");
  process.exit(2);
}
if (shots) mkdirSync(shots, { recursive: true });

function take(flag) {
  const at = args.indexOf(flag);
  if (at < 0) return false;
  args.splice(at, 1);
  return true;
}

function takeValue(flag) {
  const at = args.indexOf(flag);
  if (at < 0) return null;
  return args.splice(at, 2)[1];
}

// Everything below runs inside the page.
function measure({ leastContrast, leastText, isPrint }) {
  const problems = [];
  const visible = (e) => {
    const r = e.getBoundingClientRect();
    return r.width > 0 && r.height > 0 && getComputedStyle(e).visibility !== "hidden";
  };
  const name = (e) => `"${(e.textContent || "").trim().slice(0, 40)}"`;
  const shrink = 0.5;
  const overlap = (a, b) =>
    Math.min(a.right, b.right) - Math.max(a.left, b.left) > shrink &&
    Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > shrink;

  // Drawings.
  const drawings = [...document.querySelectorAll("svg")].filter(
    (s) => visible(s) && !s.parentElement?.closest("svg"),
  );
  for (const svg of drawings) {
    const where = svg.closest("figure")
      ? `${svg.closest("figure").dataset.plot} ${svg.closest("figure").dataset.axis || ""}`.trim()
      : "drawing";
    const frame = svg.getBoundingClientRect();
    const box = svg.viewBox.baseVal;
    const scale = box && box.width ? frame.width / box.width : 1;
    const texts = [...svg.querySelectorAll("text")].filter(visible);
    const rects = texts.map((t) => t.getBoundingClientRect());
    for (let i = 0; i < texts.length; i++) {
      const size = parseFloat(getComputedStyle(texts[i]).fontSize) * scale;
      if (size < (isPrint ? 9 : leastText) - 0.01) problems.push(`${where}: text of ${size.toFixed(2)} px: ${name(texts[i])}`);
      if (svg.closest("figure") && !isPrint && size > 16) {
        problems.push(`${where}: text of ${size.toFixed(1)} px: ${name(texts[i])}`);
      }
      const r = rects[i];
      if (
        r.left < frame.left - 1 || r.right > frame.right + 1 ||
        r.top < frame.top - 1 || r.bottom > frame.bottom + 1
      ) {
        problems.push(`${where}: cut: ${name(texts[i])}`);
      }
      for (let j = i + 1; j < texts.length; j++) {
        if (overlap(r, rects[j])) problems.push(`${where}: ${name(texts[i])} overlaps ${name(texts[j])}`);
      }
    }
    if (svg.getAttribute("role") !== "img") problems.push(`${where}: no role="img"`);
    const title = svg.querySelector(":scope > title");
    if (!title || !title.textContent.trim()) problems.push(`${where}: no <title>`);
  }

  // Figures.
  for (const figure of document.querySelectorAll("figure")) {
    const shown = [...figure.querySelectorAll("svg")].filter(visible).length;
    if (shown !== 1) problems.push(`${figure.dataset.plot}: ${shown} drawings visible`);
    if (!figure.dataset.plot) problems.push("a figure without data-plot");
    if (!figure.querySelector("figcaption")) problems.push(`${figure.dataset.plot}: no caption`);
  }

  // Sideways scroll, and boxes that stick out of the page.
  const root = document.scrollingElement;
  if (root && document.documentElement.localName === "html") {
    if (root.scrollWidth > window.innerWidth) {
      problems.push(`sideways scroll: ${root.scrollWidth} px on ${window.innerWidth} px`);
    }
    for (const e of document.querySelectorAll("main *")) {
      if (e.closest("svg") || !visible(e)) continue;
      const r = e.getBoundingClientRect();
      if (r.right > window.innerWidth + 0.5 || r.left < -0.5) {
        problems.push(`sticks out: <${e.localName}> ${name(e)}`);
        break;
      }
    }
    // Text that is cut by its own box, and cells that overlap.
    for (const e of document.querySelectorAll("td, th, dd, dt, p, h1, h2, h3, figcaption")) {
      if (visible(e) && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline") {
        problems.push(`cut: <${e.localName}> ${name(e)}`);
      }
    }
  }

  // Contrast.
  const canvas = document.createElementNS("http://www.w3.org/1999/xhtml", "canvas");
  canvas.width = canvas.height = 1;
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  const rgba = (text) => {
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = text;
    pen.fillRect(0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data].map((v) => v / 255);
  };
  const over = (top, under) => top.slice(0, 3).map((v, i) => v * top[3] + under[i] * (1 - top[3]));
  const luminance = (c) => {
    const [r, g, b] = c.map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (e) => {
    const layers = [];
    for (let at = e; at; at = at.parentElement) {
      const c = rgba(getComputedStyle(at).backgroundColor);
      if (c[3] > 0) layers.push(c);
      if (c[3] >= 1) break;
    }
    let color = rgba(getComputedStyle(document.documentElement).colorScheme.includes("dark") &&
      matchMedia("(prefers-color-scheme: dark)").matches && !isPrint ? "#121212" : "#ffffff").slice(0, 3);
    for (const layer of layers.reverse()) color = over(layer, color);
    return color;
  };
  const seen = new Set();
  const walker = document.createTreeWalker(document.documentElement, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const e = node.parentElement;
    if (!node.textContent.trim() || !e || e.closest("title, desc, style, head")) continue;
    if (!visible(e)) continue;
    const style = getComputedStyle(e);
    const svg = e.closest("svg");
    // A halo is the ground of its text.
    const halo = svg && style.stroke !== "none" && style.paintOrder.startsWith("stroke");
    const standalone = svg && svg === document.documentElement;
    const under = halo
      ? rgba(style.stroke).slice(0, 3)
      : standalone
        ? rgba(getComputedStyle(svg).getPropertyValue("--page")).slice(0, 3)
        : ground(svg ? svg.parentElement : e);
    const color = over(rgba(svg ? style.fill : style.color), under);
    const [a, b] = [luminance(color), luminance(under)].sort((p, q) => q - p);
    const contrast = (a + 0.05) / (b + 0.05);
    if (contrast < leastContrast) {
      const line = `contrast ${contrast.toFixed(2)}: ${name(e)}`;
      if (!seen.has(line)) problems.push(line);
      seen.add(line);
    }
    if (!svg && parseFloat(style.fontSize) < (isPrint ? 9 : 11)) problems.push(`small text, ${style.fontSize}: ${name(e)}`);
  }
  return problems;
}

// The marks of a page, once a page.
function structure({ characterize }) {
  const problems = [];
  const need = (ok, what) => { if (!ok) problems.push(what); };
  const all = (q, root = document) => [...root.querySelectorAll(q)];
  need(document.documentElement.lang, "no <html lang>");
  need(all("h1").length === 1, `${all("h1").length} <h1>`);
  for (const part of ["header", "main", "footer"]) {
    need(all(`body > ${part}`).length === 1, `<${part}> is not one child of <body>`);
  }
  need(document.querySelector(".verdict")?.textContent.trim(), "no verdict");
  const ids = all("[id]").map((e) => e.id);
  need(new Set(ids).size === ids.length, `ids twice: ${ids.filter((v, i) => ids.indexOf(v) !== i)}`);
  need(all("script, link[rel=stylesheet], img, iframe").length === 0, "something is loaded");
  for (const figure of all("figure")) {
    const svg = figure.querySelector("svg");
    need(svg?.querySelector("title"), `${figure.dataset.plot}: no title`);
  }
  if (!characterize) return problems;
  need(/: characterisation — sagnac$/.test(document.title), `title "${document.title}"`);
  for (const id of ["parameters", "issues", "allan", "spectrum", "series", "limits", "method"]) {
    need(document.getElementById(id), `no section #${id}`);
  }
  need(/\b[0-9a-f]{64}\b/.test(document.getElementById("method")?.textContent ?? ""), "no SHA-256");
  need(/\b\d+\.\d+\.\d+\b/.test(document.getElementById("method")?.textContent ?? ""), "no version");
  const logs = all("section[data-log]");
  for (const scope of logs.length ? logs : [document]) {
    const axes = (plot) => all(`figure[data-plot=${plot}]`, scope).map((f) => f.dataset.axis).sort().join();
    need(axes("allan") !== "", "no Allan plots");
    need(axes("allan") === axes("spectrum"), `spectra of ${axes("spectrum")}, Allan of ${axes("allan")}`);
    need(axes("allan") === axes("series"), `series of ${axes("series")}, Allan of ${axes("allan")}`);
    need(all("figure[data-plot=issues]", scope).length === 1, "no issues plot");
    for (const figure of all("figure[data-plot=allan]", scope)) {
      for (const q of ["[data-unit=x]", "[data-unit=y]", "[data-series=measured]"]) {
        need(figure.querySelector(q), `allan ${figure.dataset.axis}: no ${q}`);
      }
    }
    const rows = all("table[data-table=parameters] tr[data-term]", scope);
    const terms = new Set(rows.map((r) => `${r.dataset.sensor} ${r.dataset.term}`));
    const wanted = {
      gyro: ["angle_random_walk", "bias_instability", "rate_random_walk", "mean"],
      accel: ["velocity_random_walk", "bias_instability", "acceleration_random_walk", "mean"],
    };
    for (const sensor of new Set(rows.map((r) => r.dataset.sensor))) {
      for (const term of wanted[sensor] ?? []) need(terms.has(`${sensor} ${term}`), `no row ${sensor} ${term}`);
    }
    for (const row of rows) {
      for (const cell of all("td", row)) {
        const text = cell.textContent;
        need(cell.dataset.axis && cell.dataset.status, `cell without marks in ${row.dataset.term}`);
        // The mean of an axis with levels is that of no stretch of it: without an interval, and only beside a step.
        const isMeanOfLevels = row.dataset.term === "mean" &&
          rows.some((r) => r.dataset.term === "step" && r.dataset.sensor === row.dataset.sensor);
        const estimate = !["lsb", "fit", "warm_up_time"].includes(row.dataset.term) && !isMeanOfLevels;
        if (estimate && cell.dataset.status === "detected") need(/[±…]/.test(text), `${row.dataset.term}: no interval`);
        if (cell.dataset.status === "upper_limit") need(text.includes("<"), `${row.dataset.term}: no <`);
      }
    }
  }
  return problems;
}

async function unitSwitch(page) {
  const problems = [];
  const table = () => page.locator("table[data-table=parameters]").first().innerText();
  const radios = page.locator("input[name=units]");
  if ((await radios.count()) < 2) return ["no unit switch"];
  const values = await radios.evaluateAll((r) => r.map((e) => e.value));
  if (!values.includes("si")) problems.push("no units `si`");
  if (values[0] === "si") problems.push("the first units are `si`");
  const before = await table();
  if (!/°\/√h|m\/s\/√h/.test(before)) problems.push("the field's units are not shown first");
  await page.locator("input[name=units][value=si]").check();
  const after = await table();
  if (before === after) problems.push("the unit switch changes nothing");
  if (!/rad\/√s|m\/s\/√s/.test(after) || /°\/√h/.test(after)) problems.push("SI does not show SI");
  await page.locator("input[name=units]").first().check();
  return problems;
}

const browser = await chromium.launch({
  executablePath: process.env.SAGNAC_CHROMIUM || "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu"],
});
let failed = 0;
for (const file of args) {
  const path = resolve(file);
  const isPage = path.endsWith(".html");
  const source = readFileSync(path, "utf8");
  const characterize = /characterisation — sagnac<\/title>/.test(source);
  const found = new Map();
  const add = (where, list) => {
    for (const problem of list) {
      if (!found.has(problem)) found.set(problem, []);
      found.get(problem).push(where);
    }
  };
  if (statSync(path).size > MOST_BYTES) add("file", [`${statSync(path).size} bytes`]);
  const stem = basename(path).replace(/\.\w+$/, "");
  // Scripts are off: what is measured is what a reader without them sees.
  const context = await browser.newContext({ javaScriptEnabled: false });
  const page = await context.newPage();
  page.on("console", (m) => add("console", [m.text()]));
  page.on("pageerror", (e) => add("console", [String(e)]));
  page.on("request", (r) => {
    const url = r.url();
    if (!url.startsWith("data:") && url !== pathToFileURL(path).href) add("request", [url]);
  });
  const looks = [];
  for (const width of WIDTHS) for (const scheme of ["light", "dark"]) looks.push({ width, scheme, media: "screen" });
  looks.push({ width: PAPER, scheme: "dark", media: "print" });
  for (const { width, scheme, media } of looks) {
    const where = media === "print" ? "print" : `${width} ${scheme}`;
    await page.setViewportSize({ width, height: 900 });
    await page.emulateMedia({ colorScheme: scheme, media });
    await page.goto(pathToFileURL(path).href);
    // A stand-alone drawing has its own size; nothing below 9.5 px at that size.
    const isPrint = media === "print";
    add(where, await page.evaluate(measure, { leastContrast: LEAST_CONTRAST, leastText: LEAST_TEXT, isPrint }));
    if (isPage && width === 1280 && scheme === "light") {
      add("structure", await page.evaluate(structure, { characterize }));
      if (characterize) add("units", await unitSwitch(page));
    }
    if (shots && isPage) {
      await page.screenshot({ path: `${shots}/${stem}-${media === "print" ? "print" : `${width}-${scheme}`}.png`, fullPage: true });
    }
  }
  if (shots && isPage) {
    await page.emulateMedia({ media: "print" });
    await page.pdf({ path: `${shots}/${stem}.pdf`, preferCSSPageSize: true, printBackground: true });
  }
  await context.close();
  const bad = found.size > 0;
  console.log(`${bad ? "FAIL" : "ok  "} ${file}`);
  let shown = 0;
  for (const [problem, where] of found) {
    if (shown++ < (expectFailure ? 3 : 40)) console.log(`     ${problem}  [${[...new Set(where)].join(", ")}]`);
  }
  if (bad !== expectFailure) failed++;
}
await browser.close();
if (failed) console.log(`${failed} of ${args.length} files ${expectFailure ? "did not fail" : "failed"}`);
process.exit(failed ? 1 : 0);
