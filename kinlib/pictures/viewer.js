// Plays one recorded scene.  The page holds its recording, as JSON, in <script id="recording">.
//
// window.kinlib tells what goes on, and takes orders:
//   ready    whether the scene is drawn at this moment: it is while the reader can see it
//   playing  whether time runs
//   frame    where the motion is, from 0 to frames; not whole while it plays
//   frames   how many frames one turn has
//   play(), pause()
//   seek(n)  go to frame n, and draw it at once
//   matrix(body, cell = 0)  where a body is: its matrix by columns, in the units of the recording
//   view()   the camera's direction, [azimuth, elevation] in degrees
"use strict";
(() => {
  const recording = JSON.parse(document.getElementById("recording").textContent);
  const { bundle } = window; // where meshcat's viewer is, unless it is in the page
  const { frames, cells, captions } = recording;
  const lights = cells[0].lights;
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const LINGER = 650; // milliseconds at a frame that lights up
  const GLOW = 1.6; // frames on either side of it that still show the light

  // ---- the page ---------------------------------------------------------------------------------------------

  const icon = (path) => `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${path}"/></svg>`;
  const PLAY = icon("M7 4v16l13-8z");
  const PAUSE = icon("M6 4h4v16H6zm8 0h4v16h-4z");
  const HOME = icon("M12 5V1L7 6l5 5V7a5 5 0 1 1-5 5H5a7 7 0 1 0 7-7z");
  const NEARER = icon("M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z");
  const FARTHER = icon("M5 11h14v2H5z");
  const FULL = icon("M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4z");

  function element(tag, attributes, parent) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (parent) parent.append(made);
    return made;
  }

  const stage = element("div", { class: "stage", role: "img", tabindex: "0", "aria-label": recording.alt }, document.body);
  const overlay = element("div", { class: cells.length > 1 ? "labels many" : "labels", "aria-hidden": "true" }, stage);
  const controls = element("div", { class: "controls" }, document.body);
  const toggle = element("button", { type: "button" }, controls);
  const slider = element("input", {
    type: "range", min: 0, max: frames - 1, step: 1, value: 0, "aria-label": recording.slider,
  }, controls);
  const readout = element("output", {}, controls);
  const button = (name, picture) => {
    const made = element("button", { type: "button", "aria-label": name, title: name }, controls);
    made.innerHTML = picture;
    return made;
  };
  const farther = button("Zoom out", FARTHER);
  const nearer = button("Zoom in", NEARER);
  const home = button("Reset the view", HOME);
  const full = button("Full screen", FULL);
  full.hidden = !document.fullscreenEnabled;
  if (frames < 2) for (const part of [toggle, slider, readout]) part.hidden = true;
  if (recording.legend.length) {
    const list = element("ul", { class: "legend" }, document.body);
    for (const [text, colour] of recording.legend) {
      const entry = element("li", {}, list);
      element("span", { style: `background:${colour}` }, entry);
      entry.append(text);
    }
  }
  const names = cells.map((cell) => {
    const name = element("div", { class: "name" }, overlay);
    name.textContent = cell.name;
    return name;
  });
  const labels = cells.flatMap((cell, number) => cell.labels.map(([text, body, point, light, tips]) => {
    const tag = element("div", { class: "label" }, overlay);
    tag.textContent = text;
    return { tag, body, point, light, number, tips: tips || [] };
  }));

  function say(text) {
    element("p", { class: "message" }, stage).textContent = text;
  }

  // The theme is that of the page around, or else that of the reader's system.
  function theme() {
    const dark = matchMedia("(prefers-color-scheme: dark)");
    let around = null;
    try {
      if (window.parent !== window) around = window.parent.document;
    } catch { /* a page of another origin keeps its theme to itself */ }
    const settle = () => {
      const asked = around && (around.documentElement.dataset.theme
        || { true: "light", false: "dark" }[around.body.dataset.jpThemeLight]);
      document.documentElement.dataset.theme = asked || (dark.matches ? "dark" : "light");
      glaze();
    };
    settle();
    dark.addEventListener("change", settle);
    if (around) {
      const watch = new MutationObserver(settle);
      watch.observe(around.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
      watch.observe(around.body, { attributes: true, attributeFilter: ["data-jp-theme-light"] });
    }
  }

  // ---- displacements ----------------------------------------------------------------------------------------

  // Between two frames dual quaternions are blended linearly; any point of P7 with a primal part has a displacement.
  function blend(track, frame) {
    const first = Math.floor(frame) % frames;
    const next = (first + 1) % frames;
    const share = frame - Math.floor(frame);
    const a = track.slice(8 * first, 8 * first + 8);
    if (share === 0) return a;
    const b = track.slice(8 * next, 8 * next + 8);
    const near = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -share : share;
    return a.map((x, k) => (1 - share) * x + near * b[k]);
  }

  function matrixOf([p0, p1, p2, p3, d0, d1, d2, d3]) {
    const s = 2 / (p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3);
    return [
      1 - s * (p2 * p2 + p3 * p3), s * (p1 * p2 + p0 * p3), s * (p1 * p3 - p0 * p2), 0,
      s * (p1 * p2 - p0 * p3), 1 - s * (p1 * p1 + p3 * p3), s * (p2 * p3 + p0 * p1), 0,
      s * (p1 * p3 + p0 * p2), s * (p2 * p3 - p0 * p1), 1 - s * (p1 * p1 + p2 * p2), 0,
      s * (p0 * d1 - d0 * p1 + p2 * d3 - p3 * d2),
      s * (p0 * d2 - d0 * p2 + p3 * d1 - p1 * d3),
      s * (p0 * d3 - d0 * p3 + p1 * d2 - p2 * d1), 1,
    ];
  }

  const STILL = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const bodyMatrix = (number, body) => {
    const track = cells[number].tracks[body];
    return track ? matrixOf(blend(track, state.frame)) : STILL;
  };

  // ---- time -------------------------------------------------------------------------------------------------

  const state = {
    ready: false,
    playing: false,
    frame: 0,
    frames,
    play() {
      state.playing = frames > 1;
      showPlaying();
      wake();
    },
    pause() {
      state.playing = false;
      showPlaying();
    },
    seek(n) {
      state.frame = Math.min(Math.max(n, 0), frames);
      lingering = 0;
      draw();
    },
    matrix: (body, cell = 0) => bodyMatrix(cell, body),
    view: () => direction(),
  };
  window.kinlib = state;
  const explorer = recording.explorer && window.explore(recording, {
    state,
    draw: () => (state.ready ? wake() : showTime()),
    frame: () => { if (renderer && !touched) frameHulls(); },
  });

  let last = 0; // when time was last looked at
  let lingering = 0; // how long the motion still waits where it is
  let waiting = false; // whether a tick is on its way

  function advance(elapsed) {
    if (lingering > 0) {
      lingering -= elapsed;
      return;
    }
    const step = (frames / recording.seconds) * (elapsed / 1000);
    const stop = lights.map(([, frame]) => frame || frames)
      .find((frame) => frame > state.frame && frame <= state.frame + step);
    state.frame = stop === undefined ? (state.frame + step) % frames : stop % frames;
    if (stop !== undefined) lingering = LINGER;
  }

  function tick(now) {
    waiting = false;
    if (!state.ready) return;
    if (state.playing) {
      advance(Math.min(Math.max(now - last, 0), 100));
      wake();
    }
    last = now;
    draw();
  }

  function wake() {
    if (waiting || !state.ready) return;
    waiting = true;
    requestAnimationFrame(tick);
  }

  function showPlaying() {
    toggle.innerHTML = state.playing ? PAUSE : PLAY;
    toggle.setAttribute("aria-label", state.playing ? "Pause" : "Play");
    toggle.title = state.playing ? "Pause" : "Play";
  }

  const distance = (frame) => Math.abs(((state.frame - frame + 1.5 * frames) % frames) - frames / 2);
  const glow = (frame) => Math.max(0, 1 - distance(frame) / GLOW);

  function showTime() {
    const frame = Math.round(state.frame) % frames;
    const lit = lights.find((light) => distance(light[1]) < 0.5);
    const text = (captions[frame] || `${frame + 1} / ${frames}`) + (lit && lit[2] ? ` · ${lit[2]}` : "");
    slider.value = frame;
    slider.setAttribute("aria-valuetext", text);
    readout.textContent = text;
  }

  // ---- the view ---------------------------------------------------------------------------------------------

  let viewer = null; // meshcat's, made when the scene is first seen
  let renderer = null; // holds a WebGL context, of which a browser gives only a few
  let lens = null; // the camera that draws a cell
  let fits = []; // where every cell is looked at, and how large it is
  let touched = false; // whether the reader has turned the view

  function makeRenderer() {
    const canvas = document.createElement("canvas");
    const wishes = { alpha: true, antialias: true, powerPreference: "low-power" };
    const context = canvas.getContext("webgl2", wishes) || canvas.getContext("webgl", wishes);
    if (!context) return null;
    const made = new MeshCat.THREE.WebGLRenderer({ canvas, context, ...wishes });
    made.setPixelRatio(Math.min(devicePixelRatio, 2));
    made.autoClear = false;
    stage.prepend(canvas);
    return made;
  }

  function build() {
    element("div", {}).append(stage); // so that meshcat's own panel stays outside the page
    viewer = new MeshCat.Viewer(stage, false, renderer);
    viewer.gui.domElement.remove();
    document.body.prepend(stage);
    const nothing = { addFolder: () => nothing }; // no entries in that panel either: they cost more than the scene
    viewer.scene_tree.folder = nothing;
    Object.getPrototypeOf(viewer.scene_tree).create_controls = () => {};
    viewer.set_3d_pane_size = fit;
    viewer.set_dirty = wake;
    for (const name of ["Background", "Grid", "Axes"]) viewer.set_property([name], "visible", false);
    for (const [name, intensity] of LIGHTS) viewer.set_property(["Lights", name, "<object>"], "intensity", intensity);
    cells.forEach(addCell);
    smooth();
    glaze();
    if (explorer) explorer.build(viewer.scene_tree.find(["cell0", "explorer"]).object);
    viewer.camera.fov = 30;
    lens = viewer.camera.clone();
    viewer.controls.addEventListener("start", () => { touched = true; });
    stage.style.touchAction = "pan-y"; // a finger that goes up or down scrolls the page
  }

  // Together they give a surface that faces the reader its own colour, the one that the legend shows.
  const LIGHTS = [["AmbientLight", 0.5], ["FillLight", 0.45], ["PointLightNegativeX", 0.1], ["PointLightPositiveX", 0.1]];

  const glazes = []; // what lets light through
  function smooth() {
    viewer.scene.traverse(({ geometry, material }) => {
      if (!geometry || !material) return;
      if (!geometry.attributes.normal) geometry.computeVertexNormals();
      if (!material.transparent) return;
      material.depthWrite = false;
      glazes.push([material, material.opacity]);
    });
  }

  // What is seen through needs more body in the dark.
  function glaze() {
    const more = document.documentElement.dataset.theme === "dark" ? 1.9 : 1;
    for (const [material, opacity] of glazes) material.opacity = Math.min(0.85, more * opacity);
    wake();
  }

  function addCell(cell, number) {
    for (const [path, geometry, material, ...rows] of cell.objects) {
      const place = [`cell${number}`, ...path.split("/")];
      viewer.set_object_from_json(place, {
        geometries: [{ uuid: "shape", ...cell.geometries[geometry] }],
        materials: [{ uuid: "paint", ...cell.materials[material] }],
        object: { uuid: path, type: "Mesh", geometry: "shape", material: "paint" },
      });
      const column = (k) => [rows[k], rows[k + 4], rows[k + 8]];
      viewer.set_transform(place, [...column(0), 0, ...column(1), 0, ...column(2), 0, ...column(3), 1]);
    }
  }

  const node = (number, ...path) => viewer.scene_tree.find([`cell${number}`, ...path]);

  function columns() {
    const width = stage.clientWidth / stage.clientHeight;
    let best = 1;
    let size = 0;
    for (let n = 1; n <= cells.length; n++) {
      const side = Math.min(width / n, 1 / Math.ceil(cells.length / n));
      if (side > size * 1.001) [best, size] = [n, side];
    }
    return best;
  }

  // The rectangle of every cell in the stage, from its upper left corner.
  function rectangles() {
    const across = columns();
    const width = stage.clientWidth / across;
    const height = stage.clientHeight / Math.ceil(cells.length / across);
    return cells.map((_, k) => ({ x: (k % across) * width, y: Math.floor(k / across) * height, width, height }));
  }

  const radians = (degrees) => degrees * Math.PI / 180;

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const UNIT = 10; // how far the reader's camera is from its target at first; every cell has a scale of its own

  // The camera looks from the recorded direction; each cell from just so far away that its whole hull is seen.
  function frameHulls() {
    const [azimuth, elevation] = recording.view.map(radians);
    const [{ width, height }] = rectangles();
    const up = 0.86 * Math.tan(radians(viewer.camera.fov / 2));
    const across = up * width / height;
    const flat = [Math.cos(azimuth), Math.sin(azimuth)];
    const back = [...flat.map((x) => Math.cos(elevation) * x), Math.sin(elevation)];
    const right = [-flat[1], flat[0], 0];
    const over = [...flat.map((x) => -Math.sin(elevation) * x), Math.cos(elevation)];
    fits = cells.map(({ hull }) => {
      const seen = hull.map((point) => [dot(point, right), dot(point, over), dot(point, back)]);
      const [x, farX] = middle(seen.map((point) => [point[0], point[2]]), across);
      const [y, farY] = middle(seen.map((point) => [point[1], point[2]]), up);
      const target = right.map((_, k) => x * right[k] + y * over[k]);
      return { target: toView(target), scale: Math.max(farX, farY) / UNIT };
    });
    viewer.controls.target.set(0, 0, 0);
    viewer.camera.position.copy(toView(back)).multiplyScalar(UNIT);
  }

  // meshcat's scenes have z upwards, its camera y.
  const toView = ([x, y, z]) => new MeshCat.THREE.Vector3(x, z, -y);

  // The reader's camera, moved to one of the cells.
  function aim({ target, scale }) {
    lens.position.copy(viewer.camera.position).multiplyScalar(scale).add(target);
    lens.quaternion.copy(viewer.camera.quaternion);
    lens.updateMatrixWorld();
  }

  // Where to look, and from how far, so that points (sideways, towards us) stay between two lines of a given slope.
  function middle(points, slope) {
    const high = Math.max(...points.map(([x, z]) => x + slope * z));
    const low = Math.min(...points.map(([x, z]) => x - slope * z));
    return [(high + low) / 2, (high - low) / (2 * slope)];
  }

  function direction() {
    if (!viewer) return recording.view;
    const { x, y, z } = viewer.camera.position.clone().sub(viewer.controls.target);
    return [Math.atan2(-z, x), Math.atan2(y, Math.hypot(x, z))].map((angle) => angle * 180 / Math.PI);
  }

  function fit() {
    if (!renderer) return;
    renderer.setSize(stage.clientWidth, stage.clientHeight);
    const [{ width, height }] = rectangles();
    lens.aspect = width / height;
    lens.updateProjectionMatrix();
    if (!touched) frameHulls();
    wake();
  }

  function place() {
    if (explorer) explorer.place();
    cells.forEach((cell, number) => {
      for (const body of Object.keys(cell.tracks)) node(number, body).set_transform(bodyMatrix(number, body));
      for (const [path, frame] of cell.lights) {
        const bright = glow(frame) > 0;
        node(number, ...path.split("/"), "on").object.visible = bright;
        node(number, ...path.split("/"), "off").object.visible = !bright;
      }
    });
  }

  function draw() {
    showTime();
    if (!state.ready) return;
    place();
    viewer.controls.update();
    const { x: ahead, y: above, z: aside } = viewer.camera.position;
    viewer.scene_tree.find(["Lights", "FillLight", "<object>"]).object.position.set(ahead, -aside, above);
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    const total = stage.clientHeight;
    const seen = rectangles();
    seen.forEach(({ x, y, width, height }, number) => {
      cells.forEach((_, other) => { node(other).object.visible = other === number; });
      aim(fits[number]);
      renderer.setViewport(x, total - y - height, width, height);
      renderer.setScissor(x, total - y - height, width, height);
      renderer.render(viewer.scene, lens);
      names[number].style.transform = `translate(${x}px, ${y}px)`;
      labels.filter((label) => label.number === number).forEach((label) => write(label, seen[number]));
    });
  }

  // From where arrows start to a name in the widest gap between them; they are given sideways and downwards.
  function between(arrows, tag) {
    const angles = arrows.map(([across, down]) => Math.atan2(down, across)).sort((a, b) => a - b);
    const gaps = angles.map((angle, n) => (n + 1 < angles.length ? angles[n + 1] : angles[0] + 2 * Math.PI) - angle);
    const widest = gaps.indexOf(Math.max(...gaps));
    const middle = angles[widest] + gaps[widest] / 2;
    return [(6 + tag.offsetWidth / 2) * Math.cos(middle), (4 + tag.offsetHeight / 2) * Math.sin(middle)];
  }

  function write({ tag, body, point, light, number, tips }, { x, y, width, height }) {
    const m = bodyMatrix(number, body);
    const onPaper = (p) => {
      const moved = [0, 1, 2].map((k) => m[k] * p[0] + m[k + 4] * p[1] + m[k + 8] * p[2] + m[k + 12]);
      const spot = toView(moved).project(lens);
      return [(spot.x + 1) / 2 * width, (1 - spot.y) / 2 * height];
    };
    const [across, down] = onPaper(point);
    const arrows = tips.map(onPaper).map(([u, v]) => [u - across, v - down]);
    const [right, below] = arrows.length ? between(arrows, tag) : [0, 0];
    const inside = (at, room, size) => Math.max(0, Math.min(at - size / 2, room - size));
    const left = x + inside(across + right, width, tag.offsetWidth);
    const top = y + inside(down + below, height, tag.offsetHeight);
    tag.style.transform = `translate(${left.toFixed(1)}px, ${top.toFixed(1)}px)`;
    tag.classList.toggle("lit", light !== null && glow(light) > 0);
  }

  // ---- coming and going -------------------------------------------------------------------------------------

  function loadBundle() {
    if (window.MeshCat) return Promise.resolve();
    return new Promise((resolve, reject) => {
      const script = element("script", { src: bundle }, document.head);
      script.onload = resolve;
      script.onerror = reject;
    });
  }

  let visible = false;
  let loading = null;

  async function enter() {
    loading = loading || loadBundle();
    try {
      await loading;
    } catch {
      say("The viewer that belongs to this page was not found.");
      return;
    }
    if (!visible || renderer) return;
    renderer = makeRenderer();
    if (!renderer) {
      say("This scene needs WebGL, which this browser does not offer.");
      return;
    }
    if (viewer) viewer.renderer = renderer;
    else build();
    state.ready = true;
    document.body.classList.add("drawn"); // what lies below, a still, is needed no more
    last = performance.now();
    fit();
    draw();
  }

  function leave() {
    if (!renderer) return;
    state.ready = false;
    const { domElement } = renderer;
    const release = renderer.getContext().getExtension("WEBGL_lose_context");
    renderer.dispose();
    if (release) release.loseContext();
    domElement.remove();
    renderer = null;
  }

  // ---- the reader -------------------------------------------------------------------------------------------

  const turn = { ArrowLeft: [-8, 0], ArrowRight: [8, 0], ArrowUp: [0, 8], ArrowDown: [0, -8] };

  function turnView(event) {
    if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? 1 / 1.25 : 1.25);
    if (!viewer || !turn[event.key]) return;
    event.preventDefault();
    touched = true;
    const [sideways, up] = turn[event.key].map(radians);
    const { THREE } = MeshCat;
    const arm = viewer.camera.position.clone().sub(viewer.controls.target);
    const spherical = new THREE.Spherical().setFromVector3(arm);
    spherical.theta += sideways;
    spherical.phi = Math.min(Math.max(spherical.phi - up, 0.05), Math.PI - 0.05);
    viewer.camera.position.copy(viewer.controls.target).add(arm.setFromSpherical(spherical));
    wake();
  }

  function zoom(factor) {
    if (!viewer) return;
    touched = true;
    const { position } = viewer.camera;
    position.sub(viewer.controls.target).multiplyScalar(factor).add(viewer.controls.target);
    wake();
  }

  function listen() {
    nearer.addEventListener("click", () => zoom(1 / 1.25));
    farther.addEventListener("click", () => zoom(1.25));
    full.addEventListener("click", () => {
      if (document.fullscreenElement) document.exitFullscreen();
      else document.documentElement.requestFullscreen();
    });
    toggle.addEventListener("click", () => (state.playing ? state.pause() : state.play()));
    slider.addEventListener("input", () => {
      state.pause();
      state.seek(Number(slider.value));
    });
    home.addEventListener("click", () => {
      touched = false;
      fit();
    });
    stage.addEventListener("keydown", turnView);
    // The wheel scrolls the page; with the control key, or in a page of its own, it comes nearer.
    stage.addEventListener("wheel", (event) => {
      if (window.parent !== window && !event.ctrlKey && !event.metaKey) event.stopImmediatePropagation();
    }, { capture: true, passive: true });
    // Until the browser knows that a finger scrolls the page, the view has turned with it.
    let before = null;
    stage.addEventListener("pointerdown", () => { before = viewer && viewer.camera.position.clone(); }, { capture: true });
    stage.addEventListener("pointercancel", () => {
      if (before) viewer.camera.position.copy(before);
      wake();
    });
    new ResizeObserver(fit).observe(stage);
    new IntersectionObserver((entries) => {
      visible = entries[entries.length - 1].isIntersecting;
      if (visible) enter();
      else leave();
    }).observe(stage);
  }

  document.documentElement.classList.toggle("framed", window.parent !== window);
  theme();
  listen();
  state.playing = frames > 1 && !calm;
  showPlaying();
  showTime();
})();
