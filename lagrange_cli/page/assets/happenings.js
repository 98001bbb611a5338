// Events where compiled code leaves them to its caller (`integrate/impacts/happenings.py`): actions, resting
// contact, and the end of a motion.

const Role = { RECORD: 2, CHANGE: 3, ACTION: 4, REST: 5, EDGE: 8 };
const AFTER = -1;
const NO_TIME = 2 ** -50, AGAIN = 1000, MOST_EVENTS = 20000;
const MORE = "there are more events than a page shows";

class Happenings {
  constructor(motion, settling) {
    this.motion = motion;
    this.settling = settling;
    this.engine = settling.engine;
    this.layout = settling.layout;
    this.rows = settling.rows;
    this.events = this.rows.events;
    this.first = this.rows.switches;
    this.released = new Set();
    this.rests = new Map(this.events.flatMap((one, e) => (one.rest < 0 ? [] : [[e, one.rest]])));
    this.standstill = new Standstill(this);
    this.chosen = this.events.map(() => NaN); // when the side of each was chosen last, not by crossing 0
    this.same = 0;
    this.latest = -Infinity;
    this.start = settling.now;
    this.happened = 0;
  }

  get memory() { return this.settling.memory; }
  get modes() { return this.settling.modes; }
  side(e) { return this.modes[e + this.first]; }
  atZero(e) { return this.settling.marks[e + this.first] > 0; }
  coefficients(e) { return this.settling.argument(e + this.first); }
  seriesOf(e) { this.settling.series(); return this.coefficients(e); }
  allCoefficients() { this.settling.series(); return this.events.map((_, e) => this.coefficients(e)); }
  name(e) { return `event '${this.events[e].name}'`; }
  state(memory) { return this.engine.data.outer.map((row) => memory[row]); }
  flip(e) { this.modes[e + this.first] *= -1; this.settling.mark([e + this.first]); }

  // What actions set, were they all done now, the sizes of arguments and the masses that actions change.
  actOn(state) {
    const { engine } = this, count = this.rows.changed.length;
    this.settling.prepare();
    const clock = (number) => this.settling.clock(number);
    engine.at(engine.moment, 2).set([clock(Clock.TIME), clock(Clock.LOW)]);
    engine.at(engine.state, state.length).set(state);
    engine.call.act(engine.places.constants, engine.moment, engine.state, engine.acted, 1n, 1n);
    const found = Array.from(engine.at(engine.acted, engine.data.acted));
    const sizes = this.events.map((_, e) => found.slice(count + 2 * e, count + 2 * e + 2));
    return { values: found.slice(0, count), sizes, masses: found.slice(found.length - this.rows.masses) };
  }

  // Choose the sides where the motion begins: a zero there is no event.
  begin() {
    const held = this.held();
    this.memory.fill(NaN, this.rows.times, this.rows.times + 2 * this.events.length);
    const { values, sizes } = this.actOn(this.state(this.memory));
    for (const [e, [size, rate]] of sizes.entries()) {
      const { direction } = this.rows.guards[e + this.first], u = this.seriesOf(e);
      const leads = this.chooseSide(e, u, ROUNDING * size, rate);
      const still = this.atZero(e) && Math.abs(u[1]) <= ROUNDING * rate;
      if (!leads && direction) this.settling.modes[e + this.first] = -direction; // bodies touch, and move together
      else if (still && direction && this.side(e) === direction) {
        if (this.rests.has(e)) this.hold(e, -direction);
        else if (this.changesNothing(e, values)) return `${this.name(e)} is an impact without any speed, and changes nothing`;
      } else if (this.atZero(e) && direction && this.side(e) === direction && this.turns(e, values)) {
        this.settling.modes[e + this.first] = -direction;
      }
    }
    this.chooseSwitches(held);
    if (this.standstill.possible) this.standstill.hold();
    return "";
  }

  // The modes of contacts.
  held() { return [...this.rests.values()].map((j) => this.modes[j]); }

