// Rotor and balls in three dimensions. Balls are instances of one mesh, so a thousand of them are one drawing.
import { stateAt } from "./unpack.js";

let spare = null; // the renderer of a view that is gone: a browser has few, and a new one compiles everything anew

function rendererOf(THREE) {
  if (spare?.getContext().isContextLost()) spare = null;
  const found = spare || new THREE.WebGLRenderer({ canvas: document.createElement("canvas"), antialias: true, preserveDrawingBuffer: true });
  spare = null;
  return found;
}

function giveBack(renderer) {
  if (!spare) {
    spare = renderer;
    return;
  }
  renderer.dispose();
  renderer.forceContextLoss();
}

function extentOf({ head }) {
  const ends = head.bodies.flatMap(([from, to]) => [from, to]);
  const reach = head.kind === "chambers" ? [head.reach] : head.balls.map((one) => one.orbit);
  const widest = Math.max(...head.bodies.map((one) => one[2]), ...reach);
  return { ends, widest, size: Math.max(widest, 0.5 * (Math.max(...ends) - Math.min(...ends))) };
}

// The power of ten by which deflections are magnified, so that they are seen.
export function scaleOf(run) {
  const { head, arrays } = run;
  let most = 0;
  const moves = head.kind === "chambers" ? [arrays.moved] : [arrays.re, arrays.im];
  for (const values of moves) for (const value of values) most = Math.max(most, Math.abs(value));
  return most > 0 ? Math.max(10 ** Math.floor(Math.log10((0.14 * extentOf(run).size) / most)), 1) : 1;
}

