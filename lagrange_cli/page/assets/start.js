// The values that a motion begins with: those of the file, and what the reader has changed.

const PASSES = 40;

class Start {
  constructor(data, engine) {
    this.data = data;
    this.engine = engine;
    this.names = data.parameters.map((one) => one.name);
    this.stateNames = [...data.coordinates.map((one) => one.name), ...data.velocities];
    this.reset();
  }

  reset() {
    this.changed = new Map();
    this.note = "";
    this.settle();
  }

  // All values of a member of a sweep.
  take(values) {
    this.changed = new Map(Object.entries(values));
    this.settle();
  }

  set(name, value) { this.changed.set(name, value); this.settle(); }

  // Parameters and state, as they follow from what is given. Without changes they are the numbers of the file.
  // What was `dragged` is moved with the rest to where the constraints hold.
  settle(dragged = false) {
    const { data, engine, changed } = this, n = data.coordinates.length;
    this.stop = changed.get(STOP) ?? data.time.stop;
    this.parameters = data.parameters.map((one) => one.value);
    this.q = data.coordinates.map((one) => one.q);
    this.v = data.coordinates.map((one) => one.v);
    this.note = "";
    const moved = [...changed.keys()].some((name) => name !== STOP);
    if (!moved) return;
    if (this.names.some((name) => changed.has(name))) this.followParameters();
    const pinned = [];
    for (const [i, name] of this.stateNames.entries()) {
      if (!changed.has(name)) continue;
      const value = changed.get(name);
      if (i < n) this.q[i] = value; else this.v[i - n] = value;
      pinned.push([i < n ? i : engine.data.layout.v + i - n, value]);
    }
    const found = engine.satisfy(data.time.start, this.parameters, this.q, this.v, dragged ? [] : pinned);
    if (found.good) [this.q, this.v] = [found.q, found.v];
    else this.note = "No start with these values satisfies the constraints.";
    if (dragged) data.coordinates.forEach((one, k) => changed.set(one.name, this.q[k]));
  }

  // What the file gives as an expression in parameters follows them, unless the reader has given it.
  followParameters() {
    const { data, engine, changed } = this, count = this.names.length, n = data.coordinates.length;
    const given = (i) => changed.get(this.names[i]);
    let found = [];
    for (let pass = 0; pass < Math.min(PASSES, count + 1); pass++) {
      this.names.forEach((name, i) => {
        if (changed.has(name)) this.parameters[i] = given(i);
        else if (pass > 0 && data.parameters[i].expression) this.parameters[i] = found[i];
      });
      const next = engine.derive(this.parameters);
      const settled = pass > 0 && next.every((one, i) => Object.is(one, found[i]));
      found = next;
      if (settled) break;
    }
    data.coordinates.forEach((one, k) => {
      if (one.expressions[0]) this.q[k] = found[count + k];
      if (one.expressions[1]) this.v[k] = found[count + n + k];
    });
  }
}

// The coordinates that move something, which ``place`` finds at a state: sets of them that do not move it are left out
// whole. So a member of a family of N takes some 2 log N places, and not N.
function moving(place, q) {
  const size = Math.max(1, ...q.map(Math.abs)), here = place(q);
  const among = (first, last) => {
    const other = q.slice();
    for (let k = first; k < last; k++) other[k] += size * (0.1 + 0.1 * Math.random());
    if (place(other).every((value, i) => value === here[i])) return [];
    if (last - first === 1) return [first];
    const middle = (first + last) >> 1;
    return [...among(first, middle), ...among(middle, last)];
  };
  return q.length ? among(0, q.length) : [];
}

// The state for which a point of the drawing is at a place on the paper, as nearly as it can be: Gauss and Newton's
// method, by the shortest way in q.
function reaching(scene, engine, point, [x, y], t, from) {
  const q = Array.from(from), d = scene.dimension, size = Math.max(1, ...q.map(Math.abs));
  const placed = (state) => {
    const points = engine.place(t, state);
    return Array.from({ length: d }, (_, k) => points[d * point + k]);
  };
  const seen = (state) => {
    const spot = scene.onPaper(placed(state));
    return [spot[0] / scene.scale, spot[1] / scene.scale];
  };
  const moved = moving(placed, q);
  const goal = [x / scene.scale, y / scene.scale];
  let [here, away] = [seen(q), Infinity];
  for (let pass = 0; pass < 30; pass++) {
    const rest = [goal[0] - here[0], goal[1] - here[1]], left = Math.hypot(...rest);
    if (!(left < away) || left * scene.scale < 0.3) break;
    away = left;
    const slopes = moved.map((k) => {
      const step = 1e-6 * size, other = q.slice();
      other[k] += step;
      const there = seen(other);
      return [(there[0] - here[0]) / step, (there[1] - here[1]) / step];
    });
    let [a, b, c] = [0, 0, 0];
    for (const [u, w] of slopes) [a, b, c] = [a + u * u, b + u * w, c + w * w];
    const damping = 1e-3 * (a + c) || 1e-12;
    const det = (a + damping) * (c + damping) - b * b;
    const weights = [((c + damping) * rest[0] - b * rest[1]) / det, ((a + damping) * rest[1] - b * rest[0]) / det];
    const change = slopes.map(([u, w]) => u * weights[0] + w * weights[1]);
    for (let part = 1; part > 1e-3; part /= 2) { // no farther than it gets nearer
      const tried = q.slice();
      moved.forEach((k, i) => { tried[k] += part * change[i]; });
      const there = seen(tried);
      if (Math.hypot(goal[0] - there[0], goal[1] - there[1]) < away) {
        tried.forEach((value, k) => { q[k] = value; });
        here = there;
        break;
      }
    }
  }
  return q;
}
