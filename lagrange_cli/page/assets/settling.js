// Modes of switches (`integrate/guards/settling.py`): where the argument of |u| or sign(u) is 0, the side that
// the motion leads to; or 0, where the motion is held there (A. F. Filippov 1988, sec. 4).

const DERIVATIVES = 6;
const ROUNDING = 2 ** -44;      // a derivative that is so small beside the terms of the others is rounding
const NEAR = 2 ** -48;          // an argument that is this part of coordinates may be rounding
const JUST = 2 ** -45;          // a change of a mode so short a part of the time ago has just been
const HELD = 1 + 2 ** -40;      // multipliers up to this hold the motion
const JUMP = 2 ** -20, TREMBLES = 2 ** -8;
const SOON = 2 ** -30, SHORT = 2 ** -26;
const ROUNDED = 1e-16;          // the square of a jump that is rounding (`mechanics/cuts.py`)
const CHANGES = 64;
const ATTEMPTS = 8, ROUNDS = 8, EXACT = 2;
const SAME = 2 ** -46;          // zeros within this part of the time, or of a step, are at the same time
const SMALLEST = 2 ** -1022;
const APART = 2 ** -40, LARGER = 2 ** 4; // when drag acts again where its vector was 0 (`methods/sliding.py`)

class Settling {
  constructor(engine) {
    this.engine = engine;
    this.rows = engine.data.guards;
    this.layout = engine.data.layout;
    this.count = this.rows.switches;
    this.attempts = 0;
    this.latest = NaN;
  }

  get memory() { return this.engine.memory; }
  get modes() { return this.memory.subarray(this.rows.mode, this.rows.mode + this.rows.guards.length); }
  get marks() { return this.memory.subarray(this.rows.fresh, this.rows.fresh + this.rows.guards.length); }
  get now() { return this.memory[this.layout.clock + Clock.TIME]; }
  clock(number) { return this.memory[this.layout.clock + number]; }
  set(number, value) { this.memory[this.layout.clock + number] = value; }
  forget() { for (const number of BEGINNING) this.set(number, 0); }

  mark(guards) {
    for (const j of guards) this.marks[j] = Math.max(this.clock(Clock.LENGTH), SMALLEST);
  }

  get parameters() { return this.memory.slice(this.rows.settings, this.rows.settings + this.rows.parameters); }

  // The constants of the equations, from parameters and modes.
  prepare() {
    this.engine.call.prepare(this.engine.places.memory + 8 * this.rows.settings, this.engine.places.constants);
  }

  // The series from here on; the rates of velocities and integrals.
  series() {
    const { places, rates, call, data } = this.engine;
    this.prepare();
    this.engine.at(places.work, data.sizes.work).fill(0);
    call.accelerate(places.constants, this.now, places.memory, places.work, rates);
    return this.engine.at(rates, data.inner - this.layout.v);
  }

  // The first derivatives of what a row is the quadrature of, divided by factorials, from the value on.
  coefficients(row) {
    const [first, step, term] = this.rows.seriesAt;
    const work = this.engine.at(this.engine.places.work, this.engine.data.sizes.work);
    return Array.from({ length: DERIVATIVES + 1 }, (_, i) => work[first + row * step + (i + 1) * term] * (i + 1));
  }

  argument(j) { return this.coefficients(this.rows.guards[j].row); }

  arguments() {
    this.series();
    return Array.from({ length: this.count }, (_, j) => this.argument(j)[0]);
  }

  // The largest coefficients of each order among velocities.
  scale() {
    const found = new Array(DERIVATIVES + 2).fill(0);
    for (let row = this.layout.v; row < 2 * this.layout.v; row++) {
      this.coefficients(row).forEach((one, m) => { found[m + 1] = Math.max(found[m + 1], Math.abs(one)); });
    }
    return found;
  }

  begin(parameters) {
    this.memory.set(parameters, this.rows.settings);
    this.beginSwitches();
  }

