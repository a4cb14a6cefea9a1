// The page as a user sees it, in a real browser, compared with the output of the command.

import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { AxeBuilder } from "@axe-core/playwright";
import { argumentsOf, browser, onset, serve } from "./serve.mjs";

const SHOTS = process.env.ONSET_SCREENSHOTS ?? join(import.meta.dirname, "../../../../target/page-screenshots");
const SIZES = { wide: [1440, 950], tablet: [900, 1100], phone: [390, 844] };
/** Factor on the time limits, which are set for an otherwise idle machine. */
const PATIENCE = Number(process.env.ONSET_PATIENCE ?? 1);

const chrome = await browser();
const options = { skip: chrome === null ? "NOT TESTED: no browser" : false, timeout: 400_000 };
let server;

before(async () => {
  if (chrome) server = await serve();
  mkdirSync(SHOTS, { recursive: true });
});
after(async () => {
  await chrome?.close();
  server?.end();
});

/** Opens a page and records every console message, and every request that leaves the machine. */
/** A question of a kernel method, whose answers are fast. */
const KERNEL = "#set=material.model%3Dblatz-ko&set=discretization.frame%3Deulerian&stretch=1.2,1&axis=stretch-1,0.9,2&axis=stretch-2,0.9,2";

async function open({ hash = KERNEL, size = SIZES.wide, dark = false, shown = token(server.address), beside } = {}) {
  const context = beside?.context() ?? (await chrome.newContext({ viewport: { width: size[0], height: size[1] }, colorScheme: dark ? "dark" : "light" }));
  const page = await context.newPage();
  // Without a graphics card a picture of three dimensions takes long.
  page.setDefaultTimeout(120_000);
  const [messages, asked] = [[], []];
  page.on("console", (message) => messages.push(message.text()));
  page.on("pageerror", (error) => messages.push(String(error)));
  page.on("request", (request) => {
    const url = new URL(request.url());
    if (!["data:", "blob:"].includes(url.protocol) && url.origin !== origin()) messages.push(`a request to ${url.origin}`);
  });
  // The browser's log is complete only at the end.
  page.on("requestfinished", (request) => {
    const told = (headers) => headers["referer"] !== undefined && messages.push(`${request.url()} is told where it was asked from`);
    asked.push(request.allHeaders().then(told, () => {}));
  });
  await page.goto(linked(hash, shown));
  const close = async (allowed = []) => {
    await Promise.race([Promise.all(asked), page.waitForTimeout(2000)]);
    const unexpected = messages.filter((text) => !allowed.some((own) => text.includes(own)));
    await (beside ? page : context).close();
    assert.deepEqual(unexpected, [], "no message in the console, and no request to another server");
  };
  return { page, close };
}

