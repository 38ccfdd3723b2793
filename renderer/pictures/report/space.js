// The rooms in three dimensions: patches in the colours of the scale, to turn and to read.

const HALF_ANGLE = 0.33;  // rad, of what is seen across the shorter side
const space = startSpace();

function startSpace() {
  const box = $("view3d");
  try {
    THREE.ColorManagement.enabled = false;  // the colours are those of the scale, not lit surfaces
    const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    renderer.setScissorTest(true);
    renderer.autoClear = false;
    box.append(renderer.domElement);
    const camera = new THREE.PerspectiveCamera(38, 1, 0.05, 50);
    camera.up.set(0, 0, 1);
    const far = Math.max(...geometries.map(g => g.reach)) / Math.sin(HALF_ANGLE);
    camera.position.set(0.36, -0.78, 0.51).multiplyScalar(far);
    const controls = new THREE.OrbitControls(camera, renderer.domElement);
    controls.addEventListener("change", () => drawSpace());
    controls.enablePan = false;
    controls.minDistance = 0.3; controls.maxDistance = 12;
    const marks = element("div", {className: "marks"});
    box.append(marks);
    return {box, renderer, camera, controls, marks, scenes: rooms.map(roomInSpace)};
  } catch (problem) {
    box.replaceChildren(element("p", {textContent: `This browser does not draw in three dimensions (${problem.message}).`}));
    box.style.height = "auto";
    return null;
  }
}

// A room in units of its longest side, about its middle: each patch as finely as its direct light is known.
function roomInSpace(room) {
  const g = room.geometry, scene = new THREE.Scene(), n = g.fine.steps;
  const all = Array.from(g.surface.keys()).filter(p => g.shown[p]);
  const quads = all.filter(p => !frame(g, p).triangular), triangles = all.filter(p => frame(g, p).triangular);
  const positions = [], points = [], faces = [], patchOf = [];
  const push = (p, s, t) => {
    positions.push(...point(frame(g, p), s, t).map(x => x / g.scale));
    points.push({p, s, t});
  };
  for (const p of quads) {
    const first = points.length, at = (i, j) => first + j * (n + 1) + i;
    for (let j = 0; j <= n; j++) for (let i = 0; i <= n; i++) push(p, i / n, j / n);
    for (let j = 0; j < n; j++) {
      for (let i = 0; i < n; i++) {
        faces.push(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1));
        patchOf.push(p, p);
      }
    }
  }
  for (const p of triangles) {
    faces.push(points.length, points.length + 1, points.length + 2);
    patchOf.push(p);
    push(p, 0, 0); push(p, 1, 0); push(p, 0, 1);
  }
  const shape = new THREE.BufferGeometry();
  shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(positions), 3));
  shape.setAttribute("color", new THREE.BufferAttribute(new Uint8Array(positions.length), 3, true));
  shape.setIndex(faces);
  const mesh = new THREE.Mesh(shape, new THREE.MeshBasicMaterial({vertexColors: true, toneMapped: false}));
  scene.add(mesh);
  const scaled = points => new THREE.BufferGeometry().setAttribute("position",
    new THREE.BufferAttribute(new Float32Array(points.flat().map(x => x / g.scale)), 3));
  for (const lamp of g.luminaires) {
    scene.add(lamp.outline
      ? new THREE.Mesh(scaled(lamp.outline.slice(2).flatMap((c, k) => [lamp.outline[0], lamp.outline[k + 1], c])),
                       new THREE.MeshBasicMaterial({color: 0xfffbe8, side: 2, toneMapped: false}))
      : new THREE.Points(scaled([lamp.center]),
                         new THREE.PointsMaterial({color: 0xfffbe8, size: 12, sizeAttenuation: false, depthTest: false})));
  }
  return {scene, mesh, patchOf, points};
}

