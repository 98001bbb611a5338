// The drawing on a canvas, in the plane; in space as well where a browser has no WebGL: what is farther away is
// painted first.

const TRAIL = 700, PIECE = 12;
const CURVE = 129, MESH = 17;
const NEAR_DOT = 26;
const EDGE = 24;
const SAMPLED = 500;
const CROWD = 100;

class Scene {
  constructor(canvas, drawing, engine) {
    Object.assign(this, { canvas, drawing, engine });
    this.dimension = drawing?.dimension ?? 2;
    this.home = { azimuth: drawing?.camera.azimuth ?? 0, elevation: drawing?.camera.elevation ?? 0, zoom: 1, x: 0, y: 0 };
    this.trails = true;
    this.sizes = [];
    this.open();
    this.reset();
  }

  open() { this.pen = this.canvas.getContext("2d"); }
  reset() { this.view = { ...this.home }; this.bounds = this.drawing?.camera.bounds ?? null; }

  // For other parameters: lengths change, and what stands still is elsewhere.
  begin(parameters) {
    this.sizes = this.engine.measure(parameters);
    this.still = new Map();
    const solids = this.drawing?.solids ?? [];
    this.faces = solids.map((one) => facesOf(one.shape, one.sizes.map((k) => this.sizes[k])));
    const masses = (this.drawing?.dots ?? []).flatMap((one) => (one.mass === null ? [] : [this.sizes[one.mass]]));
    this.heaviest = Math.max(...masses, 1e-300);
  }

  // Let all of a motion be seen: bounds grow with it.
  include(motion) {
    if (!this.drawing || !this.bounds || !motion.observed) return;
    if (this.drawing.camera.follow === null) this.grow(motion);
    if (this.dimension === 3) this.span = this.reach(motion);
  }

  grow(motion) {
    const [least, greatest] = this.bounds.map((one) => [...one]), each = Math.max(1, Math.floor(motion.observed / SAMPLED));
    for (const place of this.drawing.places) {
      this.rows(motion, place).forEach((row, k) => {
        if (this.drawing.camera.window[k]) return;
        for (let i = 0; i < row.length; i += each) {
          if (row[i] < least[k]) least[k] = row[i];
          if (row[i] > greatest[k]) greatest[k] = row[i];
        }
      });
    }
    if ([...least, ...greatest].every(Number.isFinite)) this.bounds = [least, greatest];
  }

  rows(motion, point) { return Array.from({ length: this.dimension }, (_, k) => motion.trace(this.dimension * point + k)); }

  // In space, how far all that is seen reaches from the vertical line through the middle, and from the plane across
  // it: this is seen from all sides. Null where the file says what is seen.
  reach(motion) {
    const { camera, places, solids, curves } = this.drawing;
    if (camera.window.some((one) => one)) return null;
    const up = this.upward, [a, b] = [0, 1, 2].filter((k) => k !== up), middle = this.middle();
    const half = this.bounds[1].map((one, k) => one - middle[k]), across = Math.hypot(half[a], half[b]);
    const found = [0.1 * across, 0.1 * half[up]];
    const put = (x, y, z, size) => { // what is within the bounds
      const side = Math.hypot(x, y), high = Math.abs(z);
      if (side <= 1.01 * across && side + size > found[0]) found[0] = side + size;
      if (high <= 1.01 * half[up] && high + size > found[1]) found[1] = high + size;
    };
    const from = camera.follow === null ? null : this.rows(motion, camera.follow);
    const each = Math.max(1, Math.floor(motion.observed / SAMPLED)), part = (row, k, i) => row[k][i] - middle[k] - (from ? from[k][i] : 0);
    for (const place of places) {
      const row = this.rows(motion, place), number = solids.findIndex((one) => one.centre === place);
      const size = number < 0 ? 0 : Math.max(...this.faces[number].flat().map((corner) => Math.hypot(...corner)));
      for (let i = 0; i < motion.observed; i += each) put(part(row, a, i), part(row, b, i), part(row, up, i), size);
    }
    const first = curves.length && motion.stateAt(motion.first);
    if (!from) {
      curves.forEach((curve, i) => this.lines(curve, i, motion.first, first.q).flat().forEach((spot) => {
        put(spot[a] - middle[a], spot[b] - middle[b], spot[up] - middle[up], 0);
      }));
    }
    return found.every(Number.isFinite) && found[0] + found[1] > 0 ? found : null;
  }

