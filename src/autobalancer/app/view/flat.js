// Polar view of the races, in the frame of the rotor, and the orbit of the rotor.
import { indexAt, stateAt } from "./unpack.js";

function prepared(canvas) {
  const wide = canvas.clientWidth;
  const high = canvas.clientHeight;
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(wide * ratio)) canvas.width = Math.round(wide * ratio);
  if (canvas.height !== Math.round(high * ratio)) canvas.height = Math.round(high * ratio);
  const c = canvas.getContext("2d");
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, wide, high);
  c.font = "11px system-ui, sans-serif";
  return { c, wide, high };
}

const titled = (text, head, plane) => (head.names?.[plane] ? `${text}: ${head.names[plane]}` : text);

// One plane of the rotor each.
export function createPolar(canvas, run, colors, plane) {
  const { head, arrays } = run;
  const numbers = head.balls.map((_, k) => k).filter((k) => head.planes.length < 2 || head.balls[k].plane === plane);
  const reach = Math.max(...head.balls.map((one) => one.orbit + one.radius)); // planes to one scale
  const TRAIL = 40;
  return (t) => {
    const { c, wide, high } = prepared(canvas);
    if (!wide) return;
    const look = colors();
    const at = stateAt(run, t);
    const scale = Math.min(0.5 * wide - 36, 0.5 * high - 26) / reach; // beside it "180°"
    const [mx, my] = [0.5 * wide, 0.5 * high + 6];
    const spot = (ball, angle, inside = 0) => [
      mx + scale * (ball.center[0] + (ball.orbit - inside) * Math.cos(angle)),
      my - scale * (ball.center[1] + (ball.orbit - inside) * Math.sin(angle)),
    ];
    c.strokeStyle = look.line;
    for (const k of numbers) {
      const ball = head.balls[k];
      for (const radius of [ball.orbit - ball.radius, ball.orbit + ball.radius]) {
        c.beginPath();
        c.arc(mx + scale * ball.center[0], my - scale * ball.center[1], scale * Math.max(radius, 0), 0, 2 * Math.PI);
        c.stroke();
      }
    }
    const count = head.balls.length;
    numbers.forEach((k) => {
      const ball = head.balls[k];
      c.strokeStyle = c.fillStyle = look.shade(ball.color);
      c.globalAlpha = 0.35;
      c.lineWidth = 3;
      c.beginPath();
      for (let i = Math.max(at.index - TRAIL, 0); i <= at.index; i++) {
        const place = spot(ball, arrays.ball[i * count + k], arrays.inside[i * count + k]);
        const from = i > 0 ? Math.abs(arrays.ball[i * count + k] - arrays.ball[(i - 1) * count + k]) : 9;
        if (from > 1) c.moveTo(...place);
        else c.lineTo(...place);
      }
      c.stroke();
      c.globalAlpha = 1;
      c.lineWidth = 1;
      c.beginPath();
      c.arc(...spot(ball, at.balls[k], at.inside[k]), Math.max(scale * ball.radius, 4), 0, 2 * Math.PI);
      c.fill();
      c.strokeStyle = look.ink;
      c.stroke();
    });
    const pull = at.heavy[Math.min(plane, at.heavy.length - 1)];
    const heavy = Math.atan2(pull[1], pull[0]);
    if (Math.hypot(...pull) > 0) {
      c.strokeStyle = "#D55E00";
      c.lineWidth = 2;
      c.beginPath();
      c.moveTo(mx, my);
      c.lineTo(mx + 0.6 * scale * reach * Math.cos(heavy), my - 0.6 * scale * reach * Math.sin(heavy));
      c.stroke();
    }
    c.fillStyle = look.soft;
    c.textAlign = "left";
    c.fillText("0°", mx + scale * reach + 6, my + 4);
    c.fillText("180°", Math.max(mx - scale * reach - 34, 1), my + 4);
    c.fillStyle = look.ink;
    c.font = "600 11.5px system-ui, sans-serif";
    c.fillText(titled("races, in the rotor", head, plane), 4, 13);
    c.font = "11px system-ui, sans-serif";
    c.fillStyle = "#D55E00";
    c.fillText("unbalance", 4, high - 6);
  };
}

export function createOrbit(canvas, run, colors, plane) {
  const { head, arrays } = run;
  const planes = head.planes.length;
  const unitOf = (most) => [["nm", 1e9], ["µm", 1e6], ["mm", 1e3]].find(([, s]) => most * s < 1000) || ["m", 1];
  return (t) => {
    const { c, wide, high } = prepared(canvas);
    if (!wide) return;
    const look = colors();
    const i = indexAt(arrays.time, t);
    const from = Math.max(i - 60, 0);
    const to = Math.min(i + 60, arrays.time.length - 1);
    const points = [];
    for (let n = from; n <= to; n++) points.push([arrays.re[n * planes + plane], arrays.im[n * planes + plane]]);
    const most = Math.max(...points.map(([x, y]) => Math.hypot(x, y)), 1e-12);
    const [name, factor] = unitOf(most);
    const scale = (0.5 * Math.min(wide, high) - 28) / most;
    const [mx, my] = [0.5 * wide, 0.5 * high + 6];
    c.strokeStyle = look.grid;
    c.beginPath();
    c.moveTo(mx - scale * most, my);
    c.lineTo(mx + scale * most, my);
    c.moveTo(mx, my - scale * most);
    c.lineTo(mx, my + scale * most);
    c.stroke();
    c.beginPath();
    c.arc(mx, my, scale * most, 0, 2 * Math.PI);
    c.stroke();
    c.strokeStyle = look.shade("#0072B2");
    c.lineWidth = 1.4;
    c.beginPath();
    points.forEach(([x, y], n) => (n ? c.lineTo(mx + scale * x, my - scale * y) : c.moveTo(mx + scale * x, my - scale * y)));
    c.stroke();
    const now = stateAt(run, t).planes[plane];
    c.fillStyle = look.ink;
    c.beginPath();
    c.arc(mx + scale * now[0], my - scale * now[1], 4, 0, 2 * Math.PI);
    c.fill();
    c.font = "600 11.5px system-ui, sans-serif";
    c.fillText(titled("orbit, in the rotor", head, plane), 4, 13);
    c.font = "11px system-ui, sans-serif";
    c.fillStyle = look.soft;
    c.fillText(`circle: ${+(most * factor).toPrecision(3)} ${name}`, 4, high - 6);
  };
}