  // Choose the modes of switches where other contacts hold: arguments may stay 0 from now on.
  chooseSwitches(held) {
    if (this.held().some((one, k) => one !== held[k])) this.settling.beginSwitches();
  }

  changesNothing(e, values) {
    const { outer, degrees } = this.engine.data, motion = 2 * degrees;
    const own = this.rows.changed.flatMap(([event, place], i) => (event === e ? [[i, place]] : []));
    const there = (place) => this.memory[place < motion ? outer[place] : this.rows.settings + place - motion];
    return own.length > 0 && own.every(([i, place]) => values[i] === there(place));
  }

  // Whether an action turns the motion back to the side that it came from.
  turns(e, values) {
    const { degrees } = this.engine.data, memory = this.memory.slice();
    const own = this.rows.changed.filter(([event]) => event === e).map(([, place]) => place);
    if (!own.length || !own.every((place) => place >= degrees && place < 2 * degrees)) return false;
    const [, before] = this.seriesOf(e);
    const turns = this.put(e, values) && !(before * this.seriesOf(e)[1] > 0);
    this.memory.set(memory);
    this.settling.prepare();
    return turns;
  }

  // Take over the records that compiled code has made since it was called, before that sample.
  drain(sample) {
    const { engine, layout } = this, info = engine.integers(engine.places.info, INFO);
    const count = Number(info[RECORDED]), size = engine.data.sizes.memory;
    info[RECORDED] = 0n;
    const records = engine.at(engine.places.trial + 8 * engine.data.records, count * size);
    for (let k = 0; k < count; k++) {
      const record = records.subarray(k * size, (k + 1) * size), clock = (number) => record[layout.clock + number];
      if (clock(Clock.STEP) === AFTER) {
        const earlier = records.subarray((k - 1) * size, k * size);
        this.changed(sample + earlier[layout.clock + Clock.LEAVING], record);
      } else {
        const e = clock(Clock.STEP) - this.first, t = clock(Clock.TIME);
        if (this.sets(e) && !this.rests.has(e)) this.memory.set([t, 0], this.rows.times + 2 * e);
        if (!this.standstill.leaving(e, t) && this.crossed(e, t)) return MORE;
      }
    }
    return "";
  }

  crossed(event, t) {
    this.happened += 1;
    this.motion.events.push({ t, event });
    return this.happened > MOST_EVENTS;
  }

  // An action may have changed parameters before the sample of that number.
  changed(sample, memory) {
    if (!this.rows.setsParameters) return;
    const parameters = memory.slice(this.rows.settings, this.rows.settings + this.rows.parameters);
    this.motion.changes.push({ sample, parameters });
    this.motion.settings.push({ t: memory[this.layout.clock + Clock.TIME], parameters });
  }

  // Do what is to be done at the guard that is due, before the sample of that number; why the motion ends, if so.
  happen(due, sample) {
    const guard = this.rows.guards[due], e = due - this.first;
    if (guard.role === Role.REST) { this.release(due); return ""; }
    if (this.standstill.leaving(e, this.settling.now)) { this.flip(e); return this.recurs(e, this.settling.now); }
    if (this.hasJumped(e)) { this.modes[due] *= -1; return this.recurs(e, this.settling.now); }
    if (this.leavesZero(e)) { this.settling.mark([due]); return this.recurs(e, this.settling.now); }
    if (this.atZero(e) && !this.drivenBack(e) && !this.crossesBack(e)) {
      const held = this.held();
      if (this.rests.has(e)) this.hold(e, this.side(e)); else this.flip(e);
      this.chooseSwitches(held);
      return this.recurs(e, this.settling.now);
    }
    if (this.side(e) * guard.direction > 0) { this.flip(e); return ""; }
    const values = this.allCoefficients().map(([value]) => value), others = this.sets(e) ? this.together(e) : [];
    const atZero = new Map([...others, ...(this.sets(e) ? this.passed(e) : []), e].map((one) => [one, values[one]]));
    const counting = others.filter((one) => this.side(one) * this.rows.guards[one + this.first].direction <= 0);
    const side = this.side(e);
    for (const one of this.inTurn([...counting, e])) {
      if (others.length && this.events[one].impact && this.seriesOf(one)[1] * side >= 0) break; // another action has turned the motion
      const ended = this.done(one, sample, atZero);
      if (ended) return ended;
      if (this.sets(one)) atZero.delete(one); // another action may drive the motion back to it
    }
    return "";
  }

