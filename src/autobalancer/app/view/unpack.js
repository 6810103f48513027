// The block of bytes that packed.py makes: a head and its arrays, without a copy.
const TYPES = { float32: Float32Array, float64: Float64Array, int16: Int16Array };

export function unpack(buffer) {
  const magic = new TextDecoder().decode(new Uint8Array(buffer, 0, 4));
  if (magic !== "ABV1") throw new Error("not a run of autobalancer");
  const length = new DataView(buffer).getUint32(4, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const arrays = {};
  for (const [name, told] of Object.entries(head.arrays)) {
    const count = told.shape.reduce((a, b) => a * b, 1);
    arrays[name] = new TYPES[told.type](buffer, 8 + length + told.at, count);
  }
  return { head, arrays };
}

// The last sample at or before a time.
export function indexAt(times, t) {
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return low;
}

// Hermite's cubic between two samples; s from 0 to 1, slopes per step.
export function cubic(from, to, slopeFrom, slopeTo, s) {
  const rise = to - from;
  const a = slopeFrom - rise;
  const b = rise - slopeTo;
  return from + s * rise + s * (1 - s) * (a * (1 - s) + b * s);
}

// State at a time: angle, deflection of every plane in the rotor, angles of the balls.
export function stateAt(run, t) {
  const { head, arrays } = run;
  const i = Math.min(indexAt(arrays.time, t), arrays.time.length - 2);
  const step = arrays.time[i + 1] - arrays.time[i];
  const s = Math.min(Math.max((t - arrays.time[i]) / step, 0), 1);
  const mix = (values, at, next) => values[at] + s * (values[next] - values[at]);
  const angle = cubic(arrays.angle[i], arrays.angle[i + 1], arrays.speed[i] * step, arrays.speed[i + 1] * step, s);
  const state = { index: i, share: s, angle, speed: mix(arrays.speed, i, i + 1) };
  if (head.kind === "chambers") return state;
  const planes = head.planes.length;
  state.planes = head.planes.map((_, p) => [
    mix(arrays.re, i * planes + p, (i + 1) * planes + p),
    mix(arrays.im, i * planes + p, (i + 1) * planes + p),
  ]);
  const count = head.balls.length;
  state.balls = head.balls.map((_, k) => {
    const at = i * count + k;
    return cubic(arrays.ball[at], arrays.ball[at + count], arrays.slip[at] * step, arrays.slip[at + count] * step, s);
  });
  state.inside = head.balls.map((_, k) => mix(arrays.inside, i * count + k, (i + 1) * count + k));
  const columns = arrays.heavy_re.length / arrays.time.length; // one in blocks of older runs
  state.heavy = head.planes.slice(0, columns).map((_, p) => [
    mix(arrays.heavy_re, i * columns + p, (i + 1) * columns + p),
    mix(arrays.heavy_im, i * columns + p, (i + 1) * columns + p),
  ]);
  return state;
}
