// A motion that was computed before: the samples of a file.

class Recorded {
  // `table` has the rows t, q, v and what was observed, `count` numbers each. The motion begins with `parameters`,
  // and `member.settings` says what actions have set.
  constructor(engine, member, table, parameters) {
    const { degrees } = engine.data;
    Object.assign(this, { engine, member, table, count: member.count, ended: true, reason: member.reason ?? "" });
    Object.assign(this, { events: [], steps: 0, observed: member.count, done: member.count, failed: false });
    this.settings = settingsOf(engine, member.settings, parameters);
    if (engine.data.points) {
      engine.reserve(this.count);
      engine.at(engine.times, this.count).set(this.times);
      for (let k = 0; k < degrees; k++) engine.at(engine.states + 8 * k * engine.stride, this.count).set(this.q(k));
      this.traceAll();
    }
  }

  // The places of all samples, piece by piece with the parameters of each.
  traceAll() {
    const { engine, times, count } = this, { stride, places } = engine;
    for (let from = 0; from < count;) {
      const parameters = this.parametersAt(times[from]), shift = 8 * from;
      let to = from + 1;
      while (to < count && this.parametersAt(times[to]) === parameters) to += 1;
      engine.ready(parameters);
      engine.call.place(
        places.placing, engine.times + shift, engine.states + shift, engine.traced + shift, BigInt(stride), BigInt(to - from));
      from = to;
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
  parametersAt(t) { return parametersAt(this.settings, t); }
  ready(t) { this.engine.ready(this.parametersAt(t)); }
  points(t) { this.ready(t); return this.engine.place(t, this.stateAt(t).q); }
  compute() { return true; }
}

// All parameters, from when on.
function settingsOf(engine, { times, changed } = { times: [], changed: {} }, parameters) {
  const places = Object.keys(changed).map((name) => [engine.data.parameters.indexOf(name), changed[name]]);
  const found = times.map((t, i) => {
    const own = Array.from(parameters);
    for (const [k, values] of places) own[k] = values[i];
    return { t, parameters: own };
  });
  return [{ t: -Infinity, parameters }, ...found];
}