  // Choose the modes of all switches, whatever was before.
  beginSwitches() {
    for (let j = 0; j < this.count; j++) this.modes[j] = 1;
    let values = [];
    for (let round = 0; round <= this.count; round++) {
      values = this.arguments();
      const signs = values.map((one, j) => (one < 0 ? -1 : one === 0 && this.rows.guards[j].parts ? 0 : 1));
      if (signs.every((one, j) => one === this.modes[j])) break;
      signs.forEach((one, j) => { this.modes[j] = one; });
    }
    const zero = values.flatMap((one, j) => (one === 0 && !this.rows.guards[j].parts ? [j] : []));
    if (zero.length) this.choose(zero, new Map(zero.map((j) => [j, 1])));
    this.letRest();
    this.prepare();
  }

  // Let arguments rest that stay 0, where forces jump: these have a value there (`integrate/guards/at_zero.py`).
  letRest() {
    const { layout } = this, largest = (values) => Math.max(0, ...values.map(Math.abs));
    const size = largest(this.memory.subarray(0, layout.v)), speed = largest(this.memory.subarray(layout.v, 2 * layout.v));
    for (let j = 0; j < this.count; j++) {
      const guard = this.rows.guards[j];
      if (guard.multiplier || guard.parts || guard.beside || this.modes[j] === 0) continue;
      const own = this.series().slice(0, layout.v), [u, ...rates] = this.argument(j), scale = this.scale();
      const usual = (m) => (m === 0 ? speed : scale[m]);
      if (Math.abs(u) > NEAR * size || rates.some((one, m) => Math.abs(one) > ROUNDING * usual(m))) continue;
      this.modes[j] = -this.modes[j];
      const other = this.series().slice(0, layout.v), jumps = own.some((one, k) => one !== other[k]);
      this.modes[j] = jumps ? 0 : -this.modes[j];
      if (jumps) this.marks[j] = -LARGER * Math.abs(u);
    }
  }

  // Whether the state is where an expression of the file has no value.
  isBeyondEdge() {
    const edges = [...Array(this.count).keys()].filter((j) => this.isEdge(j));
    if (!edges.length) return false;
    const values = this.arguments();
    return edges.some((j) => !(values[j] >= 0));
  }

  isEdge(j) { return j >= 0 && j < this.count && this.rows.guards[j].role === Role.EDGE; }

  goesOn(stop, due) {
    if (stop === Stop.GUARD && this.isEdge(due)) return false;
    if (stop === Stop.GUARD && this.hears()) return true;
    if (stop === Stop.GUARD && due < this.count && this.rows.guards[due].parts) return this.leaveOut(due);
    if (stop === Stop.GUARD && due < this.count && this.rows.guards[due].beside) return this.passes(due);
    if (stop === Stop.GUARD) return this.settle(due) || this.rest();
    if (stop === Stop.ROOT) return this.rest() || this.tries();
    return (stop === Stop.UNDERFLOW || stop === Stop.NOT_FINITE) && (this.stops() || this.rest());
  }

  // Let guards be silent whose friction is 0 from now on, and choose the modes of those that are loud again.
  hears() {
    const { silent } = this.rows, values = this.arguments();
    const turned = new Set(silent.map(([, k]) => k).filter((k) => values[k] * this.modes[k] < 0));
    if (!turned.size) return false;
    this.forget();
    for (const k of turned) this.modes[k] = -this.modes[k];
    const own = silent.flatMap(([j, k]) => (turned.has(k) ? [j] : []));
    for (const j of own) { this.modes[j] = 1; this.marks[j] = 0; }
    const now = this.arguments();
    for (const j of own) this.modes[j] = now[j] < 0 ? -1 : 1;
    const zero = own.filter((j) => now[j] === 0);
    if (zero.length) return this.choose(zero, new Map(zero.map((j) => [j, 1])));
    this.prepare();
    return true;
  }

  // Go on with steps where a force has no series.
  tries() {
    const last = this.clock(Clock.LAST_PASS);
    this.set(Clock.LAST_PASS, last - Math.max(Math.abs(last) * JUST, SMALLEST));
    return true;
  }

  // Leave drag along a vector out that is about to be 0, or has just been.
  stops() {
    this.series();
    const soon = Math.max(Math.abs(this.now), SMALLEST) * SOON;
    for (let j = 0; j < this.count; j++) {
      const [u, rate] = this.argument(j);
      if (this.rows.guards[j].parts && this.modes[j] && u <= Math.abs(rate) * soon) return this.leaveOut(j);
    }
    return false;
  }

