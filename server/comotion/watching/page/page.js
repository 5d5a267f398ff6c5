// The live view: bodies moved by poses, rings at impacts. Text from a run is only ever set as text, never as HTML.
import * as three from "./three.module.min.js";

const COLOURS = { free: 0xf1f6fa, prescribed: 0x34404d, fixed: 0xaaa69d };
const RINGS = 96, LINGER = 0.8; // impacts seen at once, and for how long [s]
const TYPES = { "<f4": Float32Array, "<f8": Float64Array };
const element = (id) => document.getElementById(id);

const renderer = new three.WebGLRenderer({ antialias: true, alpha: true });
document.body.prepend(renderer.domElement);
const scene = new three.Scene();
const camera = new three.PerspectiveCamera(30, 1, 0.01, 1000);
camera.up.set(0, 0, 1);
const controls = new three.OrbitControls(camera, renderer.domElement);
scene.add(new three.HemisphereLight(0xffffff, 0x8fa3b3, 2.0));
const sun = new three.DirectionalLight(0xffffff, 1.6);
scene.add(sun, sun.target);

const view = { bodies: [], meshes: [], origin: [0, 0, 0], size: 1, mode: "", film: null, now: 0, playing: true, picked: -1 };
window.comotion = { states: 0, frames: 0, view }; // for tests: how much has come and been drawn

// Messages: 4 bytes of length, JSON, arrays at multiples of 8 (see page_message.py).
function read(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const { name, dtype, shape, offset } of header.arrays)
    arrays[name] = new TYPES[dtype](buffer, 4 + length + offset, shape.reduce((a, b) => a * b, 1));
  return { header, arrays };
}

const take = {
  scene(header, arrays) {
    Object.assign(view, { bodies: header.bodies, mode: header.mode, water: header.water, placed: false });
    const materials = Object.fromEntries(Object.entries(COLOURS).map(([kind, color]) =>
      [kind, new three.MeshLambertMaterial({ color, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 })]));
    const ink = new three.LineBasicMaterial({ color: 0x26323c, transparent: true, opacity: 0.6 });
    view.meshes = header.bodies.map((body) => {
      const part = (name, [first, count]) =>
        new three.BufferAttribute(arrays[name].subarray(3 * first, 3 * (first + count)), 3);
      const geometry = new three.BufferGeometry();
      geometry.setAttribute("position", part("corners", body.corners));
      geometry.setAttribute("normal", part("normals", body.corners));
      const mesh = new three.Mesh(geometry, materials[body.motion] ?? materials.free);
      const lines = new three.BufferGeometry();
      lines.setAttribute("position", part("edges", body.edges));
      mesh.add(new three.LineSegments(lines, ink));
      scene.add(mesh);
      return mesh;
    });
    document.title = `${header.title} - comotion`;
    element("title").textContent = header.title;
    element("player").hidden = header.mode !== "replay";
  },
  state(header, arrays) {
    if (!view.placed) view.origin = [0, 1, 2].map((axis) => Math.round(mean(arrays.poses, axis)));
    place(arrays.poses, arrays.scales, 0, view.origin);
    for (const hit of header.impacts) ring(hit, performance.now() / 1000);
    view.twists = arrays.twists;
    show({ time: `${header.time.toFixed(4)} s`, step: header.step, impacts: header.count });
    warn(header.blocked?.length ? `kept in place: ${header.blocked.slice(0, 6).join(", ")}` : "");
    window.comotion.states += 1;
  },
  film(header, arrays) {
    view.origin = header.origin;
    view.film = arrays;
    const time = element("time");
    [time.min, time.max] = [arrays.times[0], arrays.times.at(-1)];
    seek(arrays.times[0]);
    window.comotion.states += arrays.times.length;
  },
  progress(header) {
    show({ server: `${header.server}, ${header.phase}`, client: header.client ?? "none", busy: `${header.busy.toFixed(2)} s` });
  },
  gone() { warn("the server is gone"); },
};

function mean(poses, axis) {
  let sum = 0;
  for (let at = axis; at < poses.length; at += 7) sum += poses[at];
  return sum / Math.max(poses.length / 7, 1);
}