  get upward() { return this.drawing.up === "y" ? 1 : 2; }
  middle() { return this.bounds[0].map((one, k) => (one + this.bounds[1][k]) / 2); }

  resize() {
    const ratio = window.devicePixelRatio || 1, { clientWidth, clientHeight } = this.canvas;
    const [width, height] = [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)];
    [this.width, this.height, this.ratio] = [clientWidth, clientHeight, ratio];
    if (this.canvas.width !== width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [width, height];
  }

  // The axes of what is seen, and how large it is.
  aim(points) {
    const d = this.dimension, follow = this.drawing.camera.follow;
    this.bounds ??= [Array(d).fill(-1), Array(d).fill(1)];
    const middle = this.middle(), greatest = this.bounds[1];
    this.centre = follow === null ? middle : middle.map((one, k) => one + points[d * follow + k]);
    const corners = Array.from({ length: 2 ** d }, (_, i) => middle.map((one, k) => (i >> k & 1 ? 1 : -1) * (greatest[k] - one)));
    let seen = corners;
    if (d === 2) {
      this.axes = [[1, 0], [0, this.drawing.up === "-y" ? -1 : 1]];
      this.far = Infinity;
    } else {
      const a = this.view.azimuth * Math.PI / 180, e = this.view.elevation * Math.PI / 180;
      const [ca, sa, ce, se] = [Math.cos(a), Math.sin(a), Math.cos(e), Math.sin(e)];
      const turned = ([x, y, z]) => (this.drawing.up === "y" ? [y, z, x] : [x, y, z]);
      this.axes = [turned([-sa, ca, 0]), turned([-se * ca, -se * sa, ce]), turned([ce * ca, ce * sa, se])];
      this.far = 5 * Math.max(...corners.map((one) => Math.hypot(...one))) || 1;
      if (this.span) { // the rims of a drum, where they are widest and where they are nearest
        const [side, high] = this.span, rim = (x, y, z) => turned([x * ca - y * sa, x * sa + y * ca, z]);
        seen = [high, -high].flatMap((z) => [rim(side, 0, z), rim(-side, 0, z), rim(0, side, z), rim(0, -side, z)]);
      }
    }
    const [w, h] = [0, 1].map((k) => 2 * Math.max(...seen.map((one) => Math.abs(this.flat(one)[k])), 1e-300));
    const margin = d === 3 ? 2 * EDGE : EDGE;
    this.scale = Math.min((this.width - margin) / w, (this.height - margin) / h) * this.view.zoom;
  }

  // A vector from the centre, along the axes of the picture; with its depth in space.
  flat(r) {
    const along = this.axes.map((axis) => axis.reduce((sum, one, k) => sum + one * r[k], 0));
    if (this.dimension === 2) return [along[0], along[1], 0];
    const s = this.far / Math.max(this.far - along[2], this.far / 10);
    return [along[0] * s, along[1] * s, along[2]];
  }

  onPaper(place) {
    const [x, y, depth] = this.flat(place.map((one, k) => one - this.centre[k]));
    return [this.width / 2 + this.view.x + this.scale * x, this.height / 2 + this.view.y - this.scale * y, depth];
  }

  at(points, number) {
    const d = this.dimension;
    return Array.from({ length: d }, (_, k) => points[d * number + k]);
  }

  draw(motion, t) {
    this.resize();
    if (!this.drawing || !motion.observed) { this.clear(); return; }
    const state = motion.stateAt(t);
    motion.ready(t);
    if (this.standing !== this.engine.prepared) [this.standing, this.still] = [this.engine.prepared, new Map()];
    this.points = Float64Array.from(this.engine.place(t, state.q));
    this.aim(this.points);
    this.show(motion, t, state.q);
  }

  clear() {
    this.pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.pen.clearRect(0, 0, this.width, this.height);
  }

