// The page: files, tabs and the motion. `viewer.js` has the class `Viewer` and its helpers, `examples.js` the list `EXAMPLES`.
"use strict";

const element = (id) => document.getElementById(id);
// The time steps: of most robots, and of those that take long.
const STEP = 0.001, LONG_STEP = 0.002, LANGUAGES_OF_MANY_STATES = ["cuda", "wgsl"];

// modyn in a worker. A worker that has stopped is replaced by one that has the same files and robot.
class Modyn {
  constructor(module) {
    Object.assign(this, { module, files: [], robot: null, pending: new Map(), next: 0 });
    this.start();
  }

  start() {
    this.worker = new Worker("worker.js");
    this.worker.postMessage({ module: this.module });
    this.worker.onmessage = ({ data: { id, answer, fault } }) => {
      const { resolve, reject } = this.pending.get(id) || {};
      this.pending.delete(id);
      if (fault === undefined) return resolve && resolve(answer);
      this.restart();
      if (reject) reject(new Error(`modyn stopped: ${fault}`));
    };
    this.worker.onerror = (event) => { event.preventDefault(); this.restart(); };
  }

  // Ends what is being computed.
  restart() {
    this.worker.terminate();
    const abandoned = [...this.pending.values()];
    this.pending.clear();
    abandoned.forEach(({ reject }) => reject(new Error("stopped")));
    this.start();
    this.files.forEach(([file, bytes]) => this.send({ do: "put", file }, bytes).catch(() => {}));
    if (this.robot) this.send(this.robot).catch(() => {});
  }

  send(request, bytes) {
    const id = this.next++;
    this.worker.postMessage({ id, request, bytes });
    return new Promise((resolve, reject) => this.pending.set(id, { resolve, reject }));
  }

  async ask(request, bytes) {
    const answer = await this.send(request, bytes);
    if (answer.error) throw new Error(answer.error);
    return answer;
  }

  // Reads the main file of some files, [path, bytes].
  async read(files, main, options) {
    Object.assign(this, { files, robot: null });
    if (this.pending.size) this.restart();
    else {
      this.send({ do: "clear" });
      files.forEach(([file, bytes]) => this.send({ do: "put", file }, bytes).catch(() => {}));
    }
    const request = { do: "read", file: main, options };
    const answer = await this.ask(request);
    this.robot = request;
    return answer;
  }
}

const page = { files: [], main: "", reading: 0, robot: null, compiler: null, mover: null, viewer: null, motion: null, selected: new Set(["forward_dynamics"]), generated: [] };

function say(text, isFault = false) {
  element("status").textContent = text;
  element("status").classList.toggle("fault", isFault);
}

const fault = (error) => { if (error.message !== "stopped") say(error.message, true); };

// --- Tabs

const TABS = { description: "Description", check: "Check", modules: "Modules", operations: "Operations", code: "Code" };

function show(tab) {
  document.querySelectorAll(".tab").forEach((one) => one.classList.toggle("shown", one.id === tab));
  [...element("tabs").children].forEach((button) => button.setAttribute("aria-selected", button.dataset.tab === tab));
  if (page.tab !== tab) { page.tab = tab; fill(); }
}

// Fills the tab that is shown with what it lacks.
function fill() {
  const { robot } = page;
  if (!robot) return;
  if (page.tab === "modules" && !robot.modules) showModules(robot);
  if (page.tab === "operations") countOperations(robot);
  if (page.tab === "code") generate(robot);
}