  sets(e) { return this.rows.changed.some(([event]) => event === e); }

  // Of what happens at the same time, records come first, and impacts last; then the file's order counts.
  inTurn(events) {
    const turn = (e) => 2 * this.sets(e) + this.events[e].impact;
    return events.sort((a, b) => turn(a) - turn(b) || a - b);
  }

  // The other events, but impacts, whose arguments become 0 at the same time, from either side.
  together(event) { return this.others(event, (e, ahead) => ahead < 0 && !this.atZero(e)); }

  // Those whose arguments have just passed 0, but which have not acted.
  passed(event) {
    const acted = (e) => this.atOnce(this.memory[this.rows.times + 2 * e]);
    return this.others(event, (e, ahead) => ahead > 0 && this.atZero(e) && !acted(e));
  }

  get noTime() { return SAME * Math.max(Math.abs(this.settling.now), this.settling.clock(Clock.STEP)); }

  atOnce(t) { return Math.abs(this.settling.now - t) <= this.noTime; }

  others(event, chosen) {
    const rows = this.allCoefficients(), time = this.noTime;
    return rows.flatMap(([value, rate], e) => {
      const now = e !== event && !this.events[e].impact && Math.abs(value) <= Math.abs(rate) * time;
      return now && chosen(e, rate * this.side(e)) ? [e] : [];
    });
  }

  // An event happens, and does what it does. Those at 0 now had these values, beside 0, before others happened.
  done(e, sample, atZero = new Map()) {
    if (this.crossed(e, this.settling.now)) return MORE;
    this.released.delete(e);
    if (this.rows.guards[e + this.first].role === Role.RECORD) { this.flip(e); return ""; }
    if (!this.sets(e)) return `${this.name(e)} stops it`;
    return this.act(e, sample, atZero);
  }

  // How the motion is before switches are looked at.
  moving() { return this.standstill.possible ? this.standstill.now() : null; }

  // Do what happens because friction stops the motion, which was as `before`.
  stop(before, sample) {
    const stopped = before ? this.standstill.stopped(before) : [];
    const counting = stopped.filter(([e, side]) => !(side * this.rows.guards[e + this.first].direction > 0));
    for (const e of this.inTurn(counting.map(([event]) => event))) {
      const ended = this.done(e, sample);
      if (ended) return ended;
    }
    return "";
  }

  // Whether its argument is beyond 0 because it jumps, as over the cut of atan2.
  hasJumped(e) {
    const [value, ...others] = this.seriesOf(e), side = this.side(e), length = this.settling.clock(Clock.STEP);
    const { jumps, role } = this.rows.guards[e + this.first];
    if (!(jumps || role === Role.RECORD) || this.atZero(e) || !(value * side < 0)) return false;
    const [size, speed] = this.actOn(this.state(this.memory)).sizes[e];
    const part = jumps ? JUMP : TREMBLES;
    const changes = part * others.reduce((sum, one, k) => sum + Math.abs(one) * length ** (k + 1), 0);
    const time = this.settling.now - this.start, moved = time * (speed + time * this.settling.scale()[1]);
    return -value * side > Math.max(ROUNDING * size, ROUNDING * moved, changes);
  }

  // Whether its argument, which is 0 up to rounding, moves away from 0 to its own side.
  leavesZero(e) {
    const side = this.side(e), [value, rate] = this.seriesOf(e);
    if (!(rate * side > 0)) return false;
    const noise = this.actOn(this.state(this.memory)).sizes[e].map((size) => ROUNDING * size);
    return value * side >= -noise[0] && rate * side > noise[1];
  }

