// The compiled program of a system: its memory, and calls of its functions.
//
// `data` says how large the arrays are that the functions work on, in doubles, and where a state has its parts
// (`native/state.py`). A motion takes the same steps as one of `lagrange solve`.

const LANES = 8;
const Stop = { END: 0, SAMPLES: 1, PAUSE: 2, SINGULAR: 3, NOT_FINITE: 4, UNDERFLOW: 5, GUARD: 6, ROOT: 9 };
const Clock = {
  TIME: 0, LOW: 1, STEP: 2, GAP: 3, USUAL: 4, LAST_PASS: 5, PASSES: 6, LEAVING: 7, FAILURES: 8, LENGTH: 12,
  PROJECTIONS: 13,
};
const BEGINNING = [Clock.STEP, Clock.GAP, Clock.USUAL, Clock.LEAVING, Clock.FAILURES];
const PAGE = 65536;
const INFO = 5, DUE = 3, RECORDED = 4;

class Engine {
  constructor(data, module) {
    this.data = data;
    this.module = module;
    this.wasm = new WebAssembly.Memory({ initial: Math.ceil(data.heap / PAGE) + 1 });
    const pointer = new WebAssembly.Global({ value: "i32", mutable: true }, data.heap);
    this.imports = { env: { __linear_memory: this.wasm, __stack_pointer: pointer } };
    this.top = data.heap;
    this.places = {};
    for (const [name, size] of Object.entries(data.sizes)) this.places[name] = this.room(size);
    this.results = this.room(data.results);
    this.given = this.room(Math.max(data.parameters.length + data.room, 1));
    this.moment = this.room(2);
    this.state = this.room(Math.max(data.rows, data.degrees + data.free, 1));
    this.rates = this.room(Math.max(data.inner, 1));
    this.acted = this.room(Math.max(data.acted, 1));
    this.located = this.room(Math.max(data.points, 1));
    this.kept = 0;
  }

  async load() { this.call = (await WebAssembly.instantiate(this.module, this.imports)).exports; }

  // The address of so many doubles on a boundary of 64 bytes.
  room(count) {
    const address = this.top;
    this.top = (this.top + 8 * count + 127) & ~63;
    const missing = this.top - this.wasm.buffer.byteLength;
    if (missing > 0) this.wasm.grow(Math.ceil(missing / PAGE));
    return address;
  }

  at(address, count) { return new Float64Array(this.wasm.buffer, address, count); }
  integers(address, count) { return new BigInt64Array(this.wasm.buffer, address, count); }
  get memory() { return this.at(this.places.memory, this.data.sizes.memory); }

  // Parameters as compiled code takes them: with room for the modes of switches.
  put(parameters) {
    const given = this.at(this.given, this.data.parameters.length + this.data.room);
    given.fill(0);
    given.set(parameters);
  }

  // The constants of what is observed and of what is drawn, for these parameters.
  prepare(parameters) {
    this.put(parameters);
    this.call.prepare?.(this.given, this.places.observing);
    this.call.prepare_place?.(this.given, this.places.placing);
    this.prepared = parameters;
  }

  // The same, unless they are there.
  ready(parameters) { if (this.prepared !== parameters) this.prepare(parameters); }

  // What expressions in parameters say: of the parameters themselves, of q and of v.
  derive(parameters) {
    this.put(parameters);
    this.call.derive(this.given, this.results);
    return Array.from(this.at(this.results, this.data.derived));
  }

  // The masses and lengths of the drawing.
  measure(parameters) {
    if (!this.data.measured) return [];
    this.put(parameters);
    this.call.measure(this.given, this.results);
    return Array.from(this.at(this.results, this.data.measured));
  }

  // The components of all points of the drawing at a state.
  place(t, q) {
    if (!this.data.points) return new Float64Array(0);
    this.at(this.moment, 2).set([t, 0]);
    this.at(this.state, q.length).set(q);
    this.call.place(this.places.placing, this.moment, this.state, this.located, 1n, 1n);
    return this.at(this.located, this.data.points);
  }

  // Room for so many samples: kept, as far as it is there.
  reserve(count) {
    if (count <= this.kept) return;
    const { inner, degrees, observed, points, free } = this.data;
    this.top = this.samplesAt ?? this.top;
    this.samplesAt = this.top;
    this.stride = count + LANES;
    this.times = this.room(this.stride);
    this.out = this.room(inner * this.stride);
    this.states = this.room((2 * degrees + free) * this.stride); // what is free has rows, though no values
    this.observed = this.room(Math.max(observed.length, 1) * this.stride);
    this.traced = this.room(Math.max(points, 1) * this.stride);
    this.kept = count;
  }

  // A state near q and v where the constraints hold, the rows `pinned` as they are; whether there is one.
  satisfy(t, parameters, q, v, pinned) {
    if (!this.call.project) return { q, v, good: true };
    const { layout, degrees } = this.data;
    this.prepare(parameters);
    const memory = this.memory, low = layout.width, third = layout.third;
    const load = () => {
      memory.fill(0);
      for (let k = 0; k < degrees; k++) [memory[k], memory[layout.v + k]] = [q[k], v[k]];
      memory[layout.clock + Clock.TIME] = t;
    };
    load();
    const count = layout.clock + Clock.PROJECTIONS;
    let good = false;
    for (let round = 0; round < 400 && !good; round++) {
      const before = memory[count];
      this.call.project(this.places.observing, this.places.memory);
      good = memory[count] === before;
      for (const [row, value] of pinned) {
        if (Math.abs(memory[row] - value) > 1e-9 * Math.max(1, Math.abs(value))) good = false;
        if (round < 360) memory[row] = value, memory[low + row] = 0, memory[third + row] = 0;
      }
    }
    const found = Array.from({ length: 2 * degrees }, (_, k) => memory[k < degrees ? k : layout.v + k - degrees]);
    good = good && found.every(Number.isFinite);
    return { q: found.slice(0, degrees), v: found.slice(degrees), good };
  }
}