const origin = () => new URL(server.address).origin;
const token = (address) => new URLSearchParams(new URL(address).hash.slice(1)).get("token");
/** Address of a question, with or without a token. */
const linked = (hash, shown) => {
  const parts = [shown ? `token=${shown}` : "", hash.replace(/^#/, "")].filter((part) => part !== "");
  return `${origin()}/${parts.length > 0 ? "#" : ""}${parts.join("&")}`;
};
const finest = (page) => page.waitForFunction(() => document.querySelector("#map svg") && document.getElementById("map-state").textContent === "", null, { timeout: 120_000 });
/** Waits until a picture has been drawn and none has followed for a second: the waves of a state are drawn after its map. */
const last = async (page, name) => {
  await page.waitForFunction((own) => performance.getEntriesByName(`drawn:${own}`).length > 0, name, { timeout: 120_000 });
  for (let before = null; ; ) {
    const now = await page.locator(`#${name}`).innerHTML();
    if (now === before) return now;
    before = now;
    await page.waitForTimeout(1000);
  }
};
const sentence = (page) => page.locator("#sentence").textContent();
const drawn = (page, stretch) => page.waitForFunction((own) => document.getElementById("sentence").dataset.state === own, stretch, { timeout: 60_000 });

/** Question of an address. */
function questionOf(url) {
  const parts = new URLSearchParams(new URL(url).hash.slice(1));
  return { set: parts.getAll("set"), stretch: parts.get("stretch") };
}

/** Clicks the position of a state on the map. */
async function click(page, x, y) {
  const at = await page.evaluate(
    ([x, y]) => {
      const svg = document.querySelector("#map svg");
      const box = svg.getBoundingClientRect();
      const scale = box.width / Number(svg.getAttribute("width"));
      return [box.left + svg.scale("x").apply(x) * scale, box.top + svg.scale("y").apply(y) * scale];
    },
    [x, y],
  );
  await page.mouse.click(at[0], at[1]);
}

/** Formats a number with six digits, as the page does. */
const six = (value) => (value === 0 ? "0" : String(Number(value.toPrecision(6))));
const cell = (page, name) => page.locator("#numbers tr", { has: page.locator("th", { hasText: new RegExp(`^${name}$`) }) }).locator("td").textContent();

test("the first picture is there within two seconds", options, async (own) => {
  const since = Date.now();
  const { page, close } = await open();
  await page.waitForSelector("#map svg");
  await page.waitForSelector("#mode canvas");
  const took = Date.now() - since;
  own.diagnostic(`${took} ms`);
  assert.ok(took < 2000 * PATIENCE, `${took} ms`);
  await finest(page);
  await page.waitForFunction(() => performance.getEntriesByName("drawn:boundary").length > 0, null, { timeout: 60_000 });
  await close();
});

test("three states that are clicked are told as by the command, and drawn at once", options, async (own) => {
  const { page, close } = await open();
  await finest(page);
  for (const [x, y] of [[1.2, 1.0], [1.7, 1.8], [1.05, 1.45]]) {
    await page.evaluate(() => performance.clearMarks());
    await click(page, x, y);
    await page.waitForFunction(() => performance.getEntriesByName("drawn:mode").length > 0 && performance.getEntriesByName("drawn:state").length > 0);
    const question = questionOf(page.url());
    await drawn(page, question.stretch);
    const clicked = question.stretch.split(",").map(Number);
    assert.ok(Math.abs(clicked[0] - x) < 0.01 && Math.abs(clicked[1] - y) < 0.01, question.stretch);
    const state = onset(...argumentsOf(question));
    assert.equal(await sentence(page), state.sentence);
    assert.equal(await cell(page, "verdict"), state.mechanism ? `${state.verdict} (${state.mechanism})` : state.verdict);
    assert.equal(await cell(page, "growth rate"), six(state.discretization.growth_rate));
    assert.equal(await cell(page, "largest frequency"), six(state.discretization.maximum_omega));
    const { critical_time_step: step, critical_time_step_of: whose } = state.discretization;
    assert.equal(await cell(page, "critical time step"), `${six(step)} (${whose})`);
    const stress = await cell(page, "Cauchy stress");
    assert.ok(stress.includes(`s11 ${six(state.material.cauchy[0][0])}`), stress);
    const took = await page.evaluate(() => {
      const at = (name) => performance.getEntriesByName(name).at(-1).startTime;
      return at("drawn:mode") - at("answer:mode");
    });
    own.diagnostic(`from the answer to the moving mode ${took} ms`);
    assert.ok(took < 50 * PATIENCE, `from the answer to the moving mode ${took} ms`);
  }
  await close();
});

test("the mode moves, as far as the slider says, and can be paused", options, async () => {
  const { page, close } = await open();
  await page.waitForSelector("#mode canvas");
  const look = () => page.locator("#mode canvas").evaluate((canvas) => canvas.toDataURL());
  const first = await look();
  await page.waitForTimeout(300);
  assert.notEqual(await look(), first);
  await page.click("#pause");
  await page.waitForTimeout(100);
  const paused = await look();
  await page.waitForTimeout(200);
  assert.equal(await look(), paused);
  await page.locator("#amplitude").fill("0.5");
  await page.waitForTimeout(100);
  assert.notEqual(await look(), paused);
  await close();
});

test("a slider draws anew within 200 ms of a step", options, async (own) => {
  const { page, close } = await open();
  await finest(page);
  const slider = page.locator('[id="field-material.mu-slider"]');
  await slider.focus();
  const times = [];
  for (let n = 0; n < 5; n++) {
    await page.evaluate(() => performance.clearMarks());
    const before = await page.evaluate(() => performance.now());
    await slider.evaluate((own) => {
      own.value = String(Number(own.value) + Number(own.step));
      own.dispatchEvent(new Event("input", { bubbles: true }));
    });
    await page.waitForFunction(() => performance.getEntriesByName("drawn:state").length > 0 && performance.getEntriesByName("drawn:map").length > 0);
    const after = await page.evaluate(() => Math.max(...["drawn:state", "drawn:map"].map((name) => performance.getEntriesByName(name)[0].startTime)));
    times.push(after - before);
  }
  times.sort((a, b) => a - b);
  own.diagnostic(`${times.map(Math.round).join(", ")} ms`);
  assert.ok(times[2] < 200 * PATIENCE, `${times} ms`);
  // The results belong to the last step.
  await finest(page);
  const question = questionOf(page.url());
  assert.ok(question.set.some((own) => own.startsWith("material.mu=")), page.url());
  assert.equal(await sentence(page), onset(...argumentsOf(question)).sentence);
  await close();
});

test("a link reproduces the state, and the back button the one before", options, async () => {
  const { page, close } = await open();
  await finest(page);
  const begun = page.url();
  const first = await sentence(page);
  await click(page, 1.7, 1.3);
  await page.waitForURL((url) => url.href !== begun);
  const question = questionOf(page.url());
  await drawn(page, question.stretch);
  const second = await sentence(page);
  const other = await open({ hash: new URL(page.url()).hash });
  await drawn(other.page, question.stretch);
  assert.equal(await sentence(other.page), second);
  await other.close();
  await page.goBack();
  await page.waitForURL(begun);
  await page.waitForFunction((text) => document.getElementById("sentence").textContent === text, first);
  await page.goForward();
  await page.waitForFunction((text) => document.getElementById("sentence").textContent === text, second);
  await close();
});

test("the token stays out of links, and without it there is no answer", options, async () => {
  const { page, close } = await open();
  await finest(page);
  assert.ok(!page.url().includes("token"), page.url());
  await page.click("#link");
  const link = await page.locator("#export-text").inputValue();
  assert.ok(link.startsWith(origin()) && !link.includes(token(server.address)), link);
  const stretch = "1.3,1.1";
  const hash = new URL(link).hash.replace(/stretch=[^&]*/, `stretch=${stretch}`);
  const told = onset(...argumentsOf(questionOf(linked(hash)))).sentence;
  // In the browser with the token a link is answered, even with the token of another run.
  for (const shown of ["", "0".repeat(32), ""]) {
    const other = await open({ hash, shown, beside: page });
    await drawn(other.page, stretch);
    assert.equal(await sentence(other.page), told);
    assert.ok(!other.page.url().includes("token"), other.page.url());
    await other.close(shown === "" ? [] : ["403"]);
  }
  await close();
  // Another user of the machine has no token, or a wrong one.
  for (const shown of ["", "0".repeat(32)]) {
    const stranger = await open({ hash, shown });
    await stranger.page.waitForSelector("#error:not([hidden])");
    assert.match(await stranger.page.locator("#error").textContent(), /open the address that `onset explore` has printed/);
    assert.equal(await sentence(stranger.page), "");
    await stranger.close(["403"]);
  }
});

test("a wrong formula shows the caret and keeps the last picture", options, async () => {
  const { page, close } = await open();
  await finest(page);
  await page.evaluate(() => performance.clearMarks());
  await page.selectOption('[id="field-material.model"]', "formula");
  const area = page.locator('[id="field-material.energy"]');
  await area.waitFor();
  await page.locator('[id="field-material.mu"]').waitFor();
  await finest(page);
  const picture = await last(page, "dispersion");
  const before = await sentence(page);
  await area.fill("mu/2*(I1 - 3 -* 2)");
  await page.waitForSelector("#error:not([hidden])");
  const told = await page.locator("#error").textContent();
  assert.match(told, /\n +\^/);
  assert.equal(await sentence(page), before);
  assert.equal(await page.locator("#dispersion").innerHTML(), picture);
  await area.fill("mu/2*(I1 - 3 - 2*ln(J)) + lambda/2*(J - 1)^2");
  await page.waitForSelector("#error", { state: "hidden" });
  await close();
});

test("names are text, whatever they look like", options, async () => {
  const hash = `#set=${encodeURIComponent("material.model=<img src=x onerror=alert(1)>")}&stretch=1,1`;
  const { page, close } = await open({ hash });
  page.on("dialog", () => assert.fail("a script ran"));
  await page.waitForSelector("#error:not([hidden])");
  assert.match(await page.locator("#error").textContent(), /<img src=x onerror=alert\(1\)>/);
  assert.equal(await page.locator("#error img, #map img, #form img").count(), 0);
  await close();
});

test("a stranger's study starts no library", options, async () => {
  const { page, close } = await open();
  await finest(page);
  const study = join(mkdtempSync(join(tmpdir(), "onset-page-")), "study.toml");
  writeFileSync(study, '[material]\nmodel = "umat"\nlibrary = "/tmp/stranger.so"\n');
  await page.setInputFiles("#study", study);
  await page.waitForSelector("#error:not([hidden])");
  assert.match(await page.locator("#error").textContent(), /nothing was loaded/);
  await close();
});

test("the keyboard moves the state, and other methods have other keys", options, async () => {
  const { page, close } = await open();
  await finest(page);
  const before = questionOf(page.url()).stretch;
  await page.focus("#map");
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction((own) => document.getElementById("sentence").dataset.state !== own, before);
  assert.equal(await page.locator('[data-key="discretization.quadrature"]').count(), 1);
  await page.selectOption('[id="field-discretization.method"]', "finite-elements");
  await page.waitForSelector('[data-key="discretization.integration"]');
  assert.equal(await page.locator('[data-key="discretization.quadrature"]').count(), 0);
  await finest(page);
  await close();
});

test("the zoo opens with one choice, in one and three dimensions too", options, async () => {
  const { page, close } = await open();
  await finest(page);
  const choices = await page.locator("#zoo option").count();
  assert.ok(choices > 10);
  await page.selectOption("#zoo", { index: 1 });
  await page.waitForSelector("#entry[open]");
  const question = questionOf(page.url());
  await drawn(page, question.stretch);
  assert.equal(await sentence(page), onset(...argumentsOf(question)).sentence);
  await close();

  const space = await open({ hash: `#set=${encodeURIComponent("discretization.method=updated-sph")}&set=${encodeURIComponent("discretization.lattice=simple-cubic")}&stretch=1.1,1,1` });
  await space.page.waitForSelector("#mode canvas:not(.flat)", { timeout: 120_000 });
  await space.page.waitForSelector("#directions canvas", { timeout: 120_000 });
  const sphere = space.page.locator("#directions canvas");
  const look = () => sphere.screenshot().then((bytes) => bytes.toString("base64"));
  await space.page.waitForTimeout(300);
  const first = await look();
  await sphere.focus();
  for (let n = 0; n < 8; n++) await space.page.keyboard.press("ArrowRight");
  await space.page.waitForTimeout(500);
  assert.notEqual(await look(), first);
  await space.page.screenshot({ path: join(SHOTS, "space.png"), fullPage: true });
  // The browser of the tests renders three dimensions without a graphics card and prints a warning.
  await space.close(["GPU stall", "GL Driver", "WebGL"]);

  const chain = await open({ hash: `#set=${encodeURIComponent("discretization.method=updated-sph")}&set=${encodeURIComponent("discretization.lattice=chain")}&stretch=1.1` });
  await finest(chain.page);
  await chain.page.waitForSelector("#mode canvas");
  await chain.close();
});

test("a question can be taken along", options, async () => {
  const { page, close } = await open({ hash: "" });
  await finest(page);
  for (const [form, expected] of [["toml", "[[axes]]"], ["command", "onset state --stretch 2,1 --set material.model=blatz-ko"], ["python", "onset.Method(\"material-points\", grid_functions=\"quadratic-spline\")"]]) {
    await page.click(`button[data-form="${form}"]`);
    await page.waitForFunction((text) => document.getElementById("export-text").value.includes(text), expected);
  }
  for (const form of ["svg", "csv"]) {
    const [download] = await Promise.all([page.waitForEvent("download", { timeout: 120_000 }), page.click(`button[data-form="${form}"]`)]);
    assert.equal(download.suggestedFilename(), `onset-map.${form}`);
  }
  await close();
});

test("a stored map is shown, and a state in it is asked", options, async () => {
  const folder = mkdtempSync(join(tmpdir(), "onset-page-"));
  const study = join(folder, "study.toml");
  const axis = (name) => `[[axes]]\nquantity = "${name}"\nrange = [0.9, 1.3]\nstates = 16\n`;
  writeFileSync(study, `title = "A stored map"\n[discretization]\nmethod = "updated-sph"\n${axis("stretch-1")}${axis("stretch-2")}[map]\ntile = 8\n`);
  onset("map", study, "--out", join(folder, "map.zarr"));
  const own = await serve(join(folder, "map.zarr"));
  const context = await chrome.newContext();
  const page = await context.newPage();
  await page.goto(own.address);
  await page.waitForSelector("#map svg");
  assert.match(await page.locator("#map-note").textContent(), /A stored map/);
  await page.waitForFunction(() => document.getElementById("sentence").textContent !== "");
  await click(page, 1.2, 1.0);
  await page.waitForFunction(() => Math.abs(parseFloat(document.getElementById("sentence").dataset.state) - 1.2) < 0.01);
  assert.match(await page.locator("#map-note").textContent(), /A stored map/);
  await context.close();
  own.end();
});

test("axe-core finds nothing, and the pictures of three sizes are taken", options, async () => {
  for (const dark of [false, true]) {
    for (const [name, size] of Object.entries(SIZES)) {
      // Smooth boundaries must be traced quickly.
      const hash = "#set=material.model%3Dblatz-ko&set=discretization.method%3Dtotal-lagrangian-sph&set=discretization.penalty%3D0.3&stretch=1.2,1";
      const { page, close } = await open({ size, dark, hash });
      await finest(page);
      await page.waitForFunction(() => performance.getEntriesByName("drawn:boundary").length > 0, null, { timeout: 60_000 });
      await page.screenshot({ path: join(SHOTS, `${name}${dark ? "-dark" : ""}.png`), fullPage: true });
      const across = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(across <= 0, `${name}: the page is ${across} px wider than the window`);
      for (const details of await page.locator("details:not([hidden]) > summary").all()) await details.click();
      const { violations } = await new AxeBuilder({ page }).analyze();
      assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.target).join(", ")}`), [], `${name} ${dark}`);
      await close();
    }
  }
});

test("labels of the dispersion do not overlap", options, async () => {
  const { page, close } = await open({ hash: "#set=material.model%3Dblatz-ko&set=discretization.frame%3Deulerian&stretch=1.2,1" });
  await last(page, "dispersion");
  const overlaps = await page.evaluate(() => {
    const boxes = [...document.querySelectorAll("#dispersion svg text")].filter((own) => own.textContent !== "").map((own) => [own.textContent, own.getBoundingClientRect()]);
    const meet = ([, a], [, b]) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    return boxes.flatMap((one, n) => boxes.slice(0, n).filter((other) => meet(one, other)).map((other) => `${one[0]} and ${other[0]}`));
  });
  assert.deepEqual(overlaps, []);
  await close();
});

test("the legend names boundaries only if the window has some", options, async () => {
  const { page, close } = await open({ hash: "#set=material.model%3Dneo-hooke&set=discretization.method%3Dtotal-lagrangian-sph&set=discretization.penalty%3D0.3&stretch=1.1,1" });
  await page.waitForFunction(() => document.getElementById("map").dataset.curves !== undefined, null, { timeout: 120_000 });
  const [names, curves] = [await page.locator("#legend li").allTextContents(), await page.locator("#map").getAttribute("data-curves")];
  assert.equal(names.some((name) => name.startsWith("boundary of")), Number(curves) > 0, names.join());
  await close();
});

test("the page opens on a map with physical and numerical parts, and no word of a table breaks", options, async () => {
  const { page, close } = await open({ hash: "" });
  await finest(page);
  const names = (await page.locator("#legend li").allTextContents()).join();
  for (const verdict of ["physical", "numerical", "stable"]) assert.ok(names.includes(verdict), names);
  const broken = await page.evaluate(() => {
    const lines = (word) => {
      const range = document.createRange();
      range.setStart(word.node, word.from);
      range.setEnd(word.node, word.to);
      return new Set([...range.getClientRects()].map((own) => Math.round(own.top))).size;
    };
    const heads = [...document.querySelectorAll("#numbers th")];
    const words = heads.flatMap((head) => [...head.textContent.matchAll(/\S+/g)].map((own) => ({ node: head.firstChild, from: own.index, to: own.index + own[0].length, text: own[0] })));
    return words.filter((word) => lines(word) > 1).map((word) => word.text);
  });
  assert.deepEqual(broken, []);
  await close();
});