  // Leave it out until times since it was 0 are told apart.
  leaveOut(j) {
    const waited = this.modes[j] === 0;
    this.modes[j] = 0;
    this.series();
    const [square, rate] = this.argument(j);
    if (waited && 2 * square >= APART * rate * this.now) this.modes[j] = 1;
    else this.marks[j] = -LARGER * square;
    this.forget();
    this.prepare();
    return true;
  }

  // Go on to the other side of a guard whose mode no equation contains, if nothing jumps there.
  passes(due) {
    this.series();
    const { beside } = this.rows.guards[due];
    const [x, jump, usual] = [0, 1, 2].map((i) => this.coefficients(beside + i)[0]);
    if (x < 0 && !(jump <= ROUNDED * usual)) return false;
    this.modes[due] = -this.modes[due];
    this.mark([due]);
    return true;
  }

  // Choose the mode of a guard whose argument has become 0, or whose multiplier has reached its bound.
  settle(due) {
    this.attempts = this.now === this.latest ? this.attempts + 1 : 0;
    this.latest = this.now;
    if (due < 0 || due >= this.count || this.attempts > ATTEMPTS * (this.count + 1)) return false;
    this.series();
    const was = this.modes[due], [value, rate] = this.argument(due);
    if (was * value < 0 && Math.abs(value) > JUMP * Math.abs(rate * this.clock(Clock.STEP))) {
      this.modes[due] = -was; // it has not come through 0, but jumped
      this.prepare();
      return true;
    }
    this.forget();
    const marked = [];
    for (let j = 0; j < this.count; j++) if (j !== due && this.marks[j] > 0 && this.modes[j] !== 0) marked.push(j);
    const multiplier = this.rows.guards[due].multiplier;
    if (this.clock(Clock.PASSES) >= CHANGES && multiplier) this.stopAt(due);
    if (was === 0) {
      const leaving = multiplier ? this.multiplier(due) : this.arguments()[due];
      return this.choose([due, ...marked], new Map([[due, leaving > 0 ? 1 : -1]]), false);
    }
    return this.choose([due, ...marked], new Map([[due, -was]]));
  }

  // Let a velocity be 0 that a force has brought to rest which is 0 there, but has no series.
  rest() {
    this.series();
    const soon = Math.max(Math.abs(this.now), SMALLEST) * SOON;
    for (let j = 0; j < this.count; j++) {
      const [u, rate] = this.argument(j);
      const near = this.modes[j] * rate < 0 && Math.abs(u) > 0 && Math.abs(u) <= Math.abs(rate) * soon;
      if (near && this.rests(j, u)) return true;
      this.series();
    }
    return false;
  }

  rests(j, u) {
    const { layout } = this, memory = this.memory.slice();
    const row = memory.subarray(layout.v, 2 * layout.v).indexOf(u) + layout.v;
    if (row < layout.v) return false;
    this.memory[row] = this.memory[layout.width + row] = 0;
    this.modes[j] = 0;
    this.series();
    const scale = this.scale();
    if (this.argument(j).every((one, m) => Math.abs(one) <= ROUNDING * scale[m])) {
      this.marks[j] = 0;
      this.forget();
      return true;
    }
    this.memory.set(memory);
    return false;
  }

