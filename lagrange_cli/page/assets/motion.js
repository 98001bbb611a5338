// One motion: its samples, computed piece by piece, and its state at any time between them.

const ENDS = {
  [Stop.SINGULAR]: "the mass matrix is singular there",
  [Stop.NOT_FINITE]: "the equations of motion have no finite value there",
  [Stop.UNDERFLOW]: "a singularity, a collision, or a force that has no series",
  [Stop.GUARD]: "a force or an energy jumps there, and no motion continues from there",
};
const NO_VALUE = "an expression of the file has no value beyond this place";
const GREAT = 1e280;
const FEWEST = 16;

class Motion {
  // `begin` has parameters, q and v; the samples are `count`, evenly from `start` to `stop`.
  constructor(engine, begin, start, stop, count) {
    Object.assign(this, { engine, begin, start, stop, count });
    this.steps = this.done = this.observed = 0;
    this.pause = FEWEST;
    this.ended = false;    // whether all is computed
    this.reason = "";      // why it could not go on, or which event has stopped it
    this.events = [];      // what happened: {t, event}
    this.changes = [];     // parameters that actions have changed, still to be observed: {sample, parameters}
    this.settings = [{ t: -Infinity, parameters: begin.parameters }]; // all parameters, from when on
    engine.reserve(count);
    const { layout, outer, degrees } = engine.data;
    const times = engine.at(engine.times, engine.stride);
    const step = (stop - start) / (count - 1);
    for (let i = 0; i < engine.stride; i++) times[i] = i < count - 1 ? start + i * step : i < count ? stop : NaN;
    const memory = engine.memory;
    memory.fill(0);
    engine.integers(engine.places.info, INFO).fill(0n);
    for (let k = 0; k < degrees; k++) [memory[outer[k]], memory[outer[degrees + k]]] = [begin.q[k], begin.v[k]];
    memory[layout.clock + Clock.TIME] = start;
    if (engine.data.guards) {
      this.settling = new Settling(engine);
      this.settling.begin(begin.parameters);
      this.endBeyondEdge();
      if (engine.data.guards.events.length) {
        this.happenings = new Happenings(this, this.settling);
        this.end(this.happenings.begin());
      }
    } else {
      engine.put(begin.parameters);
      engine.call.prepare(engine.given, engine.places.constants);
    }
    engine.prepare(begin.parameters);
    this.parameters = begin.parameters;
  }

  get t() { return this.engine.memory[this.engine.data.layout.clock + Clock.TIME]; }

  end(reason) {
    if (reason) [this.ended, this.reason] = [true, reason];
    return Boolean(reason);
  }

  // End the motion if it is where an expression of the file has no value.
  endBeyondEdge() { if (!this.ended && this.settling.isBeyondEdge()) this.failAtEdge(); }
  failAtEdge() { [this.ended, this.failed, this.reason] = [true, true, NO_VALUE]; }

  advance() {
    const { places, call, times, out, stride } = this.engine;
    const left = BigInt(this.count - this.done);
    const stop = Number(call.advance(
      places.constants, places.memory, places.work, places.trial, this.stop, times + 8 * this.done, left,
      out + 8 * this.done, BigInt(stride), 1n, BigInt(this.pause), places.info));
    const info = this.engine.integers(places.info, INFO);
    this.done += Number(info[0]);
    this.steps += Number(info[1]);
    return stop;
  }

  // Go on for about so many milliseconds; whether all is computed.
  compute(milliseconds) {
    const until = performance.now() + milliseconds;
    while (!this.ended) {
      const before = this.done, began = performance.now();
      this.take(this.advance(), before);
      const now = performance.now();
      this.pause = Math.min(65536, Math.max(FEWEST, now - began > 4 ? this.pause >> 1 : 2 * this.pause));
      if (now >= until) break;
    }
    this.observe();
    return this.ended;
  }

  take(stop, before) {
    if (this.settling) {
      const due = Number(this.engine.integers(this.engine.places.info, INFO)[DUE]);
      if (this.happenings) {
        if (this.end(this.happenings.drain(before))) return;
        if (stop === Stop.GUARD && due >= this.settling.count) {
          const first = this.settling.comesToHold(this.settling.clock(Clock.STEP));
          if (first !== undefined && this.settle(stop, first)) return;
          this.end(this.happenings.happen(due, this.done));
          this.endBeyondEdge();
          return;
        }
      }
      if (this.settle(stop, due)) return;
      if (stop === Stop.GUARD && this.settling.isEdge(due)) { this.failAtEdge(); return; }
    }
    if (stop === Stop.PAUSE || stop === Stop.SAMPLES) return;
    this.ended = true;
    if (stop === Stop.END) return;
    const great = this.engine.data.outer.some((row) => Math.abs(this.engine.memory[row]) > GREAT);
    this.reason = great ? "a coordinate or a velocity exceeds the largest double" : ENDS[stop];
    this.failed = true;
  }