  show(motion, t, q) {
    this.clear();
    this.items = [];
    this.paintGrid();
    if (this.trails) for (const number of this.drawing.trails) this.addTrail(this.trail(motion, t, number));
    this.drawing.curves.forEach((curve, i) => this.addLines(this.lines(curve, i, t, q), curve));
    this.drawing.solids.forEach((solid, i) => this.addSolid(solid, i));
    for (const rod of this.drawing.rods) this.addLine(rod, false);
    for (const spring of this.drawing.springs) this.addLine(spring, true);
    for (const pivot of this.drawing.pivots) this.addPivot(pivot);
    for (const dot of this.drawing.dots) this.addDot(dot);
    if (this.dimension === 3) this.items.sort((a, b) => a.depth - b.depth);
    for (const item of this.items) item.paint();
    if (this.dimension === 3) this.paintTriad();
  }

  add(depth, paint) { if (Number.isFinite(depth)) this.items.push({ depth, paint }); }
  nearer(depth, part) { return this.dimension === 3 ? depth + part * this.far : depth; }
  tint(group, own) { return own || colour(`c${group % 8}`); }

  path(corners, closed = false) {
    this.pen.beginPath();
    corners.forEach(([x, y], i) => (i ? this.pen.lineTo(x, y) : this.pen.moveTo(x, y)));
    if (closed) this.pen.closePath();
  }

  // In space, the floor below all that moves.
  paintFloor() {
    const { pen } = this, up = this.upward, [a, b] = up === 1 ? [0, 2] : [0, 1];
    if (!this.bounds || this.drawing.camera.follow !== null) return;
    const [least, greatest] = this.bounds, half = Math.max(greatest[a] - least[a], greatest[b] - least[b]) / 2;
    const ends = [a, b].map((k) => [(least[k] + greatest[k]) / 2 - half, (least[k] + greatest[k]) / 2 + half]);
    const spot = (x, y) => { const place = []; place[a] = x; place[b] = y; place[up] = this.axes[1][up] < 0 ? greatest[up] : least[up]; return this.onPaper(place); };
    pen.strokeStyle = colour("grid");
    pen.lineWidth = 1;
    for (let i = 0; i <= 8; i++) {
      const [x, y] = ends.map(([low, high]) => low + (high - low) * i / 8);
      for (const line of [[spot(x, ends[1][0]), spot(x, ends[1][1])], [spot(ends[0][0], y), spot(ends[0][1], y)]]) {
        this.path(line);
        pen.stroke();
      }
    }
  }

  paintGrid() {
    if (this.dimension === 3) { this.paintFloor(); return; }
    const { pen, width, height } = this, ink = colour("grid"), text = colour("soft");
    if (!this.drawing.scaled) return;
    const x = (one) => this.onPaper([one, 0])[0], y = (one) => this.onPaper([0, one])[1];
    const [left, right] = [0, width].map((one) => this.centre[0] + (one - width / 2 - this.view.x) / this.scale);
    const [low, high] = [height, 0].map((one) => this.centre[1] - this.axes[1][1] * (one - height / 2 - this.view.y) / this.scale).sort((a, b) => a - b);
    pen.lineWidth = 1;
    pen.strokeStyle = ink;
    pen.fillStyle = text;
    pen.font = "11px system-ui, sans-serif";
    const [across, upward] = [ticks(left, right, width / 90), ticks(low, high, height / 90)];
    for (const one of across) this.path([[x(one), 0], [x(one), height]]), pen.stroke();
    for (const one of upward) this.path([[0, y(one)], [width, y(one)]]), pen.stroke();
    pen.textAlign = "center";
    for (const one of across) if (x(one) > 30 && x(one) < width - 20) pen.fillText(tickText(one, across), x(one), height - 5);
    pen.textAlign = "left";
    for (const one of upward) if (y(one) > 14 && y(one) < height - 18) pen.fillText(tickText(one, upward), 4, y(one) - 3);
  }

  paintTriad() {
    const { pen, height } = this, size = 26, [x, y] = [40, height - 40];
    pen.font = "12px system-ui, sans-serif";
    pen.lineWidth = 1.5;
    [..."xyz"].forEach((name, k) => {
      const [a, b] = [this.axes[0][k], this.axes[1][k]];
      pen.strokeStyle = pen.fillStyle = colour("soft");
      this.path([[x, y], [x + size * a, y - size * b]]);
      pen.stroke();
      pen.textAlign = "center";
      pen.fillText(name, x + (size + 9) * a, y - (size + 9) * b + 4);
    });
  }