  // Choose the modes of guards whose arguments are 0: held where that is possible, else the side tried first.
  choose(guards, first, held = true) {
    const able = held ? guards.filter((j) => this.rows.guards[j].multiplier) : [];
    for (let j = 0; j < this.count; j++) this.marks[j] = 0;
    this.mark(guards);
    for (const j of guards) this.modes[j] = able.includes(j) ? 0 : first.get(j) ?? this.modes[j];
    for (let round = 0; round < ROUNDS * (guards.length + 1); round++) {
      this.series();
      const loose = able.filter((j) => this.modes[j] === 0).map((j) => [this.holding(j), j]);
      const worst = loose.filter(([size]) => !(size <= HELD)).sort((a, b) => b[0] - a[0])[0];
      if (worst) {
        const j = worst[1];
        this.modes[j] = first.get(j) || (this.multiplier(j) > 0 ? 1 : -1);
        this.series();
        if (!this.leads(j)) this.modes[j] = -this.modes[j];
        continue;
      }
      const wrong = guards.filter((j) => this.modes[j] !== 0 && !this.leads(j));
      if (!wrong.length) {
        for (const [, j] of loose) if (!this.rows.guards[j].placed) this.takeToZero(j);
        return true;
      }
      for (const j of wrong) {
        this.modes[j] = -this.modes[j];
        this.series();
        if (this.leads(j)) continue;
        if (this.rows.guards[j].multiplier) {
          this.modes[j] = 0;
          able.push(j);
        } else { // both sides lead back: it touches 0, and rounding decides
          this.modes[j] = -this.modes[j];
          guards = guards.filter((one) => one !== j);
        }
      }
    }
    return false;
  }

  // Set a velocity that holds the motion, and is 0 up to rounding, to 0, along the force that holds it.
  takeToZero(j) {
    const { layout, memory } = this, own = this.modes[j];
    for (let round = 0; round < EXACT; round++) {
      this.series();
      const [off] = this.argument(j);
      if (off === 0) return;
      const [above, below] = [1, -1].map((mode) => {
        this.modes[j] = mode;
        return { accelerations: this.series().slice(0, layout.v), rate: this.argument(j)[1] };
      });
      this.modes[j] = own;
      const scale = off / (above.rate - below.rate || Infinity);
      for (let k = 0; k < layout.v; k++) {
        const change = (above.accelerations[k] - below.accelerations[k]) * scale, row = layout.v + k;
        if (!Number.isFinite(change) || change === 0) continue;
        memory[row] -= change;
        if (Math.abs(memory[row]) <= ROUNDING * Math.abs(change)) memory[row] = 0;
        memory[layout.width + row] = memory[layout.third + row] = 0;
      }
    }
    this.series();
  }

  // The switch that may hold the motion and comes to 0 now, if there is one: an event there happens as it stops.
  comesToHold(length) {
    this.series();
    const time = SAME * Math.max(Math.abs(this.now), length);
    return [...Array(this.count).keys()].find((j) => {
      const [u, rate] = this.argument(j), mode = this.modes[j];
      const comes = Math.abs(u) <= Math.abs(rate) * time && rate * mode < 0;
      return comes && this.rows.guards[j].multiplier && this.marks[j] === 0;
    });
  }

  // Take away the velocity with which the motion passes u = 0 ever more often.
  stopAt(j) {
    const { layout } = this;
    const [first, other] = [1, -1].map((mode) => {
      this.modes[j] = mode;
      const accelerations = this.series().slice(0, layout.v);
      return { accelerations, u: this.argument(j) };
    });
    const jump = 2 * (first.u[2] - other.u[2]);
    if (first.u[1] !== other.u[1] || jump === 0) return;
    for (let k = 0; k < layout.v; k++) {
      this.memory[layout.v + k] -= (first.accelerations[k] - other.accelerations[k]) * first.u[1] / jump;
      this.memory[layout.width + layout.v + k] = 0;
    }
    this.set(Clock.PASSES, 0);
  }

  multiplier(j) { return this.coefficients(this.rows.guards[j].multiplier)[0]; }

  // The size of the multiplier, infinite where the motion passes u = 0 with a velocity.
  holding(j) {
    const u = this.argument(j), noise = ROUNDING * this.scale()[1], size = Math.abs(this.multiplier(j));
    return Math.abs(u[1]) <= noise && Number.isFinite(size) ? size : Infinity;
  }

  // Whether the motion leads to the side of a guard's mode; or along u = 0.
  leads(j) {
    this.modes[j] = -this.modes[j];
    this.series();
    const other = this.argument(j);
    this.modes[j] = -this.modes[j];
    this.series();
    const u = this.argument(j), scale = this.scale();
    for (let m = 1; m < u.length; m++) {
      const size = Math.max(scale[m], Math.abs(u[m] - other[m]) || 0);
      if (!(Math.abs(u[m]) <= ROUNDING * size)) return u[m] * this.modes[j] > 0;
    }
    return u.every(Number.isFinite);
  }
}
