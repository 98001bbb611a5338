// A motion that was computed before: the samples of a file.

class Recorded {
  // `table` has the rows t, q, v and what was observed, `count` numbers each.
  constructor(engine, member, table, parameters) {
    const { degrees } = engine.data;
    Object.assign(this, { engine, member, table, parameters, count: member.count, ended: true, reason: member.reason ?? "" });
    Object.assign(this, { events: [], steps: 0, observed: member.count, done: member.count, failed: false });
    engine.prepare(parameters);
    if (engine.data.points) {
      engine.reserve(this.count);
      engine.at(engine.times, this.count).set(this.times);
      for (let k = 0; k < degrees; k++) engine.at(engine.states + 8 * k * engine.stride, this.count).set(this.q(k));
      engine.call.place(
        engine.places.placing, engine.times, engine.states, engine.traced, BigInt(engine.stride), BigInt(this.count));
    }
  }

  row(k) { return this.table.subarray(k * this.count, (k + 1) * this.count); }
  get times() { return this.row(0); }
  get start() { return this.times[0] ?? 0; }
  get first() { return this.start; }
  get stop() { return this.times[this.count - 1] ?? 0; }
  get last() { return this.stop; }
  q(k) { return this.row(1 + k); }
  v(k) { return this.row(1 + this.engine.data.degrees + k); }
  quantity(k) { return this.row(1 + 2 * this.engine.data.degrees + k); }
  trace(k) { return this.engine.at(this.engine.traced + 8 * k * this.engine.stride, this.count); }
  stateAt(t) { return interpolated(this, t, this.engine.data.degrees); }
  ready(t) { this.engine.ready(this.parameters); }
  points(t) { this.ready(t); return this.engine.place(t, this.stateAt(t).q); }
  compute() { return true; }
}