export function createScene(root, run, lib, colors) {
  const { THREE, OrbitControls } = lib;
  const { head, arrays } = run;
  const renderer = rendererOf(THREE);
  const canvas = renderer.domElement;
  canvas.className = "abv-scene";
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `Rotor and balls of ${head.name} in three dimensions`);
  root.prepend(canvas);
  const scene = new THREE.Scene();
  const chambers = head.kind === "chambers";
  const { ends, widest, size } = extentOf(run);
  const middle = 0.5 * (Math.min(...ends) + Math.max(...ends));
  const unit = 1 / size; // the scene is about one unit large
  const camera = new THREE.PerspectiveCamera(32, 1, 0.05, 60);
  camera.position.set(2.1, 1.35, 3.7);
  const controls = new OrbitControls(camera, canvas);
  controls.target.set(0, 0, 0);
  controls.update();
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8a949c, 1.6));
  const sun = new THREE.DirectionalLight(0xffffff, 2.0);
  sun.position.set(2, 4, 5);
  scene.add(sun);
  const world = new THREE.Group(); // holds what turns; its middle is that of the machine
  const turning = new THREE.Group();
  const bent = new THREE.Group();
  world.position.z = -middle * unit;
  turning.add(bent);
  world.add(turning);
  scene.add(world);
  const still = new THREE.Group();
  still.position.z = -middle * unit;
  scene.add(still);

  const glass = (color, opacity) =>
    new THREE.MeshStandardMaterial({ color, transparent: true, opacity, depthWrite: false, side: THREE.DoubleSide, roughness: 0.6 });
  for (const [from, to, radius, bore, turns] of head.bodies) {
    const geometry = new THREE.CylinderGeometry(radius * unit, radius * unit, Math.max(to - from, 1e-3 * size) * unit, 64, 1, bore > 0);
    geometry.rotateX(Math.PI / 2);
    const body = new THREE.Mesh(geometry, glass(0x8a949c, bore > 0 || chambers ? 0.16 : 0.24));
    body.position.z = 0.5 * (from + to) * unit;
    const rims = new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 30), new THREE.LineBasicMaterial({ color: 0x6b757d }));
    body.add(rims);
    (turns ? bent : still).add(body);
  }
  const axis = new THREE.BufferGeometry().setFromPoints(
    [Math.min(...ends) - 0.25 * size, Math.max(...ends) + 0.25 * size].map((z) => new THREE.Vector3(0, 0, z * unit)),
  );
  still.add(new THREE.Line(axis, new THREE.LineBasicMaterial({ color: 0x9aa3aa })));
  for (const [place, radius] of head.springs) {
    const points = [];
    for (let k = 0; k <= 60; k++) {
      const up = -radius * unit - 0.45 * (k / 60);
      points.push(new THREE.Vector3(0.05 * Math.sin((k / 60) * 12 * Math.PI), up, place * unit + 0.05 * Math.cos((k / 60) * 12 * Math.PI)));
    }
    still.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color: 0x4a5a78 })));
  }

  const count = chambers ? arrays.radius.length : head.balls.length;
  const fine = count > 60 ? [10, 8] : [28, 20];
  const balls = new THREE.InstancedMesh(
    new THREE.SphereGeometry(1, ...fine),
    new THREE.MeshStandardMaterial({ roughness: 0.35, metalness: 0.15 }),
    Math.max(count, 1),
  );
  balls.count = count;
  balls.frustumCulled = false;
  bent.add(balls);
  const tint = new THREE.Color();
  if (chambers) {
    balls.removeFromParent();
    still.add(balls); // their places are given in space
    for (let k = 0; k < count; k++) balls.setColorAt(k, tint.set("#0072B2"));
  } else {
    const rings = new Set();
    head.balls.forEach((ball, k) => {
      balls.setColorAt(k, tint.set(ball.color));
      const key = [ball.orbit, ball.z, ...ball.center].join();
      if (rings.has(key)) return;
      rings.add(key);
      for (const radius of [ball.orbit - ball.radius, ball.orbit + ball.radius]) {
        const points = new THREE.EllipseCurve(ball.center[0] * unit, ball.center[1] * unit, radius * unit, radius * unit).getPoints(128);
        const ring = new THREE.LineLoop(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color: 0x6b757d }));
        ring.position.z = ball.z * unit;
        bent.add(ring);
      }
    });
  }
  const rim = chambers ? head.reach : Math.max(...head.balls.map((one) => one.orbit + 1.6 * one.radius), 0.2 * widest);
  const mark = new THREE.Mesh(new THREE.BoxGeometry(0.1, 0.025, 0.025), new THREE.MeshBasicMaterial({ color: 0x222222 }));
  mark.position.set(rim * unit + 0.05, 0, (chambers ? head.chambers[0] : (head.planes[0] ?? 0)) * unit);
  bent.add(mark);
  const columns = chambers ? 0 : arrays.heavy_re.length / arrays.time.length;
  const arrows = (head.planes || []).slice(0, columns).map((z) => {
    const arrow = new THREE.ArrowHelper(new THREE.Vector3(1, 0, 0), new THREE.Vector3(), 0.5 * rim * unit, 0xd55e00, 0.12, 0.07);
    arrow.position.z = (columns > 1 ? z : middle) * unit;
    bent.add(arrow);
    return arrow;
  });

  const state = { frame: "rotor", scale: scaleOf(run), time: arrays.time[0] };
  const matrix = new THREE.Matrix4();

  function place(k, x, y, z, radius) {
    matrix.makeScale(radius, radius, radius);
    matrix.setPosition(x, y, z);
    balls.setMatrixAt(k, matrix);
  }

  function show(t) {
    state.time = t;
    const at = stateAt(run, t);
    turning.rotation.z = state.frame === "space" ? at.angle % (2 * Math.PI) : 0;
    if (chambers) showChamber(at);
    else showRaces(at);
    balls.instanceMatrix.needsUpdate = true;
    mark.material.color.set(colors().ink);
    draw();
  }

  function showRaces(at) {
    const far = head.planes.length - 1;
    const z = head.planes;
    const [a, b] = [at.planes[0], at.planes[far]];
    const span = far > 0 ? z[far] - z[0] : 1;
    const slope = far > 0 ? [(b[0] - a[0]) / span, (b[1] - a[1]) / span] : [0, 0];
    bent.rotation.set(Math.atan(-slope[1] * state.scale), Math.atan(slope[0] * state.scale), 0);
    bent.position.set((a[0] - slope[0] * z[0]) * state.scale * unit, (a[1] - slope[1] * z[0]) * state.scale * unit, 0);
    head.balls.forEach((ball, k) => {
      const r = ball.orbit - at.inside[k];
      const x = ball.center[0] + r * Math.cos(at.balls[k]);
      const y = ball.center[1] + r * Math.sin(at.balls[k]);
      place(k, x * unit, y * unit, ball.z * unit, ball.radius * unit);
    });
    arrows.forEach((arrow, p) => {
      const heavy = Math.hypot(...at.heavy[p]);
      arrow.visible = heavy > 0;
      if (heavy > 0) arrow.setDirection(new THREE.Vector3(at.heavy[p][0] / heavy, at.heavy[p][1] / heavy, 0));
    });
  }

  function showChamber(at) {
    const turn = state.frame === "space" ? 0 : -at.angle;
    const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
    const moved = [1, 2].map((n) => {
      const from = arrays.moved[3 * at.index + n];
      return (from + at.share * (arrays.moved[3 * (at.index + 1) + n] - from)) * state.scale;
    });
    const shift = [cos * moved[0] - sin * moved[1], sin * moved[0] + cos * moved[1]];
    bent.position.set(shift[0] * unit, shift[1] * unit, 0);
    const scale = head.reach / 32000;
    const next = 3 * count;
    for (let k = 0; k < count; k++) {
      const from = 3 * (at.index * count + k);
      const [x, y, z] = [0, 1, 2].map((n) => scale * (arrays.place[from + n] + at.share * (arrays.place[from + next + n] - arrays.place[from + n])));
      const along = (x + head.chambers[arrays.chamber[k]]) * unit;
      place(k, (cos * y - sin * z + shift[0]) * unit, (sin * y + cos * z + shift[1]) * unit, along, arrays.radius[k] * unit);
    }
  }

  function draw() {
    const wide = canvas.clientWidth;
    const high = canvas.clientHeight;
    if (!wide || !high) return;
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(wide, high, false);
    camera.aspect = wide / high;
    camera.updateProjectionMatrix();
    renderer.setClearColor(colors().card, 1);
    still.children.forEach((one) => one !== balls && one.isLine && one.geometry !== axis && (one.visible = state.frame === "space"));
    renderer.render(scene, camera);
  }
  controls.addEventListener("change", draw);

  const looks = { oblique: [2.1, 1.35, 3.7], end: [0, 0, 4.3], side: [4.3, 0.4, 0] };
  function look(name) {
    camera.position.set(...looks[name]);
    controls.update();
    draw();
  }
  function destroy() {
    controls.dispose();
    scene.traverse((one) => one.geometry?.dispose());
    balls.dispose();
    canvas.remove();
    giveBack(renderer);
  }
  return { show, draw, look, destroy, state, set: (key, value) => ((state[key] = value), show(state.time)), canvas };
}