// Poses x y z w qx qy qz of a state in an array of them, about an origin that has been taken off or is now. Without
// scales all bodies are as large as their shapes.
function place(poses, scales, state, origin) {
  view.meshes.forEach((mesh, row) => {
    const body = state * view.bodies.length + row, at = 7 * body;
    mesh.scale.setScalar(scales ? scales[body] : 1);
    mesh.position.set(poses[at] - origin[0], poses[at + 1] - origin[1], poses[at + 2] - origin[2]);
    mesh.quaternion.set(poses[at + 4], poses[at + 5], poses[at + 6], poses[at + 3]);
  });
  if (!view.placed && view.meshes.length) look();
}

// Where a body is, or in a recorded run will ever be.
function* centres(mesh) {
  yield mesh.position;
  if (!view.film) return;
  const poses = view.film.poses, stride = 7 * view.bodies.length;
  for (let at = 7 * view.meshes.indexOf(mesh); at < poses.length; at += stride)
    yield new three.Vector3(poses[at], poses[at + 1], poses[at + 2]);
}

// The camera on what moves, once; the water around it.
function look() {
  view.placed = true;
  const low = new three.Vector3(1e9, 1e9, 1e9), high = low.clone().negate(), corner = new three.Vector3();
  const seen = view.meshes.filter((_, row) => view.bodies[row].motion !== "fixed");
  for (const mesh of seen.length ? seen : view.meshes) {
    const position = mesh.geometry.attributes.position;
    const least = new three.Vector3(), most = new three.Vector3(); // of the body, from its centre
    for (let i = 0; i < position.count; i++) {
      corner.fromBufferAttribute(position, i).applyQuaternion(mesh.quaternion);
      least.min(corner); most.max(corner);
    }
    for (const centre of centres(mesh)) {
      low.min(corner.copy(centre).add(least)); high.max(corner.copy(centre).add(most));
    }
  }
  const middle = low.clone().add(high).multiplyScalar(0.5);
  view.size = Math.max(high.distanceTo(low), 1e-6);
  controls.target.copy(middle);
  camera.position.copy(middle).add(new three.Vector3(-0.75, -1, 1).setLength(1.9 * view.size));
  camera.near = view.size / 200; camera.far = view.size * 100;
  camera.updateProjectionMatrix();
  sun.position.copy(middle).add(new three.Vector3(-0.8, -0.25, 1).multiplyScalar(view.size));
  sun.target.position.copy(middle);
  if (view.water !== null && view.water !== undefined) {
    const sheet = new three.Mesh(new three.PlaneGeometry(30 * view.size, 30 * view.size),
      new three.MeshBasicMaterial({ color: 0x3f86b5, transparent: true, opacity: 0.45,
        depthWrite: false, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 })); // as bodies are
    sheet.position.set(middle.x, middle.y, view.water - view.origin[2]);
    scene.add(sheet);
  }
}

// Rings: sprites of one size on the screen, reused in turn. An impact is time, x, y, z, impulse.
const rings = [];
const canvas = document.createElement("canvas");
canvas.width = canvas.height = 64;
const pen = canvas.getContext("2d");
pen.strokeStyle = "#e8541e"; pen.fillStyle = "#e8541e55"; pen.lineWidth = 6;
pen.arc(32, 32, 27, 0, 7); pen.fill(); pen.stroke();
const picture = new three.CanvasTexture(canvas);
picture.colorSpace = three.SRGBColorSpace;
let turn = 0, largest = 0;
for (let i = 0; i < RINGS; i++) {
  const sprite = new three.Sprite(new three.SpriteMaterial({ map: picture, depthTest: false, sizeAttenuation: false, transparent: true }));
  sprite.visible = false;
  rings.push({ sprite, born: -Infinity, scale: 0 });
  scene.add(sprite);
}
function ring([, x, y, z, impulse], born) {
  largest = Math.max(largest, impulse);
  const mark = rings[turn++ % RINGS];
  mark.sprite.position.set(x - view.origin[0], y - view.origin[1], z - view.origin[2]);
  Object.assign(mark, { born, scale: 0.01 + 0.022 * Math.sqrt(Math.max(impulse, 0) / (largest || 1)) });
}
function fade(now) {
  for (const { sprite, born, scale } of rings) {
    const age = (now - born) / LINGER;
    sprite.visible = age >= 0 && age < 1;
    if (sprite.visible) { sprite.scale.setScalar(scale * (1 + 0.8 * age)); sprite.material.opacity = 1 - age; }
  }
}

