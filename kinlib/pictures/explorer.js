// What a reader can change in a scene: a point of a plane and a choice; the linkage follows by recorded formulas.
"use strict";
window.explore = (recording, { state, draw, frame }) => {
  const { explorer: given, cells: [{ unit, centre }], frames } = recording;
  const formula = (text) => Function(`"use strict";return ${text}`)();
  const shapes = formula(given.shapes);
  const motions = given.motions.map(formula);
  const start = given.start.slice();
  const point = start.slice();
  let chosen = given.choice;
  let now = null; // what the formulas say of all linkages
  let wrong = ""; // what is wrong with the point, in words
  let group = null; // three.js's, with all that is drawn
  let pieces = [];
  let trail = null;
  let dragging = false;
  let box = null; // where the pad is

  // ---- the page
  const make = (tag, attributes, parent, text) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text) made.textContent = text;
    if (parent) parent.append(made);
    return made;
  };
  document.body.classList.add("explorable");
  const panel = make("section", { class: "panel", "aria-label": "Parameters" }, document.body);
  const pad = make("div", { class: "pad", tabindex: "0", role: "application", "aria-roledescription": "point in a plane",
    "aria-label": `${given.pad}: arrow keys move it, Home brings it back` }, panel);
  make("img", { src: given.picture, alt: "", draggable: "false" }, pad);
  const dot = make("i", { class: "dot" }, pad);
  const second = make("i", { class: "dot partner" }, pad);
  const bar = make("p", { class: "choices" }, panel);
  const select = make("select", {}, make("label", {}, bar, `${given.chooser} `));
  given.choices.forEach((name, n) => make("option", { value: n }, select, name));
  const reset = make("button", { type: "button", class: "word" }, bar, "Reset");
  const link = make("a", { class: "word" }, bar, "Link to this");
  const status = make("p", { class: "status", "aria-live": "polite" }, panel);
  const table = make("table", {}, panel);
  const place = ([x, y]) => given.limits.map(([low, high], k) => 100 * ([x, y][k] - low) / (high - low));
  const move = (tag, where) => {
    const [left, top] = place(where);
    tag.hidden = !(left >= 0 && left <= 100 && top >= 0 && top <= 100);
    tag.style.left = `${left}%`;
    tag.style.top = `${100 - top}%`;
  };
  const short = (x) => (Math.abs(x) < 5e-4 ? "0" : x.toFixed(3)).replace("-", "−");

  function refresh() {
    now = shapes(...point);
    const linkage = now.linkages[chosen];
    const near = given.bad.map((words, n) => [words, now.bad[given.plane[chosen]][n]]).find(([, far]) => !(Math.abs(far) > given.near));
    const finite = linkage.flat(Infinity).every(Number.isFinite);
    wrong = near ? near[0] : finite ? "" : "there is no linkage at this point";
    status.textContent = wrong ? `No linkage here: ${wrong}.` : `z = ${short(point[0])} + √−1 · ${short(point[1])}`;
    pad.setAttribute("aria-valuetext", status.textContent);
    move(dot, point);
    move(second, now.partner[given.plane[chosen]]);
    select.value = chosen;
    table.hidden = Boolean(wrong);
    if (!wrong) writeTable();
    if (window.parent === window) link.setAttribute("href", `#${hash()}`);
    else link.textContent = hash(); // a frame has no address of its own: text to copy
    if (group && !wrong) drawTrail();
    if (!wrong && !dragging) show();
    draw();
  }
  const rows = () => [["link", "distance", "twist in °", "offset"],
    ...numbers().map(([a, b, d], n) => [`${n + 1}`, short(a), (b * 180 / Math.PI).toFixed(1).replace("-", "−"), short(d)])];
  let cells = null;
  function writeTable() {
    const texts = rows();
    cells = cells || texts.map((row, n) => {
      const line = make("tr", {}, table);
      return row.map((_, k) => make(n && k ? "td" : "th", n ? (k ? {} : { scope: "row" }) : { scope: "col" }, line));
    });
    texts.forEach((row, n) => row.forEach((text, k) => {
      if (cells[n][k].textContent !== text) cells[n][k].textContent = text;
    }));
  }
  const numbers = () => now.linkages[chosen][3];
  const hash = () => `x=${+point[0].toFixed(4)}&y=${+point[1].toFixed(4)}&linkage=${chosen}`;

  // ---- the linkage
  function displacements(angle) {
    const [, , factors] = now.linkages[chosen];
    return motions[given.motion[chosen]](...factors.flat(), Math.cos(angle / 2), Math.sin(angle / 2));
  }
  function moved([p0, p1, p2, p3, d0, d1, d2, d3], [x, y, z]) {
    const s = 2 / (p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3);
    return [
      x + s * (p1 * p2 * y - p0 * p3 * y + p1 * p3 * z + p0 * p2 * z - (p2 * p2 + p3 * p3) * x + p0 * d1 - d0 * p1 + p2 * d3 - p3 * d2),
      y + s * (p1 * p2 * x + p0 * p3 * x + p2 * p3 * z - p0 * p1 * z - (p1 * p1 + p3 * p3) * y + p0 * d2 - d0 * p2 + p3 * d1 - p1 * d3),
      z + s * (p1 * p3 * x - p0 * p2 * x + p2 * p3 * y + p0 * p1 * y - (p1 * p1 + p2 * p2) * z + p0 * d3 - d0 * p3 + p1 * d2 - p2 * d1),
    ];
  }
  const { THREE } = window.MeshCat || {};
  const three = () => THREE || window.MeshCat.THREE;
  const inView = (p) => p.map((x, k) => (x - centre[k]) / unit);
  function lay(rod, from, to, thick) {
    const { Vector3 } = three();
    const [a, b] = [from, to].map((p) => new Vector3(...inView(p)));
    const along = b.clone().sub(a);
    const length = Math.max(along.length(), 1e-6);
    rod.position.copy(a).add(b).multiplyScalar(0.5);
    rod.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), along.divideScalar(length));
    rod.scale.set(thick, length, thick);
    rod.updateMatrix();
  }
  function rod(colour) {
    const { Mesh, CylinderGeometry, MeshPhongMaterial } = three();
    const made = new Mesh(new CylinderGeometry(1, 1, 1, 20), new MeshPhongMaterial({ color: colour }));
    group.add(made);
    return made;
  }
  function build(where) {
    const { InstancedMesh, CylinderGeometry, MeshPhongMaterial, Group } = three();
    group = new Group();
    where.add(group);
    pieces = given.colours.map((colour, n) => ({
      bar: rod(colour), first: rod(colour), second: rod(colour), pin: rod(given.pin), arm: n === given.coupler ? rod(colour) : null,
    }));
    trail = new InstancedMesh(new CylinderGeometry(1, 1, 1, 8), new MeshPhongMaterial({ color: given.colours[given.coupler] }), given.steps);
    trail.frustumCulled = false;
    group.add(trail);
    if (now && !wrong) drawTrail();
  }
  function drawTrail() {
    const { Object3D } = three();
    const piece = new Object3D();
    const path = [...Array(given.steps).keys()].map((n) => moved(displacements(2 * Math.PI * n / given.steps)[given.coupler], given.point));
    path.forEach((p, n) => {
      lay(piece, p, path[(n + 1) % given.steps], 0.006);
      trail.setMatrixAt(n, piece.matrix);
    });
    trail.instanceMatrix.needsUpdate = true;
  }
  // All of the linkage comes into view, unless it runs far away.
  function show() {
    const turn = [...Array(8).keys()].map((n) => displacements(Math.PI * n / 4));
    const points = turn.flatMap((links) => links.flatMap((q, n) => [
      ...now.linkages[chosen][1][(n + links.length - 1) % links.length].map((p) => moved(q, p)),
      ...(n === given.coupler ? [moved(q, given.point)] : []),
    ])).map(inView);
    const far = (p) => Math.max(...p.map(Math.abs));
    recording.cells[0].hull = [...given.kept, ...points.filter((p) => far(p) < 3)];
    frame();
  }
  function placeAll() {
    group.visible = !wrong;
    if (wrong) return;
    const links = displacements(2 * Math.PI * state.frame / frames);
    const [axes, feet] = now.linkages[chosen];
    const count = links.length;
    const size = 0.05 * unit;
    pieces.forEach(({ bar, first, second, pin, arm }, n) => {
      const at = (p) => moved(links[n], p);
      const [before, after] = [(n + count - 1) % count, n];
      const [from, to] = [feet[before][1], feet[before][0]].reverse();
      lay(bar, at(from), at(to), n ? 0.018 : 0.025);
      [[first, from, before, 1], [second, to, after, -1]].forEach(([sleeve, foot, axis, side]) => {
        const step = axes[axis].slice(1, 4).map((x) => side * size * x);
        lay(sleeve, at(foot), at(foot.map((x, k) => x + step[k])), 0.035);
      });
      const own = axes[after].slice(1, 4);
      const next = feet[after][0];
      lay(pin, at(to.map((x, k) => x - 1.3 * size * own[k])), at(next.map((x, k) => x + 1.3 * size * own[k])), 0.014);
      if (arm) lay(arm, at(from), at(given.point), 0.01);
    });
  }

  // ---- the reader
  const inside = (x, k) => Math.min(Math.max(x, given.limits[k][0]), given.limits[k][1]);
  function go(where) {
    where.forEach((x, k) => { point[k] = x; });
    refresh();
  }
  const within = (where) => where.map(inside);
  function drag(event) {
    const share = [(event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height];
    go(within(share.map((s, k) => given.limits[k][0] + s * (given.limits[k][1] - given.limits[k][0]))));
  }
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
    if (event.key === "Home") go(start);
    else if (arrows[event.key]) go(within(point.map((x, k) => x + arrows[event.key][k] * (event.shiftKey ? 0.2 : 0.02))));
    else return;
    event.preventDefault();
  });
  select.addEventListener("change", () => state.choose(given.chooser, Number(select.value)));
  reset.addEventListener("click", () => {
    chosen = given.choice;
    go(start);
  });
  Object.defineProperty(state, "parameters", { get: () => ({ x: point[0], y: point[1], [given.chooser]: chosen }) });
  state.set = (name, value) => {
    const k = ["x", "y"].indexOf(name);
    if (k < 0 || !Number.isFinite(value)) throw new Error(`expected a number for x or y, got ${name} = ${value}`);
    go(point.map((x, n) => (n === k ? value : x)));
  };
  state.choose = (name, index) => {
    if (name !== given.chooser || !given.choices[index]) throw new Error(`there is no ${name} ${index}`);
    chosen = index;
    refresh();
  };
  state.axes = () => (wrong ? null : now.linkages[chosen][0]);
  state.table = () => (wrong ? null : numbers());
  state.trouble = () => wrong;
  state.recipe = given.recipe;
  const asked = new URLSearchParams(location.hash.slice(1));
  ["x", "y"].forEach((name, k) => { if (asked.has(name) && Number.isFinite(+asked.get(name))) point[k] = +asked.get(name); });
  if (given.choices[+asked.get("linkage")] && asked.has("linkage")) chosen = +asked.get("linkage");
  queueMicrotask(refresh);
  return { build, place: () => { if (group && now) placeAll(); } };
};