  // Where a point has been, up to now; seen from the point that is followed, if there is one.
  trail(motion, t, number) {
    const { follow } = this.drawing.camera, last = before(motion.times, t), first = Math.max(0, last - TRAIL);
    const rows = this.rows(motion, number), from = follow === null ? null : this.rows(motion, follow);
    const here = from && this.at(this.points, follow), places = [];
    for (let i = first; i <= last; i++) places.push(rows.map((row, k) => (from ? row[i] - from[k][i] + here[k] : row[i])));
    places.push(this.at(this.points, number));
    const dot = this.drawing.dots.find((one) => one.point === number);
    return { places, ink: this.tint(dot?.group ?? 0, dot?.colour ?? ""), strength: (i) => 0.08 + 0.62 * (i / places.length) ** 2 };
  }

  addTrail({ places, ink, strength }) {
    const { pen } = this, spots = places.map((one) => this.onPaper(one));
    for (let i = 0; i + 1 < spots.length; i += PIECE) {
      const piece = spots.slice(i, i + PIECE + 1);
      this.add(piece[piece.length >> 1][2], () => {
        pen.globalAlpha = strength(i);
        pen.strokeStyle = ink;
        pen.lineWidth = 1.6;
        this.path(piece);
        pen.stroke();
        pen.globalAlpha = 1;
      });
    }
  }

  // A curve as a line of places; a surface as lines along its two coordinates, in turns.
  lines(curve, number, t, q) {
    const moves = curve.depends.length > 0 || curve.on_time;
    if (!moves && this.still.has(number)) return this.still.get(number);
    const count = curve.along.length === 1 ? CURVE : MESH, state = Array.from(q), lines = [];
    const runs = curve.ranges.map(([low, high], k) => (i) => { state[curve.along[k]] = low + (high - low) * i / (count - 1); });
    const spot = () => this.at(this.engine.place(t, state), curve.point);
    const line = (run) => Array.from({ length: count }, (_, i) => { run(i); return spot(); });
    if (runs.length === 1) lines.push(line(runs[0]));
    for (let i = 0; runs.length === 2 && i < count; i++) {
      runs[0](i);
      lines.push(line(runs[1]));
      runs[1](i);
      lines.push(line(runs[0]));
    }
    if (!moves) this.still.set(number, lines);
    return lines;
  }

  addLines(lines, curve) {
    const { pen } = this, mesh = curve.along.length > 1;
    for (const line of lines) {
      const spots = line.map((one) => this.onPaper(one)), length = this.dimension === 3 ? 8 : spots.length;
      for (let i = 0; i + 1 < spots.length; i += length) {
        const piece = spots.slice(i, i + length + 1).filter((one) => one.every(Number.isFinite));
        if (piece.length < 2) continue;
        this.add(piece[piece.length >> 1][2], () => {
          pen.strokeStyle = curve.colour || colour("soft");
          pen.globalAlpha = mesh ? 0.35 : 0.8;
          pen.lineWidth = mesh ? 0.8 : 1.4;
          this.path(piece);
          pen.stroke();
          pen.globalAlpha = 1;
        });
      }
    }
  }

  addSolid(solid, number) {
    const centre = this.at(this.points, solid.centre), axes = solid.axes.map((one) => this.at(this.points, one));
    const place = (corner) => centre.map((one, k) => one + axes[0][k] * corner[0] + axes[1][k] * corner[1] + axes[2][k] * corner[2]);
    const { pen } = this, ink = this.tint(solid.group, solid.colour);
    for (const [i, face] of this.faces[number].entries()) {
      const spots = face.map((corner) => this.onPaper(place(corner)));
      const whole = face.length > 4, depth = spots.reduce((sum, one) => sum + one[2], 0) / spots.length;
      const normal = this.normal(face.slice(0, 3).map(place));
      const light = 0.55 + 0.45 * Math.abs(normal[0] * 0.35 + normal[1] * 0.75 + normal[2] * 0.55);
      this.add(depth, () => {
        this.path(spots, true);
        pen.fillStyle = ink;
        pen.fill();
        if (striped(solid.shape, i)) { // so that one sees it turn
          pen.fillStyle = "rgba(255, 255, 255, 0.45)";
          pen.fill();
        }
        pen.fillStyle = `rgba(0, 0, 0, ${(1 - light).toFixed(3)})`;
        pen.fill();
        pen.lineWidth = 0.8;
        pen.strokeStyle = whole || face.length === 4 && this.faces[number].length === 6 ? "rgba(0, 0, 0, 0.45)" : "rgba(0, 0, 0, 0.05)";
        pen.stroke();
        if (whole) {
          this.path([this.onPaper(place([0, 0, face[0][2]])), spots[0]]);
          pen.lineWidth = 2;
          pen.stroke();
        }
      });
    }
  }