// Replaying: the state before a time, moved on to it.
function seek(now) {
  const { times, poses, scales, impacts } = view.film;
  let frame = 0;
  while (frame + 1 < times.length && times[frame + 1] <= now) frame++;
  const next = Math.min(frame + 1, times.length - 1);
  const part = next > frame ? Math.min(Math.max((now - times[frame]) / (times[next] - times[frame]), 0), 1) : 0;
  place(poses, scales, frame, [0, 0, 0]);
  view.meshes.forEach((mesh, row) => {
    const at = 7 * (next * view.bodies.length + row);
    mesh.position.lerp(new three.Vector3(poses[at], poses[at + 1], poses[at + 2]), part);
    mesh.quaternion.slerp(mesh.quaternion.clone().set(poses[at + 4], poses[at + 5], poses[at + 6], poses[at + 3]), part);
  });
  for (const mark of rings) mark.born = -Infinity;
  let count = 0;
  for (let at = 0; at < impacts.length && impacts[at] <= now; at += 5, count++)
    if (now - impacts[at] < LINGER * pace()) ring(impacts.subarray(at, at + 5), -(now - impacts[at]) / pace());
  view.now = now;
  element("time").value = now;
  show({ time: `${now.toFixed(3)} s`, impacts: count });
}
const pace = () => Number(element("pace").value);
function play(seconds) {
  if (!view.film) return;
  const last = view.film.times.at(-1);
  if (view.playing) seek(view.now + seconds * pace() > last ? view.film.times[0] : view.now + seconds * pace());
}
element("play").onclick = () => {
  view.playing = !view.playing;
  element("play").textContent = view.playing ? "Pause" : "Play";
};
element("time").oninput = (event) => { view.playing = false; element("play").textContent = "Play"; seek(Number(event.target.value)); };

const figures = new Map();
function show(values) {
  for (const [name, value] of Object.entries(values)) {
    if (!figures.has(name)) {
      const [term, told] = [document.createElement("dt"), document.createElement("dd")];
      term.textContent = name;
      element("figures").append(term, told);
      figures.set(name, told);
    }
    figures.get(name).textContent = value;
  }
}
function warn(text) { element("word").textContent = text; element("word").hidden = !text; }

// A click names the body under it.
const ray = new three.Raycaster();
let pressed = [0, 0];
renderer.domElement.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
renderer.domElement.addEventListener("pointerup", (event) => {
  if (Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return; // the view was turned
  ray.setFromCamera(new three.Vector2(2 * event.clientX / innerWidth - 1, 1 - 2 * event.clientY / innerHeight), camera);
  const hit = ray.intersectObjects(view.meshes, false)[0];
  view.picked = hit ? view.meshes.indexOf(hit.object) : -1;
});
function tell() {
  const body = view.bodies[view.picked], card = element("body");
  card.hidden = !body;
  if (!body) return;
  const at = view.meshes[view.picked].position.toArray().map((value, axis) => (value + view.origin[axis]).toFixed(3));
  const v = view.twists?.subarray(6 * view.picked, 6 * view.picked + 3);
  const speed = v ? `, ${Math.hypot(...v).toFixed(3)} m/s` : "";
  card.textContent = `${body.name}: ${body.motion}, at ${at.join(", ")} m${speed}`;
}

function resize() {
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener("resize", resize);
resize();
let before = performance.now();
renderer.setAnimationLoop((now) => {
  play(Math.min((now - before) / 1000, 0.1));
  before = now;
  fade(view.film ? 0 : performance.now() / 1000);
  controls.update();
  tell();
  renderer.render(scene, camera);
  window.comotion.frames += 1;
});

const feed = new WebSocket(`ws://${location.host}/feed`);
feed.binaryType = "arraybuffer";
feed.onmessage = (event) => { const { header, arrays } = read(event.data); take[header.kind]?.(header, arrays); };
feed.onclose = () => warn("the connection to comotion watch is closed");
