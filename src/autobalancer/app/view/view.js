// One view for the page and for notebooks: scene, polar races, orbit and waveforms, all at one time.
import { unpack } from "./unpack.js";
import { createScene, scaleOf } from "./scene.js";
import { createWaves } from "./waves.js";
import { createOrbit, createPolar } from "./flat.js";

const STYLE = `
.abv { --line: #dfe3e6; display: grid; gap: 8px; grid-template-columns: minmax(320px, 5fr) minmax(340px, 6fr); font: 13px system-ui, sans-serif; width: 100%; }
.abv canvas { display: block; width: 100%; touch-action: none; }
.abv-scene { height: 340px; border-radius: 4px; cursor: grab; }
.abv-flat { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; } .abv-flat canvas { height: 220px; }
.abv-wave { height: 132px; cursor: crosshair; } .abv-wave:last-child { height: 156px; }
.abv-tools { grid-column: 1 / -1; display: flex; flex-wrap: wrap; gap: 6px 10px; align-items: center; }
.abv-tools button, .abv-tools select { font: inherit; color: inherit; background: transparent; border: 1px solid var(--line, #999); border-radius: 4px; padding: 3px 9px; min-height: 30px; }
.abv-tools select option { color: #222; }
.abv-tools input[type=range] { flex: 1 1 120px; accent-color: #0072B2; }
.abv-time { min-width: 130px; font-variant-numeric: tabular-nums; }
.abv.dark { --line: #59626b; }
@media (max-width: 820px) { .abv { grid-template-columns: 1fr; } }`;
export const LIGHT = { ink: "#222222", soft: "#5b6570", grid: "#e3e3e3", line: "#8a949c", card: "#ffffff", accent: "#D55E00", shade: (c) => c };
const BRIGHT = { "#222222": "#e6e8ea", "#0072B2": "#56B4E9", "#5B6B7A": "#a3b3c2", "#8A7A1F": "#c9b84a" };
export const DARK = { ink: "#e6e8ea", soft: "#a3abb3", grid: "#343a40", line: "#8a949c", card: "#1f2327", accent: "#ff9a52", shade: (c) => BRIGHT[c] || c };

