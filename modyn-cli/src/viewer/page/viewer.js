// The view of robots and their motions, with its controls. The page's data is an object: title, robots, meshes, motions
// { name, robot, times, q, forces } and figures { name, edges, times, points }.

const FIELD_OF_VIEW = 30 * Math.PI / 180, GRAVITY = 9.81;
const HUES = [[1, 1, 1], [1, 0.78, 0.55], [0.62, 0.85, 1], [0.72, 0.95, 0.7], [0.95, 0.7, 0.9], [0.95, 0.92, 0.6]];

// An element with properties and children; a property that starts with `on` is a listener.
function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

// The look of what is drawn over the robot.
const ON_TOP = { isOverlay: true, flatness: 0.65 };

// A number with these decimals, without a sign before zero.
const rounded = (x, decimals) => x.toFixed(decimals).replace(/^-(?=[0.]*$)/, "");

class Viewer {
  // `host` is the element that has the view and its controls.
  constructor(host, data) {
    this.canvas = make("canvas", { ariaLabel: "The robot" });
    this.labels = make("div", { className: "labels" });
    this.heading = make("h1");
    this.panel = make("aside");
    this.clock = make("output");
    this.playButton = make("button", { type: "button", title: "Space", onclick: () => this.play(!this.playing) });
    this.slider = make("input", { type: "range", min: 0, max: 1, step: "any", ariaLabel: "Time",
      oninput: () => { this.play(false); this.seek(this.start + Number(this.slider.value) * (this.end - this.start)); } });
    this.speed = make("select", { ariaLabel: "Speed" }, ...[0.1, 0.25, 0.5, 1, 2, 5].map((x) => make("option", { value: x, selected: x === 1 }, `${x}\u00d7`)));
    this.timeline = make("form", { className: "timeline", onsubmit: (event) => event.preventDefault() },
      this.playButton, this.slider, this.clock, this.speed);
    this.toggle = make("button", { type: "button", className: "toggle", title: "Controls", onclick: () => { host.classList.toggle("plain"); this.draw(); } }, "\u2630");
    host.classList.add("viewer");
    host.append(this.canvas, this.labels, this.heading, this.panel, this.timeline, this.toggle);
    this.host = host;
    this.show = { shapes: true, inertia: false, frames: false, center: false, forces: true, shadows: true, ground: true, grid: true, apart: true, follow: false };
    this.renderer = new Renderer(this.canvas);
    this.markers = this.makeMarkers();
    this.listen();
    this.load(data);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  makeMarkers() {
    const white = [1, 1, 1, 1], done = (geometry) => geometry.colored(white).finish();
    return { rod: done(cylinder(1, 1, 0)), tip: done(cone(1, 1)), ball: done(ellipsoid([1, 1, 1])), capsule: done(capsule(1, 0)),
      column: done(cylinder(1, 1, 0.02)) };
  }

  // Shows other data in place of the present.
  load(data) {
    this.data = data;
    const meshes = data.meshes.map(decodedMesh);
    this.robots = data.robots.map((robot) => new Robot(robot, meshes));
    this.instances = data.motions.map((motion) => ({ ...motion, robot: this.robots[motion.robot] }));
    const moved = new Set(this.instances.map((instance) => instance.robot));
    for (const robot of this.robots.filter((robot) => !moved.has(robot))) {
      this.instances.push({ name: robot.name, robot, times: [], q: [], rest: this.onGround(robot) });
    }
    data.figures.forEach((figure) => this.instances.push({ ...figure, figure }));
    this.instances.forEach((instance) => { instance.visible = true; instance.state = null; });
    const times = this.instances.flatMap((instance) => instance.times.length ? [instance.times[0], instance.times[instance.times.length - 1]] : []);
    this.start = times.length ? Math.min(...times) : 0;
    this.end = times.length ? Math.max(...times) : 0;
    this.now = this.start;
    this.show.forces = this.instances.some((instance) => instance.forces);
    this.selected = this.instances.find((instance) => instance.robot);
    this.measure();
    this.heading.textContent = data.title;
    document.title = data.title;
    this.host.classList.toggle("still", !(this.end > this.start));
    this.resetView();
    this.fillPanel();
    this.draw();
  }

  // The neutral coordinates, with a floating robot standing on the ground.
  onGround(robot) {
    const q = [...robot.neutral], base = robot.bodies[0];
    if (base && base.joint.type === "floating" && q[base.joint.q + 2] === 0) q[base.joint.q + 2] -= robot.bounds(q)[0][2];
    return q;
  }

  // The extent of the motions, the ground's height, and the places of the instances.
  measure() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const see = (point) => point.forEach((x, k) => { low[k] = Math.min(low[k], x); high[k] = Math.max(high[k], x); });
    let largest = 0, hangs = false, width = 0;
    for (const instance of this.instances) {
      if (instance.figure) {
        const { points } = instance.figure;
        points.forEach((frame) => { for (let i = 0; i + 2 < frame.length; i += 3) if (frame[i] !== null) see(frame.slice(i, i + 3)); });
        instance.size = Math.max(norm(subtract(high, low)), 1e-6);
        instance.radius = this.thickness(instance.figure);
        largest = Math.max(largest, instance.size);
        continue;
      }
      const { robot, q } = instance, step = Math.max(1, Math.floor(q.length / 60));
      const states = q.length ? q.filter((_, i) => i % step === 0 || i === q.length - 1) : [instance.rest];
      states.forEach((state) => robot.bounds(state).forEach(see));
      const [a, b] = robot.bounds(states[0]);
      width = Math.max(width, b[1] - a[1]);
      largest = Math.max(largest, norm(subtract(b, a)), robot.size);
      hangs ||= robot.bounds(robot.neutral)[0][2] < -0.1 * robot.size;
    }
    for (let k = 0; k < 3; k++) if (!(low[k] <= high[k])) { low[k] = -0.5; high[k] = 0.5; }
    const whole = norm(subtract(high, low));
    this.size = Math.max(largest, 1e-6);
    this.ground = this.data.ground ?? (low[2] < -0.02 * this.size ? low[2] : 0);
    const isFixed = this.robots.some((robot) => robot.bodies[0] && !["floating", "planar"].includes(robot.bodies[0].joint.type));
    this.column = isFixed && !hangs && this.ground < 0 ? this.ground : null;
    this.spacing = 1.3 * Math.max(width, 0.35 * this.size);
    this.isFar = whole > 3 * this.size;
    this.middle = scale(add(low, high), 0.5);
    this.whole = whole;
    const rough = this.size / 12, power = 10 ** Math.floor(Math.log10(rough));
    this.square = power * [1, 2, 5, 10].find((x) => x * power >= rough);
  }