// Rings and numbers where photometers and kept readings appear, in the k-th of several rooms side by side.
function marksInSpace(room, k, parts) {
  const g = room.geometry, kept = pins.filter(pin => pin.spots[room.index]);
  const at = [...room.photometers.map(p => [ring(), p.position]),
              ...kept.map(pin => [label(pin), pin.spots[room.index].position])];
  return at.flatMap(([item, position]) => {
    const p = new THREE.Vector3(...minus(position, g.middle).map(x => x / g.scale)).project(space.camera);
    return Math.abs(p.x) < 1 && Math.abs(p.y) < 1 ? [placed(item, (k + (p.x + 1) / 2) / parts, (1 - p.y) / 2)] : [];
  });
}

// What the scale shows, of each patch.
function patchValues(room, bands) {
  const g = room.geometry;
  const of = name => {
    const p = prepared(room, name), w = [0, 0, 0, 0], share = state.light === "total" ? 1 : 0;
    const shine = new Float64Array(g.surface.length);
    for (let k = 0; k < shine.length; k++) eachOf(g.shining, k, (j, x) => { shine[k] += x * p.lampLux[j]; });
    return Float64Array.from(g.surface, (surface, k) => {
      const f = frame(g, k), m = f.triangular ? 1 / 3 : 1 / 2;
      weightsAt(f, m, m, w);
      if (g.lamp[k]) return state.quantity === "illuminance" ? NaN : shine[k] / Math.PI;
      const lux = state.quantity === "illuminance";
      let value = 0;
      g.light.forEach((column, j) => { value += column[k] * (lux ? p.lampLux[j] : p.reflected[surface][j][1] / Math.PI); });
      verticesOf(g, k).forEach((v, c) => { value += share * w[c] * (lux ? p.lux[v] : p.xyz[3 * v + 1] / Math.PI); });
      return value;
    });
  };
  if (bands !== "difference") return of(bands);
  const rgb = of("rgb"), spectral = of("31");
  return rgb.map((x, k) => difference(x, spectral[k]));
}

// X, Y, Z [cd/m²] and lx of each point of a room in three dimensions; of luminaires what they send, and no lx.
function lightInSpace(room, name) {
  const g = room.geometry, p = prepared(room, name), {points} = space.scenes[room.index], w = [0, 0, 0, 0];
  const share = state.light === "total" ? 1 : 0, xyz = new Float64Array(3 * points.length), lux = new Float64Array(points.length);
  points.forEach(({p: patch, s, t}, i) => {
    if (g.lamp[patch]) {
      lux[i] = NaN;
      eachOf(g.shining, patch, (j, x) => { for (let k = 0; k < 3; k++) xyz[3 * i + k] += x * p.lampXyz[j][k] / Math.PI; });
      return;
    }
    g.fine.light.forEach((column, j) => {
      lux[i] += column[i] * p.lampLux[j];
      for (let k = 0; k < 3; k++) xyz[3 * i + k] += column[i] * p.reflected[g.surface[patch]][j][k] / Math.PI;
    });
    if (!share) return;
    weightsAt(frame(g, patch), s, t, w);
    for (let c = 0; c < 4; c++) {
      const v = g.patches[4 * patch + c];
      lux[i] += w[c] * p.lux[v];
      for (let k = 0; k < 3; k++) xyz[3 * i + k] += w[c] * p.xyz[3 * v + k] / Math.PI;
    }
  });
  return {xyz, lux};
}

// The colour of each point as its pane's picture would show it.
function coloursInSpace(pane) {
  const room = roomOf(pane), bands = bandsOf(pane), how = scaleOf(pane);
  if (scaleKey(pane) === null) {
    const {xyz} = lightInSpace(room, bands);
    return i => toned(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]);
  }
  const of = name => {
    const {xyz, lux} = lightInSpace(room, name);
    return state.quantity === "illuminance" ? lux : lux.map((_, i) => xyz[3 * i + 1]);
  };
  if (!how.signed) {
    const shown = of(bands);
    return i => scaleColour(shown[i], how);
  }
  const rgb = of("rgb"), spectral = of("31");
  return i => scaleColour(difference(rgb[i], spectral[i]), how);
}