  drivenBack(e) {
    if (this.rows.guards[e + this.first].role === Role.RECORD) return false;
    const rate = this.actOn(this.state(this.memory)).sizes[e][1];
    return this.seriesOf(e)[1] * this.side(e) < -ROUNDING * rate;
  }

  // Whether a crossing that is recorded, and turns back at once, is followed by another one.
  crossesBack(e) { return this.rows.guards[e + this.first].role === Role.RECORD && !this.atOnce(this.chosen[e]); }

  // Change what the event's action changes.
  act(e, sample, atZero) {
    const now = this.settling.now, earlier = this.state(this.memory);
    const length = this.settling.clock(Clock.STEP), side = this.side(e), held = this.held();
    const rows = this.allCoefficients(), { values } = this.actOn(earlier), switches = this.settling.arguments();
    if (!this.put(e, values)) return `the action of ${this.name(e)} gives no finite value`;
    const { masses } = this.actOn(this.state(this.memory));
    if (masses.some((mass) => !(mass > 0))) return `${this.name(e)} makes a mass 0 or negative`;
    this.settling.arguments().forEach((u, j) => { if (u !== switches[j]) this.settling.marks[j] = 0; });
    this.settling.beginSwitches();
    const { sizes } = this.actOn(this.state(this.memory)), later = this.allCoefficients();
    for (const [k, [, rate]] of sizes.entries()) {
      const side = this.side(k);
      if (side === 0 && this.rests.has(k)) this.goOn(k, later[k][1], ROUNDING * rate);
      else if (k === e || atZero.has(k) || side === 0 || later[k][0] !== rows[k][0]) {
        const near = k === e || atZero.has(k) ? 2 * Math.abs(atZero.get(k) ?? rows[k][0]) : 0;
        this.chooseSide(k, later[k], near, rate);
      }
    }
    if (this.standstill.possible) this.standstill.hold();
    const ended = this.recurs(e, now);
    if (!ended && this.rests.has(e) && this.atZero(e)) {
      this.settle({ e, side, earlier, speed: rows[e][1], noise: ROUNDING * sizes[e][1], length });
    }
    this.chooseSwitches(held);
    this.memory.set([now, this.settling.clock(Clock.LOW)], this.rows.times + 2 * e);
    this.changed(sample, this.memory);
    return ended;
  }

  recurs(e, now) {
    const atOnce = now - this.latest <= NO_TIME * Math.max(Math.abs(now), now - this.start);
    this.same = atOnce ? this.same + 1 : 0;
    this.latest = now;
    return this.same >= AGAIN ? `${this.name(e)} happens again and again at the same time` : "";
  }

  // Set what an action sets; whether that is finite.
  put(e, values) {
    const { layout, memory } = this, { outer, degrees } = this.engine.data, motion = 2 * degrees;
    const chosen = this.rows.changed.flatMap(([event, place], i) => (event === e ? [[values[i], place]] : []));
    if (!chosen.every(([value]) => Number.isFinite(value))) return false;
    for (const [value, place] of chosen) {
      if (place < motion) {
        const row = outer[place];
        memory[row] = value;
        memory[layout.width + row] = memory[layout.third + row] = 0;
      } else {
        memory[this.rows.settings + place - motion] = value;
      }
    }
    this.beginAnew();
    return true;
  }

  // Forget what was known of the motion before: momenta follow from velocities.
  beginAnew() {
    const { layout, memory } = this, [from, to] = layout.cyclic;
    for (const start of [0, layout.width, layout.third]) memory.fill(0, start + from, start + to);
    this.settling.forget();
    this.settling.prepare();
  }

  // The side of an event at the state as it is. Up to `noise` its argument is 0; its rate's terms are `rate`.
  chooseSide(e, values, noise, rate) {
    const { settling } = this, j = e + this.first;
    this.chosen[e] = settling.now;
    settling.marks[j] = 0;
    let leads = values[0];
    if (!(Math.abs(leads) > noise)) {
      settling.mark([j]);
      [leads] = this.counting(values, rate);
    }
    settling.modes[j] = (leads ?? -settling.modes[j]) > 0 ? 1 : -1;
    return leads !== undefined;
  }