  // The radius of a figure's lines: a part of their mean length at the start.
  thickness({ edges, points }) {
    const frame = points[0] || [], at = (i) => frame.slice(3 * i, 3 * i + 3);
    const lengths = edges.map(([a, b]) => [at(a), at(b)]).filter((ends) => !ends.flat().includes(null)).map(([a, b]) => norm(subtract(a, b)));
    return lengths.length ? 0.08 * lengths.reduce((a, b) => a + b, 0) / lengths.length : 0.01;
  }

  resetView() {
    const count = this.show.apart ? this.instances.filter((instance) => instance.visible).length : 1;
    this.show.follow = this.isFar;
    const spread = (count - 1) * this.spacing, extent = this.isFar ? this.size : Math.max(this.whole, this.size);
    const size = Math.hypot(extent, spread);
    this.camera = { yaw: -0.75, pitch: 0.24, distance: 0.56 * size / Math.tan(FIELD_OF_VIEW / 2), target: this.isFar ? null : [...this.middle] };
    this.anchor = this.meanAt(this.start);
    if (this.isFar) this.camera.target = [...this.anchor];
    this.reset = { size: Math.max(size, 1e-6) };
    if (this.checks && this.checks.follow) this.checks.follow.checked = this.show.follow;
  }

  // The coordinates of an instance at a time, or those that were set by hand.
  stateOf(instance, time) {
    if (instance.state) return instance.state;
    const { times, q, robot, rest } = instance;
    if (!times.length) return rest;
    const [below, above, part] = this.bracket(times, time);
    return robot.between(q[below], q[above], part);
  }