// The text of a terminal, whose colours are escape sequences, as elements.
function colored(text) {
  let classes = [];
  return text.split(/\x1b\[([\d;]*)m/).map((part, i) => {
    if (i % 2 === 0) return make("span", { className: classes.join(" ") }, part);
    for (const code of part.split(";")) classes = Number(code) === 0 ? [] : [...classes, `a${code}`];
    return "";
  });
}

// --- Files

const nameOf = (path) => path.split("/").pop();

// The descriptions among some files, those that no other one names first.
function descriptions(files) {
  const candidates = files.filter(([path]) => /\.(urdf|xacro|sdf|world|mjcf|xml)$/i.test(path) && nameOf(path) !== "package.xml");
  const list = (candidates.length ? candidates : files).map(([path, bytes]) => ({ path, text: candidates.length ? new TextDecoder().decode(bytes) : "" }));
  const isNamed = ({ path }) => list.some((other) => other.path !== path && other.text.includes(nameOf(path)));
  return [...list.filter((one) => !isNamed(one)), ...list.filter(isNamed)].map(({ path }) => path);
}

async function take(files, options = {}) {
  if (!files.length) return;
  page.files = files;
  const list = descriptions(files);
  element("main").replaceChildren(...list.map((path) => make("option", { value: path }, path)));
  element("base").value = options.base || "";
  element("contacts").value = options.contacts || "";
  await choose(list[0]);
}

async function choose(main) {
  page.main = main;
  element("main").value = main;
  const [, bytes] = page.files.find(([path]) => path === main);
  element("text").value = new TextDecoder().decode(bytes);
  await readRobot();
}

async function filesOf(list) {
  return Promise.all([...list].map(async (file) => [file.webkitRelativePath || file.name, new Uint8Array(await file.arrayBuffer())]));
}

// The files of a drop, with those in folders.
async function dropped(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry && item.webkitGetAsEntry()).filter((entry) => entry);
  if (!entries.length) return filesOf(transfer.files);
  const files = [], open = async (entry) => {
    if (entry.isFile) {
      const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
      files.push([entry.fullPath.replace(/^\//, ""), new Uint8Array(await file.arrayBuffer())]);
      return;
    }
    const reader = entry.createReader();
    for (;;) {
      const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
      if (!some.length) return;
      for (const one of some) await open(one);
    }
  };
  for (const entry of entries) await open(entry);
  return files;
}

// --- Reading

async function readRobot() {
  const reading = ++page.reading, start = performance.now();
  const options = { base: element("base").value };
  if (element("contacts").value.trim()) options.contacts = element("contacts").value;
  stopMotion();
  element("clock").textContent = "";
  say(`Reading ${page.main} …`);
  try {
    const answer = await page.compiler.read(page.files, page.main, options);
    if (reading !== page.reading) return;
    showReport(answer);
    if (!answer.robot) {
      page.robot = null;
      element("view").classList.add("stale");
      say(`${page.main} is refused`, true);
      return;
    }
    const { robot } = answer;
    page.robot = robot;
    if (robot.chosen_contacts) element("contacts").value = robot.chosen_contacts;
    Object.assign(robot, { costs: new Map(), reading });
    element("ground").checked = robot.contacts > 0;
    element("ground").disabled = !robot.contacts;
    showOperations(robot);
    const scene = await page.compiler.ask({ do: "scene" });
    if (reading !== page.reading) return;
    await Promise.all([page.mover.read(page.files, page.main, options), showScene(scene)]);
    const notes = robot.notes.length ? ` ${robot.notes.length} shapes are not drawn: ${robot.notes[0]}.` : "";
    say(`${robot.name}: ${robot.format}, moving links: ${robot.links}, degrees of freedom: ${robot.nv}, ${Number(robot.mass.toPrecision(4))} kg; read in ${Math.round(performance.now() - start)} ms.${notes}`);
    fill();
  } catch (error) {
    if (reading === page.reading) {
      page.robot = null;
      element("report").textContent = error.message;
      fault(error);
    }
  }
}

function showReport({ report, usable, diagnostics }) {
  element("report").replaceChildren(...colored(report));
  const lines = element("text").value.split("\n").length, marks = new Map();
  for (const { file, line, is_error, code } of diagnostics) {
    if (line && (!file || file === page.main) && !(marks.get(line) || {}).is_error) marks.set(line, { is_error, code });
  }
  element("gutter").replaceChildren(...Array.from({ length: Math.min(lines, 100000) }, (_, i) => {
    const mark = marks.get(i + 1);
    return mark ? make("span", { className: mark.is_error ? "error" : "warning", title: mark.code }, `${i + 1}\n`) : `${i + 1}\n`;
  }));
  [...element("tabs").children].find(({ dataset }) => dataset.tab === "check").textContent = diagnostics.length ? `Check (${diagnostics.length})` : "Check";
  if (!usable) show("check");
}

async function showScene(scene) {
  const host = element("view");
  try {
    if (page.viewer) page.viewer.load(scene); else page.viewer = new Viewer(host, scene);
    host.classList.remove("stale");
    const { rest } = page.robot, shown = instance();
    if (rest && shown) { shown.rest = rest; page.viewer.draw(); }
    document.title = `${page.robot.name} – modyn playground`;
  } catch (error) {
    host.replaceChildren(make("p", { className: "failure" }, `The robot cannot be drawn: ${error.message}.`));
  }
}

// --- Modules, operations, code

async function showModules(robot) {
  robot.modules = true;
  try {
    const { svg } = await page.compiler.ask({ do: "modules" });
    const address = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
    element("modules").replaceChildren(make("img", { src: address, alt: `The kinematic modules of ${robot.name}, and the sparsity of its mass matrix`, onload: () => URL.revokeObjectURL(address) }));
  } catch (error) {
    element("modules").textContent = error.message;
  }
}

const COUNTS = { multiplications: "mul", additions: "add", divisions: "div", sin_cos: "sin/cos", total: "in all" };

function showOperations(robot) {
  element("modules").replaceChildren();
  element("generated").textContent = "";
  const body = make("tbody");
  robot.rows = new Map();
  for (const { name, docs, default: isDefault } of robot.functions) {
    const box = make("input", { type: "checkbox", checked: page.selected.has(name), onchange: () => {
      if (box.checked) page.selected.add(name); else page.selected.delete(name);
      if (box.checked) count(robot, name).catch(fault);
    } });
    const row = make("tr", { hidden: !isDefault && !page.selected.has(name) }, make("td", { title: docs }, make("label", {}, box, ` ${name}`)), ...Object.keys(COUNTS).map(() => make("td")));
    robot.rows.set(name, row);
    body.append(row);
  }
  const more = make("button", { type: "button", onclick: () => {
    robot.rows.forEach((row) => { row.hidden = false; });
    more.remove();
    countOperations(robot);
  } }, "All functions");
  element("operations").replaceChildren(
    make("p", {}, "The operations of one call of each function. Those with a mark are generated under “Code”."),
    make("table", {}, make("thead", {}, make("tr", {}, make("th", {}, "function"), ...Object.values(COUNTS).map((title) => make("th", {}, title)))), body), more);
}

async function count(robot, name) {
  if (robot.costs.has(name)) return;
  robot.costs.set(name, null);
  const cells = [...robot.rows.get(name).children].slice(1);
  try {
    const cost = await page.compiler.ask({ do: "cost", function: name });
    robot.costs.set(name, cost);
    Object.keys(COUNTS).forEach((key, i) => { cells[i].textContent = cost[key].toLocaleString("en"); });
  } catch (error) {
    if (error.message === "stopped") { robot.costs.delete(name); throw error; }
    cells.slice(1).forEach((cell) => cell.remove());
    Object.assign(cells[0], { colSpan: 5, className: "why", textContent: error.message });
  }
}

// Counts the operations of the functions that are listed, one after the other.
async function countOperations(robot) {
  if (robot.counting) return;
  robot.counting = true;
  try {
    for (const [name, row] of robot.rows) {
      if (robot !== page.robot) return;
      if (!row.hidden) await count(robot, name);
    }
  } catch (error) { fault(error); } finally { robot.counting = false; }
}

async function generate(robot) {
  const target = element("language").value, many = LANGUAGES_OF_MANY_STATES.includes(target);
  const names = [...page.selected].filter((name) => robot.rows.has(name));
  element("generated").textContent = "Generating …";
  element("size").textContent = "";
  element("file").replaceChildren();
  try {
    const start = performance.now();
    const { files, report } = await page.compiler.ask({ do: "text", target, functions: names.join(", ") });
    if (robot !== page.robot || target !== element("language").value) return;
    if (!files) { element("generated").replaceChildren(...colored(report)); return; }
    page.generated = files;
    page.took = `${many ? "one thread for each state; " : ""}${Math.round(performance.now() - start)} ms`;
    element("file").replaceChildren(...files.map(({ name }) => make("option", {}, name)));
    showFile(0);
  } catch (error) {
    element("generated").textContent = error.message;
    fault(error);
  }
}

function showFile(index) {
  const { text } = page.generated[index];
  element("generated").textContent = text;
  element("size").textContent = `${text.split("\n").length - 1} lines, ${Math.ceil(text.length / 1000)} kB; ${page.took}`;
}

// --- Motion

function stopMotion() {
  Object.assign(page, { motion: null, paused: false });
  element("go").textContent = "Let go";
}

const instance = () => page.viewer && page.viewer.instances.find((one) => one.robot);

async function startMotion() {
  const shown = instance();
  if (!page.robot || !shown) return;
  const motion = { shown };
  page.motion = motion;
  element("go").textContent = "Pause";
  try {
    if (!page.paused) {
      await page.mover.ask({ do: "start", q: page.viewer.stateOf(shown, 0), limits: element("limits").checked, hold: element("hold").checked,
        friction: element("ground").checked ? 0.8 : null });
    }
    page.paused = false;
    let last = performance.now(), cost = 0.0005;
    while (page.motion === motion) {
      const start = performance.now(), elapsed = (start - last) / 1000, wanted = Math.min(elapsed, 0.1);
      last = start;
      const dt = cost > 0.6 * STEP ? LONG_STEP : STEP;
      // No more steps than a picture's time allows: a large robot moves slowly rather than by jumps.
      const steps = Math.max(1, Math.min(Math.round(wanted / dt), Math.floor(0.03 / cost)));
      const { q, time, forces } = await page.mover.ask({ do: "step", dt, count: steps });
      if (page.motion !== motion) return;
      cost = 0.8 * cost + 0.2 * (performance.now() - start) / 1000 / steps;
      page.viewer.setState(shown, q, forces);
      const rate = elapsed > 0.002 ? steps * dt / elapsed : 1;
      element("clock").textContent = `${time.toFixed(2)} s${rate < 0.9 ? ` (${rate.toFixed(2)} of real time)` : ""}`;
      await new Promise((resolve) => requestAnimationFrame(resolve));
    }
  } catch (error) {
    if (page.motion === motion) stopMotion();
    fault(error);
  }
}

function resetMotion() {
  stopMotion();
  element("clock").textContent = "";
  if (instance()) page.viewer.setState(instance(), null);
}

function pose() {
  resetMotion();
  const shown = instance();
  if (!shown) return;
  const q = [...page.viewer.stateOf(shown, 0)], free = shown.robot.bodies.filter(({ joint }) => joint.type === "floating");
  const isFree = (label) => free.some(({ joint }) => label.startsWith(`${joint.name} `));
  page.viewer.entries(shown.robot).filter(({ label }) => !isFree(label)).forEach(({ low, high, set }) => {
    const [a, b] = [Math.max(low, -Math.PI), Math.min(high, Math.PI)];
    set(q, a + Math.random() * (b - a));
  });
  page.viewer.setState(shown, q);
}

// --- The beginning

async function begin() {
  element("tabs").append(...Object.entries(TABS).map(([tab, title]) => {
    const button = make("button", { type: "button", onclick: () => show(tab) }, title);
    button.dataset.tab = tab;
    return button;
  }));
  const response = await fetch("modyn.wasm");
  if (!response.ok) throw new Error(`modyn.wasm cannot be loaded: ${response.status}`);
  const module = await WebAssembly.compile(await response.arrayBuffer());
  Object.assign(page, { compiler: new Modyn(module), mover: new Modyn(module) });
  const example = element("example");
  example.append(make("option", { value: "" }, "…"), ...EXAMPLES.map(({ file }) => make("option", { value: file }, file)));
  const open = async (name) => {
    const found = EXAMPLES.find(({ file }) => file === name);
    if (!found) return;
    const text = await fetch(`robots/${name}`);
    if (!text.ok) throw new Error(`robots/${name} cannot be loaded: ${text.status}`);
    await take([[name, new Uint8Array(await text.arrayBuffer())]], found);
  };
  example.addEventListener("change", () => open(example.value).catch(fault));
  const given = async (files) => { example.value = ""; await take(await files); };
  for (const id of ["files", "folder"]) {
    element(id).addEventListener("change", (event) => given(filesOf(event.target.files)).catch(fault));
  }
  element("main").addEventListener("change", () => choose(element("main").value));
  for (const id of ["base", "contacts"]) {
    element(id).addEventListener("change", () => {
      // Contacts that were chosen for a floating robot do not belong to a fixed one.
      if (id === "base") element("contacts").value = "";
      readRobot();
    });
  }
  const text = element("text");
  let wait = 0;
  text.addEventListener("input", () => {
    clearTimeout(wait);
    wait = setTimeout(() => {
      const file = page.files.find(([path]) => path === page.main);
      if (file) { file[1] = new TextEncoder().encode(text.value); readRobot(); }
    }, 400);
  });
  text.addEventListener("scroll", () => { element("gutter").scrollTop = text.scrollTop; });
  element("language").addEventListener("change", fill);
  element("file").addEventListener("change", (event) => showFile(event.target.selectedIndex));
  element("save").addEventListener("click", () => {
    const file = page.generated[element("file").selectedIndex];
    if (file) download(new Blob([file.text], { type: "text/plain" }), nameOf(file.name));
  });
  element("go").addEventListener("click", () => {
    if (page.motion) { stopMotion(); page.paused = true; } else startMotion();
  });
  element("reset").addEventListener("click", resetMotion);
  element("random").addEventListener("click", pose);
  for (const id of ["ground", "limits", "hold"]) element(id).addEventListener("change", () => { const isMoving = page.motion; stopMotion(); if (isMoving) startMotion(); });
  const cover = element("drop");
  addEventListener("dragover", (event) => { event.preventDefault(); cover.classList.add("shown"); });
  addEventListener("dragleave", (event) => { if (!event.relatedTarget) cover.classList.remove("shown"); });
  addEventListener("drop", (event) => {
    event.preventDefault();
    cover.classList.remove("shown");
    given(dropped(event.dataTransfer)).catch(fault);
  });
  show("description");
  example.value = EXAMPLES[0].file;
  await open(EXAMPLES[0].file);
}

addEventListener("error", ({ message }) => say(message, true));
addEventListener("unhandledrejection", ({ reason }) => fault(reason));
begin().catch(fault);
