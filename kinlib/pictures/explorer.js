// What a reader can change in a scene: points of planes, sliders and choices; what is seen follows by formulas that were
// recorded from kinlib.  There is no mathematics here: rods go from point to point.
//
// window.kinlib then has, besides what every scene has:
//   parameters        names and values, the choices by their numbers
//   set(name, value)  another value of a parameter
//   choose(name, n)   another choice
//   axes()            the half-turns of what is shown, at home; null where nothing is shown
//   table()           the numbers of the table, row by row; null where nothing is shown
//   points()          the points through which parts are laid, at this moment, in units of length
//   trouble()         why nothing is shown, in words
//   recipe            what was recorded
"use strict";
window.explore = (recording, { state, draw, frame }) => {
  const { explorer: given, cells: [cell], frames } = recording;
  const { unit, centre } = cell;
  const { controls, inputs } = given;
  const formulas = given.formulas.map((text) => Function(`"use strict";return ${text}`)());
  const choices = controls.filter(({ kind }) => kind === "choice");
  const namesOf = (control) => control.names || [control.name];
  const start = Object.fromEntries(controls.flatMap((c) => namesOf(c).map((name, k) => [name, [c.start].flat()[k]])));
  const values = { ...start };
  let now = null; // what the formula says
  let wrong = ""; // why nothing is shown
  let dragging = false;

  // ---- formulas ---------------------------------------------------------------------------------------------

  const which = () => choices.reduce((n, { name, options }) => n * options.length + values[name], 0);
  const FAR = 1e9; // stands for infinity

  // Between two frames the turn goes on evenly.
  function parameter(at) {
    const turns = given.turns[given.turnOf[which()]];
    const first = Math.floor(at) % frames;
    const step = turns[(first + 1) % frames] - turns[first];
    const whole = 2 * Math.PI;
    const angle = turns[first] + (at - Math.floor(at)) * (step - whole * Math.round(step / whole));
    return Math.min(Math.max(1 / Math.tan(angle / 2), -FAR), FAR);
  }
  // Further parameters that belong to where a slider stops.
  const sources = Object.fromEntries(controls.flatMap((c) => (c.sampled || []).map((name, k) => [name, [c, k]])));
  function sample(name) {
    const [control, k] = sources[name];
    return control.samples[which()][control.values.indexOf(values[control.name])][k];
  }
  const input = (name, at) => (name === given.turn ? parameter(at) : name in values ? values[name] : sample(name));
  const evaluate = (at) => formulas[given.formulaOf[which()]](...inputs.map((name) => input(name, at)));

  function judge() {
    const near = (limit) => given.bad.find((_, n) => !(Math.abs(now.bad[n]) > limit));
    const finite = [now.points, now.axes, now.table].every((rows) => rows.flat().every(Number.isFinite));
    wrong = near(given.near) || (finite ? "" : "the numbers run away");
    if (wrong) return [`${given.nothing}: ${wrong}.`];
    const close = near(given.close);
    const said = given.words.map((pair, n) => pair[now.signs[n] > 0 ? 0 : 1]);
    return [...said, ...(close ? [`Nearly so: ${close}.`] : [])];
  }

  // ---- the page ---------------------------------------------------------------------------------------------

  function make(tag, attributes, parent, text) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text) made.textContent = text;
    if (parent) parent.append(made);
    return made;
  }
  const minus = (text) => text.replace("-", "−");
  const short = (x, digits = 3) => (Math.abs(x) < 0.5 * 10 ** -digits ? "0" : minus(x.toFixed(digits)));

  document.body.classList.add("explorable");
  const panel = make("section", { class: "panel", "aria-label": "What can be changed" }, document.body);
  const makers = { pad: addPad, slider: addSlider, choice: addChoice };
  const updates = controls.map((control) => makers[control.kind](control));
  const bar = make("p", { class: "choices" }, panel);
  make("button", { type: "button", class: "word" }, bar, "Reset").addEventListener("click", () => change(start));
  const link = make("a", { class: "word", target: "_parent" }, bar, "Link to this");
  const status = make("p", { class: "status", "aria-live": "polite" }, panel);
  const table = make("table", {}, panel);
  const entries = [];
  if (given.columns.length) {
    make("caption", {}, table, given.caption);
    const head = make("tr", {}, make("thead", {}, table));
    ["", ...given.columns.map(([name]) => name)].forEach((name) => make(name ? "th" : "td", name ? { scope: "col" } : {}, head, name));
    const body = make("tbody", {}, table);
    given.rows.forEach((name) => {
      const line = make("tr", {}, body);
      make("th", { scope: "row" }, line, name);
      entries.push(given.columns.map(() => make("td", {}, line)));
    });
  }

  function addPad({ names, label, dot, limits, pictures, marks }) {
    const pad = make("div", { class: "pad", tabindex: 0, role: "slider", "aria-label": label, "aria-roledescription": "point in a plane",
      "aria-valuemin": limits[0][0], "aria-valuemax": limits[0][1] }, panel);
    const picture = make("img", { alt: "", draggable: "false" }, pad);
    const others = marks.map((name) => make("i", { class: "dot partner", "data-name": name }, pad));
    const own = make("i", { class: "dot", "data-name": dot }, pad);
    const fields = make("p", { class: "fields" }, panel);
    const boxes = names.map((name) => {
      const box = make("input", { type: "number", step: 0.01 }, make("label", {}, fields, `${name} `));
      box.addEventListener("change", () => Number.isFinite(box.valueAsNumber) && change({ [name]: box.valueAsNumber }));
      return box;
    });
    const inside = (x, k) => Math.min(Math.max(x, limits[k][0]), limits[k][1]);
    const go = (point) => change(Object.fromEntries(names.map((name, k) => [name, inside(point[k], k)])));
    const move = (tag, point) => {
      const [left, top] = limits.map(([low, high], k) => 100 * (point[k] - low) / (high - low));
      tag.hidden = !(left >= 0 && left <= 100 && top >= 0 && top <= 100);
      tag.style.left = `${left}%`;
      tag.style.top = `${100 - top}%`;
    };
    let box = null; // where the pad is
    const drag = (event) => {
      const share = [(event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height];
      go(share.map((s, k) => limits[k][0] + s * (limits[k][1] - limits[k][0])));
    };
    pad.addEventListener("pointerdown", (event) => {
      pad.setPointerCapture(event.pointerId);
      dragging = true;
      box = pad.getBoundingClientRect();
      drag(event);
    });
    pad.addEventListener("pointermove", (event) => { if (pad.hasPointerCapture(event.pointerId)) drag(event); });
    pad.addEventListener("lostpointercapture", () => {
      dragging = false;
      refresh();
    });
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    pad.addEventListener("keydown", (event) => {
      const step = arrows[event.key];
      if (event.key === "Home") change(Object.fromEntries(names.map((name) => [name, start[name]])));
      else if (step) go(names.map((name, k) => values[name] + step[k] * (event.shiftKey ? 0.05 : 0.005) * (limits[k][1] - limits[k][0])));
      else return;
      event.preventDefault();
    });
    return () => {
      const point = names.map((name) => values[name]);
      const source = pictures[which()];
      if (picture.dataset.of !== String(source)) picture.src = given.pictures[source];
      picture.dataset.of = source;
      move(own, point);
      others.forEach((tag, n) => move(tag, now.marks[n] || [NaN, NaN]));
      boxes.forEach((entry, k) => { if (document.activeElement !== entry || !dragging) entry.value = +point[k].toFixed(4); });
      pad.setAttribute("aria-valuenow", point[0]);
      pad.setAttribute("aria-valuetext", names.map((name, k) => `${name} = ${short(point[k])}`).join(", "));
    };
  }

  function addSlider({ name, label, limits: [low, high], unit: shown, values: stops }) {
    const line = make("label", { class: "slide" }, panel, `${label} `);
    const range = stops ? { min: 0, max: stops.length - 1, step: 1 } : { min: low, max: high, step: (high - low) / 400 };
    const slider = make("input", { type: "range", ...range }, line);
    const out = make("output", {}, line);
    slider.addEventListener("input", () => {
      dragging = true;
      change({ [name]: stops ? stops[slider.value] : Number(slider.value) });
    });
    slider.addEventListener("change", () => {
      dragging = false;
      refresh();
    });
    slider.addEventListener("keydown", (event) => {
      if (event.key !== "Home") return;
      change({ [name]: start[name] });
      event.preventDefault();
    });
    return () => {
      slider.value = stops ? stops.indexOf(values[name]) : values[name];
      const among = stops ? ` · ${stops.indexOf(values[name]) + 1}/${stops.length}` : "";
      out.textContent = short(values[name], 2) + shown + among;
      slider.setAttribute("aria-valuetext", out.textContent);
    };
  }

  function addChoice({ name, label, options, moves }) {
    if (moves.length) return addMoves({ name, label, options, moves });
    const select = make("select", {}, make("label", { class: "choice" }, panel, `${label} `));
    options.forEach((text, n) => make("option", { value: n }, select, text));
    select.addEventListener("change", () => change({ [name]: Number(select.value) }));
    return () => { select.value = values[name]; };
  }

  // Buttons that lead from one of the options to another.
  function addMoves({ name, label, options, moves }) {
    const line = make("p", { class: "choices" }, panel, label);
    const out = make("output", { "aria-live": "polite" }, line);
    for (const [text, next] of moves) {
      const button = make("button", { type: "button", class: "word move" }, make("p", { class: "choices" }, panel), text);
      button.addEventListener("click", () => change({ [name]: next[values[name]] }));
    }
    return () => { out.textContent = options[values[name]]; };
  }

  function refresh() {
    now = evaluate(state.frame);
    const said = judge().join(" ");
    if (status.textContent !== said) status.textContent = said;
    updates.forEach((update) => update());
    table.hidden = Boolean(wrong) || !entries.length;
    if (!table.hidden) writeTable();
    if (group && !wrong) drawTrails();
    if (!dragging) {
      link.setAttribute("href", address());
      if (!wrong) show();
    }
    draw();
  }
  function writeTable() {
    entries.forEach((line, n) => line.forEach((place, k) => {
      const [, factor, digits] = given.columns[k];
      const text = short(factor * now.table[n][k], digits);
      if (place.textContent !== text) place.textContent = text;
    }));
  }
  function change(wanted) {
    for (const [name, value] of Object.entries(wanted)) values[name] = settled(name, value);
    refresh();
  }
  // A slider that stops at some values only goes to the nearest.
  function settled(name, value) {
    const { values: stops } = controls.find((c) => c.name === name) || {};
    return stops ? stops.reduce((best, x) => (Math.abs(x - value) < Math.abs(best - value) ? x : best)) : value;
  }

  // ---- a link that holds the state --------------------------------------------------------------------------

  let page = window; // whose address it is
  try {
    if (window.frameElement && parent.location.href.includes(":")) page = parent;
  } catch { /* a page of another origin keeps its address to itself */ }
  const number = () => (page === window ? 0 : [...parent.document.querySelectorAll("iframe.kinlib-scene")].indexOf(window.frameElement));
  const hash = () => Object.entries(values).map(([name, value]) => `${name}=${+value.toFixed(6)}`).join("&");
  const address = () => `${page.location.href.split("#")[0]}#scene=${number()}&${hash()}`;

  function obey() {
    const asked = new URLSearchParams(page.location.hash.slice(1));
    if (page !== window && asked.get("scene") !== String(number())) return false;
    const known = Object.keys(values).filter((name) => asked.has(name) && allowed(name, Number(asked.get(name))));
    known.forEach((name) => { values[name] = settled(name, Number(asked.get(name))); });
    return known.length > 0;
  }
  function allowed(name, value) {
    const choice = choices.find((c) => c.name === name);
    return choice ? choice.options[value] !== undefined : Number.isFinite(value);
  }

  // ---- what is seen -----------------------------------------------------------------------------------------

  let place = null; // three.js's node with all that is drawn
  let group = null;
  let drawn = -1; // which list of items
  let pieces = [];
  const inView = (p) => p.map((x, k) => (x - centre[k]) / unit);
  const three = () => window.MeshCat.THREE;
  const shapes = {};
  const shape = (kind) => {
    const { CylinderGeometry, SphereGeometry } = three();
    const makes = { rod: () => new CylinderGeometry(1, 1, 1, 20), head: () => new CylinderGeometry(0, 1, 1, 16), ball: () => new SphereGeometry(1, 20, 14) };
    shapes[kind] = shapes[kind] || makes[kind]();
    return shapes[kind];
  };

  function lay(piece, from, to, thick) {
    const { Vector3 } = three();
    const [a, b] = [new Vector3(...from), new Vector3(...to)];
    const along = b.clone().sub(a);
    const length = Math.max(along.length(), 1e-6);
    piece.position.copy(a).add(b).multiplyScalar(0.5);
    piece.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), along.divideScalar(length));
    piece.scale.set(thick, length, thick);
    piece.updateMatrix();
  }
  function paint({ colour, opacity }) {
    const { MeshPhongMaterial } = three();
    return new MeshPhongMaterial({ color: colour, opacity, transparent: opacity < 1 });
  }
  function solid(kind, item) {
    const { Mesh } = three();
    const made = new Mesh(shape(kind), paint(item));
    group.add(made);
    return made;
  }
  function chain(item, count) {
    const { InstancedMesh } = three();
    const made = new InstancedMesh(shape("rod"), paint(item), count);
    made.frustumCulled = false;
    group.add(made);
    return made;
  }
  function layChain(made, path, thick, closed) {
    const { Object3D } = three();
    const piece = new Object3D();
    path.forEach((p, n) => {
      if (!closed && n + 1 === path.length) return;
      lay(piece, p, path[(n + 1) % path.length], thick);
      made.setMatrixAt(n, piece.matrix);
    });
    made.instanceMatrix.needsUpdate = true;
  }

  // One entry a kind of item: what it is made of, and how it is laid through its points.
  const kinds = {
    rod: (item) => {
      const made = solid("rod", item);
      return ([a, b]) => lay(made, a, b, item.radius);
    },
    ball: (item) => {
      const made = solid("ball", item);
      return ([a]) => {
        made.position.set(...a);
        made.scale.setScalar(item.radius);
      };
    },
    frame: (item) => {
      const arrows = given.triad.map((colour) => ["rod", "head"].map((kind) => solid(kind, { colour, opacity: 1 })));
      return ([origin, ...tips]) => tips.forEach((tip, k) => {
        const at = (share) => origin.map((x, n) => x + share * item.size * (tip[n] - x));
        lay(arrows[k][0], origin, at(1), item.radius);
        lay(arrows[k][1], at(1), at(1.3), 2.2 * item.radius);
      });
    },
    label: (item) => ([a]) => { cell.labels[item.label][2].splice(0, 3, ...a); },
    curve: (item) => {
      const made = chain(item, item.count);
      return (path) => layChain(made, path, item.radius, item.closed);
    },
    trail: (item) => {
      const made = chain(item, given.steps);
      const lays = () => {};
      lays.trail = (path) => layChain(made, path, item.radius, true);
      return lays;
    },
  };

  function build(where) {
    place = where;
    rebuild();
  }
  function rebuild() {
    const { Group } = three();
    if (group) place.remove(group);
    group = new Group();
    place.add(group);
    drawn = given.itemsOf[which()];
    let first = 0;
    pieces = given.items[drawn].map((item) => {
      first += item.count;
      return { lays: kinds[item.kind](item), range: [first - item.count, first] };
    });
    if (now && !wrong) drawTrails();
  }
  // As many times, closer together where one of the paths is passed in a rush.
  function evenly(times, paths) {
    const far = ([a, b, c], [x, y, z]) => Math.min(Math.hypot(a - x, b - y, c - z), 1);
    const lengths = times.map((_, n) => 0.02 + Math.max(...paths.map((path) => far(path[n], path[(n + 1) % path.length]))));
    const whole = lengths.reduce((sum, length) => sum + length);
    let [n, passed] = [0, 0];
    return times.map((_, k) => {
      const wanted = k * whole / times.length;
      while (passed + lengths[n] < wanted) passed += lengths[n++];
      return (n + (wanted - passed) / lengths[n]) * frames / times.length;
    });
  }
  const placed = (at) => at.points.map(inView);
  function drawTrails() {
    if (given.itemsOf[which()] !== drawn) {
      rebuild();
      return;
    }
    const trails = pieces.filter(({ lays }) => lays.trail);
    if (!trails.length) return;
    const pathAt = (times) => times.map((at) => placed(evaluate(at)));
    const times = [...Array(given.steps).keys()].map((n) => n * frames / given.steps);
    let turn = pathAt(times);
    if (!dragging) turn = pathAt(evenly(times, trails.map(({ range: [n] }) => turn.map((points) => points[n]))));
    trails.forEach(({ lays, range: [n] }) => lays.trail(turn.map((points) => points[n])));
  }
  // All comes into view, unless it runs far away.
  function show() {
    const count = given.turn ? 12 : 1;
    const points = [...Array(count).keys()].flatMap((n) => placed(evaluate(n * frames / count)));
    cell.hull = [...given.kept, ...points.filter((p) => Math.max(...p.map(Math.abs)) < 3)];
    frame();
  }
  function placeAll() {
    group.visible = !wrong;
    if (wrong) return;
    const points = placed(given.turn ? evaluate(state.frame) : now);
    pieces.forEach(({ lays, range }) => lays(points.slice(...range)));
  }

  // ---- orders -----------------------------------------------------------------------------------------------

  Object.defineProperty(state, "parameters", { get: () => ({ ...values }) });
  state.set = (name, value) => {
    if (!(name in values) || choices.some((c) => c.name === name)) throw new Error(`there is no parameter ${name}`);
    if (!Number.isFinite(value)) throw new Error(`expected a number for ${name}, got ${value}`);
    change({ [name]: value });
  };
  state.choose = (name, index) => {
    if (!choices.some((c) => c.name === name) || !allowed(name, index)) throw new Error(`there is no ${name} ${index}`);
    change({ [name]: index });
  };
  state.axes = () => (wrong ? null : now.axes);
  state.table = () => (wrong ? null : now.table);
  state.points = () => (wrong ? null : evaluate(state.frame).points);
  state.trouble = () => wrong;
  state.recipe = given.recipe;
  if (obey() && page !== window) window.frameElement.scrollIntoView({ block: "center" });
  page.addEventListener("hashchange", () => { if (obey()) refresh(); });
  queueMicrotask(refresh);
  return { build, place: () => { if (group && now) placeAll(); } };
};