  // The indices of the samples around a time, and the part of the way between them.
  bracket(times, time) {
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = low + high >> 1;
      if (times[middle] <= time) low = middle; else high = middle;
    }
    const span = times[high] - times[low];
    return [low, high, span > 0 ? Math.min(Math.max((time - times[low]) / span, 0), 1) : 0];
  }

  pointsOf(figure, time) {
    const { times, points } = figure;
    if (!times.length) return [];
    const [below, above, part] = this.bracket(times, time), list = [];
    for (let i = 0; i + 2 < points[above].length; i += 3) {
      const [a, b] = [points[below], points[above]].map((frame) => frame.slice(i, i + 3));
      list.push(a.includes(null) || b.includes(null) ? null : mix(a, b, part));
    }
    return list;
  }

  shownInstances() {
    const shown = this.instances.filter((instance) => instance.visible);
    const apart = this.show.apart && shown.length > 1;
    return shown.map((instance, i) => ({ instance, shift: [0, apart ? (i - (shown.length - 1) / 2) * this.spacing : 0, 0],
      hue: HUES[apart ? 0 : this.instances.indexOf(instance) % HUES.length] }));
  }

  // The mean of the places of all bodies.
  meanAt(time) {
    let sum = [0, 0, 0], count = 0;
    for (const { instance } of this.shownInstances()) {
      const points = instance.figure ? this.pointsOf(instance.figure, time).filter((point) => point)
        : instance.robot.poses(this.stateOf(instance, time)).map(origin);
      points.forEach((point) => { sum = add(sum, point); count++; });
    }
    return count ? scale(sum, 1 / count) : [0, 0, 0];
  }

  // The items that are drawn: bodies, and what shows their properties.
  items() {
    const items = [], { show, markers } = this;
    const arrow = (from, to, radius, color, more) => {
      const along = subtract(to, from), length = norm(along);
      if (!(length > 1e-9)) return;
      const [x, y, z] = axesAlong(along), head = Math.min(4.5 * radius, 0.6 * length);
      const part = (geometry, r, a, b) => items.push({ geometry, tint: color, ...more,
        matrix: fromAxes(scale(x, r), scale(y, r), scale(z, b - a), add(from, scale(z, (a + b) / 2))) });
      part(markers.rod, radius, 0, length - head);
      part(markers.tip, 2.4 * radius, length - head, length);
    };
    for (const { instance, shift, hue } of this.shownInstances()) {
      const moved = translation(shift);
      if (instance.figure) {
        const points = this.pointsOf(instance.figure, this.now), { radius } = instance;
        for (const [a, b] of instance.figure.edges) {
          if (!points[a] || !points[b]) continue;
          const [from, to] = [points[a], points[b]].map((point) => add(point, shift)), along = subtract(to, from);
          const axes = axesAlong(along).map((axis) => scale(axis, radius));
          items.push({ geometry: markers.capsule, matrix: fromAxes(...axes, scale(add(from, to), 0.5)), stretch: norm(along) / 2 / radius,
            tint: [0.75 * hue[0], 0.78 * hue[1], 0.82 * hue[2], 1] });
        }
        continue;
      }
      const { robot } = instance, q = this.stateOf(instance, this.now);
      const poses = robot.poses(q).map((pose) => multiply(moved, pose));
      const at = (body, matrix = identity()) => body < 0 ? multiply(moved, matrix) : multiply(poses[body], matrix);
      const isGlass = show.inertia || show.frames || show.center;
      if (show.shapes) robot.geometries.forEach((geometry, body) => items.push({ geometry, matrix: at(body), tint: [...hue, isGlass ? 0.55 : 1] }));
      if (this.column !== null) {
        const radius = 0.045 * robot.size;
        items.push({ geometry: markers.column, matrix: multiply(moved, fromAxes([radius, 0, 0], [0, radius, 0], [0, 0, -this.column], [0, 0, this.column / 2])), tint: [0.3, 0.32, 0.35, 1] });
      }
      if (show.inertia) robot.bodies.forEach((body, i) => {
        if (!(body.mass > 0)) return;
        // The solid ellipsoid with the body's mass and inertia.
        const { axes, half, center } = inertiaBox(body), radii = half.map((x) => Math.max(x * Math.sqrt(5 / 3), 1e-4 * robot.size));
        items.push({ geometry: markers.ball, matrix: at(i, fromAxes(...axes.map((axis, k) => scale(axis, radii[k])), center)), tint: [0.95, 0.55, 0.2, show.shapes ? 0.5 : 1] });
      });
      if (show.frames) robot.frames.forEach((frame) => {
        const place = at(frame.body, frame.matrix), length = 0.07 * robot.size, from = origin(place);
        [[0.9, 0.2, 0.2, 1], [0.2, 0.7, 0.25, 1], [0.2, 0.4, 0.95, 1]].forEach((color, k) => {
          const axis = [0, 0, 0];
          axis[k] = length;
          arrow(from, add(from, rotate(place, axis)), 0.03 * length, color, ON_TOP);
        });
      });
      if (show.center) {
        const center = robot.centerOfMass(poses);
        const ball = (point, radius, color, more) => items.push({ geometry: markers.ball, matrix: multiply(translation(point), scaling([radius, radius, radius])), tint: color, ...more });
        if (center) {
          ball(center, 0.018 * robot.size, [0.95, 0.75, 0.1, 1], ON_TOP);
          if (show.ground) arrow(center, [center[0], center[1], this.ground], 0.003 * robot.size, [0.95, 0.75, 0.1, 1], ON_TOP);
        }
      }
      const forces = show.forces && this.forcesOf(instance);
      if (forces) for (let i = 0; i < forces.length; i += 6) {
        const from = transformPoint(moved, forces.slice(i, i + 3)), force = forces.slice(i + 3, i + 6);
        if (!(norm(force) > 0)) continue;
        const radius = 0.012 * robot.size;
        items.push({ geometry: markers.ball, matrix: multiply(translation(from), scaling([radius, radius, radius])), tint: [0.92, 0.28, 0.16, 1], ...ON_TOP });
        // A robot's weight is an arrow of half its size; impacts are no longer than the robot.
        const length = Math.min(0.55 / (robot.mass * GRAVITY), 1 / norm(force)) * robot.size;
        arrow(from, add(from, scale(force, length)), 0.006 * robot.size, [0.92, 0.28, 0.16, 1], ON_TOP);
      }
    }
    return items;
  }

  // The points of an instance that touch the ground now: the place, m, and the force, N, of each, in world axes.
  forcesOf(instance) {
    if (instance.state) return instance.stateForces || null;
    if (!instance.forces || !instance.times.length) return null;
    const [below, above, part] = this.bracket(instance.times, this.now);
    return mix(instance.forces[below], instance.forces[above], part);
  }

  scene() {
    const mean = this.meanAt(this.now), { camera } = this, isDark = this.isDark();
    const target = this.show.follow ? add(camera.target, subtract(mean, this.anchor)) : camera.target;
    const count = this.show.apart ? this.shownInstances().length : 1;
    const { yaw, pitch, distance } = camera;
    const direction = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
    return {
      target, eye: add(target, scale(direction, distance)), fieldOfView: FIELD_OF_VIEW, middle: mean,
      size: 1.35 * Math.hypot(this.size, (count - 1) * this.spacing), square: this.square,
      ground: this.show.ground ? this.ground - 1e-4 * this.size : null, grid: this.show.grid, shadows: this.show.shadows,
      paper: isDark ? [0.085, 0.105, 0.13] : [0.955, 0.962, 0.97], zenith: isDark ? [0.16, 0.2, 0.26] : [0.80, 0.87, 0.94],
      ink: isDark ? [0.9, 0.95, 1] : [0.12, 0.2, 0.3],
    };
  }

  isDark() { return matchMedia("(prefers-color-scheme: dark)").matches; }

  draw(size) {
    const { canvas } = this, ratio = window.devicePixelRatio || 1;
    const [width, height] = size || [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (!(width > 0 && height > 0)) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const scene = this.scene();
    this.renderer.draw(this.items(), scene);
    this.placeLabels(scene);
    if (this.end > this.start) {
      this.slider.value = (this.now - this.start) / (this.end - this.start);
      this.clock.textContent = `${this.now.toFixed(2)} / ${this.end.toFixed(2)} s`;
    }
    this.showCoordinates();
  }

  placeLabels(scene) {
    const shown = this.shownInstances();
    this.labels.replaceChildren();
    if (shown.length < 2 || !this.show.apart) return;
    const { clientWidth, clientHeight } = this.canvas;
    const matrix = multiply(perspective(FIELD_OF_VIEW, clientWidth / clientHeight, 0.01, 100), lookAt(scene.eye, scene.target, [0, 0, 1]));
    for (const { instance, shift } of shown) {
      const [x, y, z] = add(shift, [scene.middle[0], scene.middle[1], this.ground]);
      const w = matrix[3] * x + matrix[7] * y + matrix[11] * z + matrix[15];
      const [px, py] = transformPoint(matrix, [x, y, z]).map((value) => value / w);
      if (w > 0) this.labels.append(make("span", { style: `left:${50 + 50 * px}%;top:${50 - 50 * py}%` }, instance.name));
    }
  }

  // The entries of the coordinates that sliders set: name, range, and how they are read and written.
  entries(robot) {
    const list = [], turn = Math.PI, seen = new Set();
    for (const { joint } of robot.bodies) {
      if (joint.isMimic || joint.q === null || seen.has(joint.q)) continue;
      seen.add(joint.q);
      const plain = (label, i, low, high, isAngle) => list.push({ label, low, high, isAngle,
        get: (q) => q[joint.q + i], set: (q, x) => { q[joint.q + i] = x; } });
      const rotation = (first) => ["x", "y", "z"].forEach((axis, k) => list.push({ label: `${joint.name} rotation ${axis}`, low: -turn, high: turn, isAngle: true,
        get: (q) => vectorOfQuaternion(q.slice(first, first + 4))[k],
        set: (q, x) => { const v = vectorOfQuaternion(q.slice(first, first + 4)); v[k] = x; q.splice(first, 4, ...quaternionOfVector(v)); } }));
      const reach = robot.size, [low, high] = joint.range || [null, null];
      const isOpen = low === null || high === null || high - low > 4 * turn;
      if (joint.type === "prismatic") plain(joint.name, 0, low ?? -reach / 2, high ?? reach / 2, false);
      else if (joint.type === "revolute" || joint.type === "continuous") plain(joint.name, 0, isOpen ? -turn : low, isOpen ? turn : high, true);
      else if (joint.type === "universal") ["first", "second"].forEach((part, i) => plain(`${joint.name} ${part}`, i, -turn, turn, true));
      else if (joint.type === "planar") ["x", "y", "angle"].forEach((part, i) => plain(`${joint.name} ${part}`, i, i < 2 ? -reach : -turn, i < 2 ? reach : turn, i === 2));
      else if (joint.type === "spherical") rotation(joint.q);
      else if (joint.type === "floating") {
        ["x", "y", "z"].forEach((part, i) => plain(`${joint.name} ${part}`, i, i < 2 ? -reach : 0, i < 2 ? reach : 2 * reach, false));
        rotation(joint.q + 3);
      }
    }
    return list;
  }

  fillPanel() {
    const { panel, show } = this, section = (title, ...children) => make("section", {}, make("h2", {}, title), ...children);
    panel.replaceChildren();
    this.checks = {};
    const check = (name, label, after) => {
      const input = make("input", { type: "checkbox", checked: show[name], onchange: () => { show[name] = input.checked; if (after) after(); this.draw(); } });
      this.checks[name] = input;
      return make("label", {}, input, label);
    };
    if (this.instances.length > 1) {
      panel.append(section("Motions", ...this.instances.map((instance) => {
        const input = make("input", { type: "checkbox", checked: true, onchange: () => { instance.visible = input.checked; this.draw(); } });
        return make("label", {}, input, instance.name);
      }), check("apart", "Side by side", () => this.resetView())));
    }
    panel.append(section("Show", check("shapes", "Shapes"), check("inertia", "Inertia ellipsoids"), check("frames", "Frames"),
      check("center", "Centre of mass"), ...(this.instances.some((instance) => instance.forces) ? [check("forces", "Contact forces")] : []),
      check("ground", "Ground"), check("grid", "Grid"), check("shadows", "Shadows"),
      ...(this.end > this.start ? [check("follow", "Follow")] : []),
      make("button", { type: "button", onclick: () => { this.resetView(); this.draw(); } }, "Reset view")));
    panel.append(this.jointSection = make("section"));
    this.fillJoints();
    const isMoving = this.end > this.start;
    panel.append(section("Save", make("button", { type: "button", onclick: () => this.savePicture() }, "PNG"),
      ...(isMoving ? [make("button", { type: "button", onclick: (event) => this.saveSequence(event.target) }, "PNG sequence")] : []),
      ...(this.robots.length ? [make("button", { type: "button", onclick: () => this.saveScene() }, "GLB")] : [])));
    panel.append(make("p", { className: "help" }, "Drag to turn, shift-drag or two fingers to move, wheel to zoom",
      isMoving ? "; space plays, arrows step." : "."));
  }

  fillJoints() {
    this.sliders = [];
    const section = this.jointSection, instance = this.selected;
    section.replaceChildren();
    if (!instance) return;
    const movable = this.instances.filter((one) => one.robot);
    section.append(make("h2", {}, "Joints"));
    if (movable.length > 1) {
      section.append(make("select", { ariaLabel: "Motion", onchange: (event) => { this.selected = movable[event.target.selectedIndex]; this.fillJoints(); this.draw(); } },
        ...movable.map((one) => make("option", { selected: one === instance }, one.name))));
    }
    for (const entry of this.entries(instance.robot)) {
      const value = make("output"), input = make("input", { type: "range", min: entry.low, max: entry.high, step: "any", ariaLabel: entry.label, oninput: () => {
        const q = [...this.stateOf(instance, this.now)];
        entry.set(q, Number(input.value));
        this.play(false);
        this.setState(instance, q);
      } });
      section.append(make("label", { className: "joint" }, make("span", { title: entry.label }, entry.label), value, input));
      this.sliders.push({ entry, input, value });
    }
    section.append(make("button", { type: "button", onclick: () => { this.instances.forEach((one) => { one.state = null; }); this.draw(); } }, "Release"));
  }

  showCoordinates() {
    if (!this.selected) return;
    const q = this.stateOf(this.selected, this.now);
    for (const { entry, input, value } of this.sliders) {
      const x = entry.get(q);
      if (document.activeElement !== input) input.value = x;
      value.textContent = entry.isAngle ? `${rounded(x * 180 / Math.PI, 1)}\u00b0` : `${rounded(x, 3)} m`;
    }
  }

  // Sets the coordinates of an instance, and the forces of its contacts, in place of its motion.
  setState(instance, q, forces = null) {
    Object.assign(instance, { state: q, stateForces: forces });
    if (forces) this.show.forces = true;
    this.draw();
  }

  seek(time) {
    this.now = Math.min(Math.max(time, this.start), this.end);
    this.instances.forEach((instance) => { if (instance.times.length) instance.state = null; });
    this.draw();
  }

  play(on) {
    this.playing = on && this.end > this.start;
    this.playButton.textContent = this.playing ? "Pause" : "Play";
    if (!this.playing) return;
    let last = performance.now();
    const tick = (moment) => {
      if (!this.playing) return;
      const next = this.now + Math.max(moment - last, 0) / 1000 * Number(this.speed.value);
      last = moment;
      this.seek(next >= this.end ? this.start : next);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  fileName(ending) { return `${this.data.title.replace(/[^\w.-]+/g, "_") || "robot"}${ending}`; }

  picture() { return new Promise((resolve) => this.canvas.toBlob(resolve, "image/png")); }

  async savePicture() {
    this.draw();
    download(await this.picture(), this.fileName(".png"));
  }

  // Saves a picture for each thirtieth of a second, as an archive.
  async saveSequence(button, rate = 30) {
    this.play(false);
    const files = [], count = Math.floor((this.end - this.start) * rate + 1e-6) + 1, before = this.now, label = button.textContent;
    for (let i = 0; i < count; i++) {
      this.seek(this.start + i / rate);
      const blob = await this.picture();
      files.push({ name: `${String(i).padStart(5, "0")}.png`, bytes: new Uint8Array(await blob.arrayBuffer()) });
      button.textContent = `${i + 1} of ${count}`;
    }
    button.textContent = label;
    this.seek(before);
    download(zip(files), this.fileName("_frames.zip"));
  }

  // The robots that are shown and their motions as a GLB.
  sceneFile() {
    const instances = this.shownInstances().filter(({ instance }) => instance.robot).map(({ instance, shift }) => {
      const { robot } = instance, parts = [...robot.geometries], moved = translation(shift);
      const times = instance.state || !instance.times.length ? [this.now] : instance.times;
      const poses = times.map((time) => {
        const bodies = robot.poses(this.stateOf(instance, time));
        return parts.map(([body]) => multiply(moved, body < 0 ? identity() : bodies[body]));
      });
      const bodies = parts.map(([body, geometry]) => ({ name: body < 0 ? "world" : robot.bodies[body].name, geometry }));
      return { name: instance.name, bodies, times, poses };
    });
    return glb(this.data.title, instances);
  }

  saveScene() { download(this.sceneFile(), this.fileName(".glb")); }

  listen() {
    const { canvas } = this, pointers = new Map();
    const zoom = (factor) => { this.camera.distance = Math.min(Math.max(this.camera.distance * factor, 0.05 * this.reset.size), 40 * this.reset.size); };
    const move = (dx, dy) => {
      const { camera } = this, step = 2 * camera.distance * Math.tan(FIELD_OF_VIEW / 2) / canvas.clientHeight;
      const [c, s, p] = [Math.cos(camera.yaw), Math.sin(camera.yaw), Math.sin(camera.pitch)];
      const right = [-s, c, 0], up = [-c * p, -s * p, Math.cos(camera.pitch)];
      camera.target = add(camera.target, add(scale(right, -dx * step), scale(up, dy * step)));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    const lift = (event) => pointers.delete(event.pointerId);
    canvas.addEventListener("pointerup", lift);
    canvas.addEventListener("pointercancel", lift);
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
      const gap = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
      const old = pointers.size === 2 ? gap() : 0;
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      if (old > 0) { zoom(old / Math.max(gap(), 1)); move(dx / 2, dy / 2); }
      else if (event.shiftKey || event.buttons & 6) move(dx, dy);
      else {
        this.camera.yaw -= dx * 0.008;
        this.camera.pitch = Math.min(Math.max(this.camera.pitch + dy * 0.008, -1.5), 1.5);
      }
      this.draw();
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY * 0.001)); this.draw(); }, { passive: false });
    window.addEventListener("keydown", (event) => {
      if (["INPUT", "SELECT", "BUTTON", "TEXTAREA"].includes(event.target.tagName)) return;
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === " ") this.play(!this.playing);
      else if (step) this.seek(this.now + step * (this.end - this.start) / 100);
      else return;
      event.preventDefault();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }
}