  // Choose the modes of switches where compiled code has stopped; whether the motion goes on from there.
  settle(stop, due) {
    const earlier = this.happenings?.moving();
    const goesOn = this.settling.goesOn(stop, due);
    if (goesOn && this.happenings) this.end(this.happenings.stop(earlier, this.done));
    return goesOn;
  }

  // Compute what is shown of the samples that are new.
  observe() {
    const { engine, observed: first, done } = this;
    if (done === first) return;
    const { degrees, outer } = engine.data;
    const { stride } = engine;
    engine.ready(this.parameters);
    for (let k = 0; k < 2 * degrees; k++) {
      const row = engine.at(engine.out + 8 * (outer[k] * stride + first), done - first);
      engine.at(engine.states + 8 * (k * stride + first), done - first).set(row);
    }
    let from = first;
    for (const change of [...this.changes.filter((one) => one.sample < done), { sample: done }]) {
      const to = Math.max(from, change.sample);
      this.observePart(from, to);
      from = to;
      if (change.parameters) engine.ready(this.parameters = change.parameters);
    }
    this.changes = this.changes.filter((one) => one.sample >= done);
    this.observed = done;
  }

  observePart(from, to) {
    if (to <= from) return;
    const { engine } = this, { stride } = engine, shift = 8 * from, count = BigInt(to - from);
    const call = (what, constants, out) => what(
      constants, engine.times + shift, engine.states + shift, out + shift, BigInt(stride), count);
    call(engine.call.observe, engine.places.observing, engine.observed);
    if (engine.data.points) call(engine.call.place, engine.places.placing, engine.traced);
  }

  row(address, k) { return this.engine.at(address + 8 * k * this.engine.stride, this.observed); }
  get times() { return this.row(this.engine.times, 0); }
  q(k) { return this.row(this.engine.states, k); }
  v(k) { return this.row(this.engine.states, this.engine.data.degrees + k); }
  quantity(k) { return this.row(this.engine.observed, k); }
  trace(k) { return this.row(this.engine.traced, k); }
  get last() { return this.observed ? this.times[this.observed - 1] : this.start; }
  get first() { return this.start; }

  // q and v at a time, by Hermite's interpolation between samples.
  stateAt(t) { return interpolated(this, t, this.engine.data.degrees); }
  ready(t) { this.engine.ready(parametersAt(this.settings, t)); }
  points(t) { this.ready(t); return this.engine.place(t, this.stateAt(t).q); }
}

// The parameters at a time: of several changes at once the last one holds.
function parametersAt(settings, t) {
  let [low, high] = [0, settings.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (settings[middle].t <= t) low = middle; else high = middle;
  }
  return settings[low].parameters;
}

// The number of the last sample that is not after t.
function before(times, t) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return low;
}

function interpolated(motion, t, degrees) {
  const times = motion.times, i = before(times, t), j = Math.min(i + 1, times.length - 1);
  const h = times[j] - times[i], s = h === 0 ? 0 : Math.min(1, Math.max(0, (t - times[i]) / h));
  const q = new Float64Array(degrees), v = new Float64Array(degrees);
  const value = 1 - s * s * (3 - 2 * s), slope = s * (1 - s) * (1 - s) * h, other = s * s * (s - 1) * h;
  for (let k = 0; k < degrees; k++) {
    const [a, b, u, w] = [motion.q(k)[i], motion.q(k)[j], motion.v(k)[i], motion.v(k)[j]];
    // Where an impact or a missing sample makes the cubic meaningless, the straight line is taken.
    const smooth = h === 0 || Math.abs(b - a - h * (u + w) / 2) <= 0.2 * h * (Math.abs(u) + Math.abs(w));
    q[k] = smooth ? value * a + (1 - value) * b + slope * u + other * w : a + s * (b - a);
    v[k] = u + s * (w - u);
  }
  return { q, v };
}