function colourSpace() {
  if (!space || !$("space").open) return;
  for (const pane of shownPanes()) {
    const {points} = space.scenes[roomOf(pane).index], colourOf = coloursInSpace(pane);
    const colours = pane.colours = new Uint8Array(3 * points.length);
    points.forEach((_, i) => {
      const colour = colourOf(i);
      for (let k = 0; k < 3; k++) colours[3 * i + k] = colour[k] + 0.5;
    });
  }
  drawSpace();
}

function show(pane) {
  const {mesh} = space.scenes[roomOf(pane).index], colours = mesh.geometry.attributes.color;
  if (!pane.colours || colours.array.length !== pane.colours.length) return;
  colours.array.set(pane.colours);
  colours.needsUpdate = true;
}

function drawSpace() {
  if (!space || !$("space").open) return;
  const {box, renderer, camera, scenes} = space, shown = shownPanes();
  const width = box.clientWidth, height = box.clientHeight;
  if (!width) return;
  renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
  renderer.setSize(width, height);
  renderer.setClearColor(0x80868c);
  const marks = [];
  shown.forEach((pane, k) => {
    const room = roomOf(pane);
    show(pane);
    const part = width / shown.length;
    renderer.setViewport(k * part, 0, part, height);
    renderer.setScissor(k * part, 0, part - (k < shown.length - 1 ? 2 : 0), height);
    renderer.clear();
    camera.aspect = part / height;
    camera.fov = 2 * Math.atan(Math.tan(HALF_ANGLE) / Math.min(1, camera.aspect)) * 180 / Math.PI;
    camera.updateProjectionMatrix();
    renderer.render(scenes[room.index].scene, camera);
    marks.push(...marksInSpace(room, k, shown.length));
  });
  space.marks.replaceChildren(...marks);
}

function patchUnder(event) {
  const shown = shownPanes().map(roomOf), box = space.box.getBoundingClientRect(), part = box.width / shown.length;
  const x = event.clientX - box.left, k = Math.min(shown.length - 1, Math.max(0, Math.floor(x / part)));
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(2 * (x - k * part) / part - 1, 1 - 2 * (event.clientY - box.top) / box.height), space.camera);
  const {scene, mesh, patchOf} = space.scenes[shown[k].index];
  scene.updateMatrixWorld();
  const [hit] = ray.intersectObject(mesh);
  return hit ? {room: shown[k], patch: patchOf[hit.faceIndex]} : null;
}

function turn(azimuth, polar, nearer) {
  const {camera, controls} = space, p = camera.position, r = p.length() * nearer;
  const a = Math.atan2(p.y, p.x) + azimuth;
  const b = Math.min(1.56, Math.max(-1.56, Math.asin(p.z / p.length()) + polar));
  p.set(r * Math.cos(b) * Math.cos(a), r * Math.cos(b) * Math.sin(a), r * Math.sin(b));
  controls.update();
  drawSpace();
}

if (space) {
  let down = null;
  const surface = space.renderer.domElement;
  surface.addEventListener("pointerdown", event => { down = [event.clientX, event.clientY]; });
  surface.addEventListener("pointerup", event => {
    const moved = down === null || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4;
    down = null;
    const found = moved ? null : patchUnder(event);
    if (found) addPin(everywhere(found.room, atPatch(found.room, found.patch)), found.room.index);
  });
  space.box.addEventListener("keydown", event => {
    const move = {ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, 0.1, 1], ArrowDown: [0, -0.1, 1],
                  "+": [0, 0, 0.9], "-": [0, 0, 1.1]}[event.key];
    if (move) { event.preventDefault(); turn(...move); }
    if (event.key === "Enter") {
      const box = space.box.getBoundingClientRect(), part = box.width / shownPanes().length;
      const found = patchUnder({clientX: box.left + part / 2, clientY: box.top + box.height / 2});
      if (found) addPin(everywhere(found.room, atPatch(found.room, found.patch)), found.room.index);
    }
  });
  new ResizeObserver(() => drawSpace()).observe(space.box);
}