// `lib` has three.js, or promises it: the waveforms do not wait for it.
export function createView(root, buffer, lib, dark = false) {
  const run = unpack(buffer);
  const { head, arrays } = run;
  const first = arrays.time[0];
  const last = arrays.time[arrays.time.length - 1];
  let shaded = dark;
  const colors = () => (shaded ? DARK : LIGHT);
  root.innerHTML = "";
  const make = (tag, parent, attributes = {}) => {
    const one = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    parent.appendChild(one);
    return one;
  };
  make("style", root).textContent = STYLE;
  const box = make("div", root, { class: `abv${dark ? " dark" : ""}` });
  const tools = make("div", box, { class: "abv-tools" });
  const left = make("div", box);
  const right = make("div", box);
  const room = make("div", left, { class: "abv-scene" });
  let scene = null;
  const flats = [];
  if (head.kind === "races") {
    const sides = [[createPolar, "Balls in their races"], [createOrbit, "Orbit of the rotor"]];
    head.planes.forEach((_, plane) => {
      const row = make("div", left, { class: "abv-flat" });
      const name = head.names?.[plane] ? `: ${head.names[plane]}` : "";
      for (const [create, label] of head.balls.length ? sides : sides.slice(1)) {
        flats.push(create(make("canvas", row, { role: "img", "aria-label": label + name }), run, colors, plane));
      }
    });
  }
  const state = { t: first, playing: false, before: 0 };
  const waves = createWaves(right, run, colors, (t) => go(t));

  const play = make("button", tools, { type: "button", "aria-label": "play" });
  play.textContent = "▶ play";
  const slider = make("input", tools, { type: "range", min: "0", max: "2000", value: "0", "aria-label": "time" });
  const text = make("span", tools, { class: "abv-time", "aria-live": "off" });
  const choice = (label, options, act) => {
    const select = make("select", tools, { "aria-label": label });
    for (const [value, name] of options) make("option", select, { value }).textContent = name;
    select.addEventListener("change", () => act(select.value));
    return select;
  };
  const rates = [0.001, 0.01, 0.1, 1, 10].map((rate) => [String(rate), `${rate} × time`]);
  const span = last - first;
  const usual = rates.map(([value]) => +value).filter((rate) => span / rate >= 8);
  const pace = choice("pace", rates, () => {});
  pace.value = String(usual.length ? Math.max(...usual) : 0.001);
  const seen = [["rotor", "seen from the rotor"], ["space", "seen from the ground"]];
  const frame = choice("frame", seen, (value) => scene?.set("frame", value));
  const cameras = [["oblique", "oblique"], ["end", "from the end"], ["side", "from the side"]];
  const camera = choice("camera", cameras, (value) => scene?.look(value));
  const usualScale = scaleOf(run);
  const scales = [...new Set([1, 10, 100, 1000, usualScale])].sort((a, b) => a - b);
  const scale = choice("deflection", scales.map((s) => [String(s), `deflection × ${s}`]), (value) => scene?.set("scale", +value));
  scale.value = String(usualScale);
  for (const [name, label, act] of [
    ["+", "zoom in", () => waves.zoom(0.5, state.t)],
    ["−", "zoom out", () => waves.zoom(2, state.t)],
    ["whole run", "show the whole run", () => waves.whole()],
  ]) {
    const button = make("button", tools, { type: "button", "aria-label": label });
    button.textContent = name;
    button.addEventListener("click", act);
  }

  function go(t) {
    state.t = Math.min(Math.max(t, first), last);
    slider.value = String(Math.round((2000 * (state.t - first)) / span));
    const speed = arrays.speed[Math.min(arrays.speed.length - 1, Math.round(((state.t - first) / span) * (arrays.speed.length - 1)))];
    text.textContent = `${state.t.toFixed(3)} s   ${((speed * 30) / Math.PI).toFixed(0)} rpm`;
    scene?.show(state.t);
    flats.forEach((one) => one(state.t));
    waves.show(state.t);
  }
  slider.addEventListener("input", () => go(first + (span * +slider.value) / 2000));
  const frames = { count: 0, since: 0, rate: 0 };
  function turn(stamp) {
    if (!state.playing) return;
    const passed = state.before ? (stamp - state.before) / 1000 : 0;
    state.before = stamp;
    frames.count += 1;
    if (stamp - frames.since > 1000) {
      frames.rate = (1000 * frames.count) / (stamp - frames.since);
      frames.count = 0;
      frames.since = stamp;
      box.dataset.rate = frames.rate.toFixed(1);
    }
    const next = state.t + passed * +pace.value;
    go(next > last ? first : next);
    requestAnimationFrame(turn);
  }
  play.addEventListener("click", () => {
    state.playing = !state.playing;
    state.before = 0;
    play.textContent = state.playing ? "❚❚ stop" : "▶ play";
    play.setAttribute("aria-label", state.playing ? "stop" : "play");
    if (state.playing) requestAnimationFrame(turn);
  });
  const watcher = new ResizeObserver(() => go(state.t));
  watcher.observe(box);
  go(first);
  let gone = false;
  const begin = (loaded) => {
    if (gone) return;
    try {
      scene = createScene(left, run, loaded, colors);
      room.remove();
      for (const [key, value] of [["frame", frame.value], ["scale", +scale.value]]) scene.state[key] = value;
      scene.look(camera.value);
      scene.show(state.t);
    } catch (reason) {
      room.textContent = `There is no picture in three dimensions: ${reason.message}`;
    }
    box.dataset.ready = "yes";
  };
  // The second frame begins when the first one, with the waveforms, is on its way to the screen.
  const painted = new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(then))));
  painted.then(() => lib).then(begin, (reason) => (room.textContent = `three.js could not be loaded: ${reason.message}`));
  return {
    go,
    run,
    shade: (value) => {
      shaded = value;
      box.classList.toggle("dark", value);
      go(state.t);
    },
    destroy: () => {
      gone = true;
      state.playing = false;
      watcher.disconnect();
      scene?.destroy();
      root.innerHTML = "";
    },
  };
}