  // The normal of a face along the axes of the picture.
  normal([a, b, c]) {
    const [u, v] = [b, c].map((one) => one.map((x, k) => x - a[k]));
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const size = Math.hypot(...n) || 1;
    return this.axes.map((axis) => axis.reduce((sum, one, k) => sum + one * n[k] / size, 0));
  }

  addLine(line, spring) {
    const [a, b] = line.ends.map((end) => this.onPaper(this.at(this.points, end))), { pen } = this;
    this.add((a[2] + b[2]) / 2, () => {
      pen.strokeStyle = line.colour || colour(spring || line.thin ? "soft" : "ink");
      pen.lineWidth = spring || line.thin ? 1.5 : 2.4;
      pen.lineCap = pen.lineJoin = "round";
      this.path(spring ? coil(a, b) : [a, b]);
      pen.stroke();
    });
  }

  addPivot(pivot) {
    const [x, y, depth] = this.onPaper(this.at(this.points, pivot.point)), { pen } = this;
    this.add(this.nearer(depth, 1e-3), () => {
      pen.fillStyle = colour("paper");
      pen.strokeStyle = colour("ink");
      pen.lineWidth = 1.8;
      pen.beginPath();
      pen.arc(x, y, 4, 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
    });
  }

  radius(dot) {
    if (dot.mass === null) return 6;
    const many = this.drawing.dots.length > 40 ? 0.5 : 1;
    return many * Math.max(3.5, 12 * Math.cbrt(this.sizes[dot.mass] / this.heaviest));
  }

  addDot(dot) {
    const [x, y, depth] = this.onPaper(this.at(this.points, dot.point)), { pen } = this, r = this.radius(dot);
    this.add(this.nearer(depth, 2e-3), () => {
      pen.fillStyle = this.tint(dot.group, dot.colour);
      pen.strokeStyle = colour("paper");
      pen.lineWidth = 1.2;
      pen.beginPath();
      pen.arc(x, y, r, 0, 2 * Math.PI);
      pen.fill();
      if (this.drawing.dots.length <= CROWD) pen.stroke(); // else edges would hide what they are around
      if (!dot.label) return;
      pen.font = "13px system-ui, sans-serif";
      pen.fillStyle = colour("soft");
      pen.textAlign = "left";
      pen.fillText(dot.label.split(", ").map((name) => pretty(name)).join(", "), x + r + 5, y - r);
    });
  }

  // What can be taken hold of near a place on the paper: a dot or a solid, by its point.
  grasp(x, y) {
    if (!this.drawing || !this.points) return null;
    const able = [...this.drawing.dots.map((one) => one.point), ...this.drawing.solids.map((one) => one.centre)];
    let [found, least] = [null, NEAR_DOT];
    for (const point of able) {
      const [a, b] = this.onPaper(this.at(this.points, point)), away = Math.hypot(a - x, b - y);
      if (away < least) [found, least] = [point, away];
    }
    return found;
  }
}

// A spring between two places on the paper.
function coil([ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay], length = Math.hypot(dx, dy) || 1;
  const [nx, ny] = [-dy / length, dx / length], turns = 9, wide = Math.min(8, length / 5), found = [[ax, ay]];
  for (let i = 0; i <= 2 * turns; i++) {
    const s = 0.12 + 0.76 * i / (2 * turns), side = i === 0 || i === 2 * turns ? 0 : (i % 2 ? wide : -wide);
    found.push([ax + s * dx + side * nx, ay + s * dy + side * ny]);
  }
  return [...found, [bx, by]];
}
