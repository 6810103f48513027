// Waveforms over time: wheel or buttons zoom, a drag moves the time, shift and a drag move the window.
import { indexAt } from "./unpack.js";

export function createWaves(root, run, colors, onTime) {
  const { head, arrays } = run;
  const first = arrays.time[0];
  const last = arrays.time[arrays.time.length - 1];
  let window_ = [first, last];
  let now = first;
  const panels = head.panels.map((panel) => {
    const canvas = document.createElement("canvas");
    canvas.className = "abv-wave";
    canvas.setAttribute("role", "img");
    const label = `${panel.title}${panel.unit ? ` in ${panel.unit}` : ""} over time`;
    canvas.setAttribute("aria-label", label);
    root.appendChild(canvas);
    return { panel, canvas };
  });
  const LEFT = 58;
  const RIGHT = 10;

  function limits(panel) {
    if (panel.limits) return panel.limits;
    let low = Infinity;
    let high = -Infinity;
    for (const line of panel.lines) {
      const t = arrays[line.t];
      const from = indexAt(t, window_[0]);
      const to = Math.min(indexAt(t, window_[1]) + 1, t.length - 1);
      for (const name of [line.high, line.low]) {
        if (!name) continue;
        for (let k = from; k <= to; k++) {
          const y = arrays[name][k];
          if (y < low) low = y;
          if (y > high) high = y;
        }
      }
    }
    if (!(high > low)) return [low - 1, low + 1];
    if (low > 0 && low < 0.6 * high) low = 0;
    const room = 0.06 * (high - low);
    return [low === 0 ? 0 : low - room, high + room];
  }

  function ticks(low, high, count) {
    const raw = (high - low) / count;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((m) => m >= raw);
    const found = [];
    for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-12) + 1e-300; k++) found.push(k * step);
    return found;
  }

  const words = (value) => (Math.abs(value) < 1e-12 ? "0" : String(+value.toPrecision(5)));

  function drawPanel({ panel, canvas }, isLast) {
    const wide = canvas.clientWidth;
    const high = canvas.clientHeight;
    if (!wide || !high) return;
    const ratio = window.devicePixelRatio || 1;
    if (canvas.width !== Math.round(wide * ratio)) canvas.width = Math.round(wide * ratio);
    if (canvas.height !== Math.round(high * ratio)) canvas.height = Math.round(high * ratio);
    const c = canvas.getContext("2d");
    const look = colors();
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, wide, high);
    c.font = "11px system-ui, sans-serif";
    const top = 20;
    const bottom = high - (isLast ? 30 : 8);
    const [low, most] = limits(panel);
    const x = (t) => LEFT + ((t - window_[0]) / (window_[1] - window_[0])) * (wide - LEFT - RIGHT);
    const y = (v) => bottom - ((v - low) / (most - low)) * (bottom - top);
    c.strokeStyle = look.grid;
    c.fillStyle = look.soft;
    c.lineWidth = 1;
    c.textAlign = "right";
    c.textBaseline = "middle";
    const marks = panel.limits ? [-180, -90, 0, 90, 180] : ticks(low, most, Math.max(2, (bottom - top) / 28));
    for (const value of marks) {
      c.beginPath();
      c.moveTo(LEFT, y(value));
      c.lineTo(wide - RIGHT, y(value));
      c.stroke();
      c.fillText(words(value), LEFT - 6, y(value));
    }
    c.textAlign = "center";
    c.textBaseline = "top";
    for (const value of ticks(window_[0], window_[1], wide / 90)) {
      c.beginPath();
      c.moveTo(x(value), top);
      c.lineTo(x(value), bottom);
      c.stroke();
      if (isLast) c.fillText(words(value), x(value), bottom + 4);
    }
    if (isLast) c.fillText("time (s)", 0.5 * (LEFT + wide), bottom + 16);
    c.save();
    c.beginPath();
    c.rect(LEFT, top - 1, wide - LEFT - RIGHT, bottom - top + 2);
    c.clip();
    for (const line of panel.lines) drawLine(c, panel, line, x, y, look);
    c.strokeStyle = look.accent;
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(x(now), top);
    c.lineTo(x(now), bottom);
    c.stroke();
    c.restore();
    c.textAlign = "left";
    c.textBaseline = "alphabetic";
    c.fillStyle = look.ink;
    c.font = "600 11.5px system-ui, sans-serif";
    const title = `${panel.title}${panel.unit ? ` (${panel.unit})` : ""}`;
    c.fillText(title, LEFT, 13);
    let at = LEFT + c.measureText(title).width + 14;
    c.font = "11px system-ui, sans-serif";
    for (const line of panel.lines) {
      const t = arrays[line.t];
      const value = arrays[line.high][Math.min(indexAt(t, now), t.length - 1)];
      const text = `${line.name} ${words(+value.toPrecision(4))}`;
      if (at + c.measureText(text).width + 16 > wide) break;
      c.fillStyle = look.shade(line.color);
      c.fillRect(at, 8, 12, 3);
      c.fillText(text, at + 16, 13);
      at += c.measureText(text).width + 30;
    }
  }

  function drawLine(c, panel, line, x, y, look) {
    const t = arrays[line.t];
    const v = arrays[line.high];
    const from = indexAt(t, window_[0]);
    const to = Math.min(indexAt(t, window_[1]) + 1, t.length - 1);
    c.strokeStyle = c.fillStyle = look.shade(line.color);
    c.lineWidth = 1.3;
    c.beginPath();
    if (line.low) {
      const l = arrays[line.low];
      for (let k = from; k <= to; k++) c.lineTo(x(t[k]), y(v[k]));
      for (let k = to; k >= from; k--) c.lineTo(x(t[k]), y(l[k]));
      c.globalAlpha = 0.55;
      c.fill();
      c.globalAlpha = 1;
      c.stroke();
      return;
    }
    for (let k = from; k <= to; k++) {
      const jump = panel.limits && k > from && Math.abs(v[k] - v[k - 1]) > 180;
      if (k === from || jump) c.moveTo(x(t[k]), y(v[k]));
      else c.lineTo(x(t[k]), y(v[k]));
    }
    c.stroke();
  }

  function draw() {
    panels.forEach((one, k) => drawPanel(one, k === panels.length - 1));
  }

  function show(t) {
    now = t;
    draw();
  }

  function zoom(factor, about = now) {
    const span = Math.min(Math.max((window_[1] - window_[0]) * factor, 1e-6 * (last - first)), last - first);
    const share = (about - window_[0]) / (window_[1] - window_[0]);
    const from = Math.min(Math.max(about - share * span, first), last - span);
    window_ = [from, from + span];
    draw();
  }

  const timeOf = (event, canvas) => {
    const box = canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
    return window_[0] + Math.min(Math.max(share, 0), 1) * (window_[1] - window_[0]);
  };
  for (const { canvas } of panels) {
    let held = null;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(event.deltaY > 0 ? 1.25 : 0.8, timeOf(event, canvas));
    });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held = { t: timeOf(event, canvas), window: [...window_], x: event.clientX };
      if (!event.shiftKey) onTime(held.t);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      if (!event.shiftKey) return onTime(timeOf(event, canvas));
      const span = held.window[1] - held.window[0];
      const moved = ((event.clientX - held.x) / (canvas.clientWidth - LEFT - RIGHT)) * span;
      const from = Math.min(Math.max(held.window[0] - moved, first), last - span);
      window_ = [from, from + span];
      draw();
    });
    canvas.addEventListener("pointerup", () => (held = null));
    canvas.addEventListener("dblclick", () => ((window_ = [first, last]), draw()));
  }
  return { show, draw, zoom, whole: () => ((window_ = [first, last]), draw()), window: () => window_ };
}