  // The coefficients behind the first that are more than rounding, where the terms of the rate are as large.
  counting(values, rate) {
    const { settling } = this, speed = this.largestVelocity();
    settling.series();
    const factor = Math.min(rate, speed) > 0 ? rate / speed : 1, scale = settling.scale().map((one) => one * factor);
    const sizes = [rate, ...scale.slice(1, -1).map((one, m) => Math.max(one, scale[m + 2]))];
    return values.slice(1).filter((one, m) => !(Math.abs(one) <= ROUNDING * sizes[m]));
  }

  // Let the motion rest if all further impacts together take no time that counts.
  settle(impact) {
    const { e } = impact, [above, left, bend] = this.seriesOf(e), { times } = this.rows;
    const low = this.settling.clock(Clock.LOW), [last, lastLow] = this.memory.subarray(times + 2 * e);
    const since = this.settling.now - last + (low - lastLow);
    const flight = bend !== 0 ? -left / bend : Infinity;
    if (Math.abs(left) <= impact.noise) {
      this.stopAt(impact, above, left);
      this.hold(e, impact.side);
    } else if (flight > 0 && flight < since && this.side(e) === impact.side) {
      const remaining = flight / (1 - flight / since);
      if (remaining <= this.longest(Math.min(impact.length, this.settling.now - this.start))) {
        this.stopAt(impact, above, left);
        this.hold(e, impact.side);
      }
    }
  }

  // How long all further impacts may take, beside a step of this length.
  longest(length) {
    const { degrees } = this.engine.data;
    const pull = Math.max(0, ...this.settling.series().slice(0, degrees).map(Math.abs));
    return Math.max(SOON * length, SHORT * (pull ? Math.min(length, this.largestVelocity() / pull) : length));
  }

  // The largest velocity; what forces of contact have added up to is none.
  largestVelocity() {
    const { degrees } = this.engine.data, { v } = this.layout;
    return Math.max(0, ...this.memory.subarray(v, v + degrees).map(Math.abs));
  }

  // Take the speed that is `left` away, in the direction of the impact, and put the motion where the argument is
  // 0, `above` which it is by rounding.
  stopAt(impact, above, left) {
    if (left === impact.speed) return;
    const { layout, memory } = this, { outer, degrees } = this.engine.data;
    for (let k = degrees; k < 2 * degrees; k++) {
      const row = outer[k], change = memory[row] - impact.earlier[k];
      if (change === 0) continue;
      for (const [one, lost] of [[outer[k - degrees], above], [row, left]]) {
        memory[one] -= change / (left - impact.speed) * lost;
        memory[layout.width + one] = memory[layout.third + one] = 0;
      }
    }
    this.beginAnew();
  }

  // Rest at an event, if the force that holds the motion pushes to the `side` that it came from.
  hold(e, side) {
    const { settling, modes } = this, j = e + this.first, rest = this.rests.get(e);
    [modes[rest], modes[j]] = [side, 0];
    settling.series();
    const force = settling.coefficients(this.rows.guards[rest].row)[0];
    if (!(force * side > 0)) {
      [modes[rest], modes[j]] = [0, side];
      settling.mark([j]);
      settling.prepare();
    }
  }

  // Rest on after another event's action, if that has given the motion no `speed` here.
  goOn(e, speed, noise) {
    const { settling, modes } = this, j = e + this.first, rest = this.rests.get(e), side = modes[rest];
    [modes[rest], modes[j]] = [0, side];
    settling.mark([j]);
    if (speed * side < -noise) settling.marks[j] = 0;
    if (Math.abs(speed) <= noise) this.hold(e, side); else settling.prepare();
  }

  // End a contact: the force that holds the motion would have to pull.
  release(rest) {
    const e = [...this.rests].find(([, one]) => one === rest)[0], j = e + this.first, { modes } = this;
    [modes[j], modes[rest]] = [modes[rest], 0];
    this.settling.mark([j]);
    this.released.add(e);
    this.beginAnew();
    this.settling.beginSwitches();
  }
}
