// The drawing in space, by three.js. What is seen, and from where, is the Scene's; here it is made solid.
//
// All is given in the axes of the picture, from the middle, in units of the eye's distance. So numbers are neither
// large nor small, and the camera stands still at (0, 0, 1).

const ROD = 2, WIRE = 0.9, PIVOT = 4.5;           // radii in pixels
const AROUND = 8, TURNS = 9, BENDS = 14;          // of a tube; of a spring, and of each of its turns
const FLOOR = 1.5, SURFACE = 0.22, STRIPE = 0.6;
// Strokes of x, y and z.
const LETTERS = [[[-1, 1, 1, -1], [-1, -1, 1, 1]], [[-1, 1, 0, -1], [1, 1, -1, -3]], [[-1, 1, 1, 1], [1, 1, -1, -1], [-1, -1, 1, -1]]];

// A mesh whose corners are given anew for each picture.
class Sheet {
  constructor(stage, material, order) {
    this.lit = material.isMeshLambertMaterial;
    this.mesh = new THREE.Mesh(new THREE.BufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = order;
    stage.add(this.mesh);
    this.clear();
  }

  clear() { [this.rows, this.count, this.corners] = [{ position: [], color: [], ...(this.lit && { normal: [] }) }, 0, []]; }

  put(place, normal, ink, strength = 1) {
    this.rows.position.push(...place);
    this.rows.normal.push(...normal);
    this.rows.color.push(ink.r, ink.g, ink.b, strength);
    return this.count++;
  }

  // Two triangles for each quadrilateral.
  quad(a, b, c, d) { this.corners.push(a, b, c, a, c, d); }

  finish() {
    const { geometry } = this.mesh, kept = geometry.getAttribute("position")?.count ?? 0;
    if (this.count > kept || this.corners.length > (geometry.index?.count ?? 0)) {
      geometry.dispose(); // what is too small for a picture is made twice as large
      for (const name of Object.keys(this.rows)) {
        const size = name === "color" ? 4 : 3;
        geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(2 * size * this.count), size));
      }
      geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(2 * this.corners.length), 1));
    }
    for (const [name, row] of Object.entries(this.rows)) if (row.length) refill(geometry.getAttribute(name), row);
    if (this.corners.length) refill(geometry.index, this.corners);
    geometry.setDrawRange(0, this.corners.length);
    this.mesh.visible = this.corners.length > 0;
  }
}

function refill(attribute, numbers) {
  attribute.array.set(numbers);
  attribute.needsUpdate = true;
}

// The same body at many places.
class Copies {
  constructor(stage, geometry, count) {
    this.mesh = new THREE.InstancedMesh(geometry, new THREE.MeshLambertMaterial(), Math.max(1, count));
    this.mesh.frustumCulled = false;
    this.mesh.count = count;
    this.mesh.visible = count > 0;
    this.matrix = new THREE.Matrix4();
    stage.add(this.mesh);
  }

  // `axes` are the columns of the matrix.
  put(number, axes, place, ink) {
    this.mesh.setMatrixAt(number, framed(this.matrix, axes, place));
    this.mesh.setColorAt(number, ink);
    this.mesh.instanceMatrix.needsUpdate = this.mesh.instanceColor.needsUpdate = true;
  }
}

function framed(matrix, [a, b, c], p) {
  return matrix.set(a[0], b[0], c[0], p[0], a[1], b[1], c[1], p[1], a[2], b[2], c[2], p[2], 0, 0, 0, 1);
}

function cross(a, b) { return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]; }
function scaled(a, factor) { return a.map((one) => one * factor); }
function moved(a, b, factor = 1) { return a.map((one, k) => one + factor * b[k]); }
function unit(a) { return scaled(a, 1 / (Math.hypot(...a) || 1)); }

// Two directions across one.
function across(along) {
  const side = unit(cross(along, Math.abs(along[2]) < 0.9 * Math.hypot(...along) ? [0, 0, 1] : [0, 1, 0]));
  return [side, unit(cross(along, side))];
}

// The faces of a body (shapes.js) in units of its size, with normals outward: round ones are smooth.
function bodyOf(shape, faces, size) {
  const position = [], normal = [], color = [], edges = [], round = shape === "sphere" ? [1, 1, 1] : shape === "box" ? null : [1, 1, 0];
  faces.forEach((face, number) => {
    const [a, b, c] = face, flat = unit(cross(moved(b, a, -1), moved(c, a, -1)));
    const smooth = round && face.length === 4, out = a.reduce((sum, one, k) => sum + one * flat[k], 0) < 0 ? -1 : 1;
    const shade = striped(shape, number) ? STRIPE : 1;
    for (let i = 1; i + 1 < face.length; i++) {
      for (const corner of out > 0 ? [a, face[i], face[i + 1]] : [a, face[i + 1], face[i]]) {
        position.push(...scaled(corner, 1 / size));
        normal.push(...(smooth ? unit(corner.map((one, k) => one * round[k])) : scaled(flat, out)));
        color.push(shade, shade, shade);
      }
    }
    if (smooth) return;
    face.forEach((corner, i) => edges.push(...scaled(corner, 1 / size), ...scaled(face[(i + 1) % face.length], 1 / size)));
    if (round) edges.push(0, 0, a[2] / size, ...scaled(a, 1 / size)); // so that one sees it turn
  });
  return { body: geometryOf({ position, normal, color }), edges: geometryOf({ position: edges }) };
}

function geometryOf(rows) {
  const geometry = new THREE.BufferGeometry();
  for (const [name, row] of Object.entries(rows)) geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(row), 3));
  return geometry;
}

class Space extends Scene {
  open() {
    const { canvas, drawing } = this, context = canvas.getContext("webgl2");
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.stage = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera();
    this.camera.position.z = 1;
    const lamp = new THREE.DirectionalLight(0xffffff, 2.4);
    lamp.position.set(-0.5, 0.9, 0.8);
    this.stage.add(lamp, new THREE.AmbientLight(0xffffff, 1.3));
    const ball = bodyOf("ball", facesOf("sphere", [1]), 1).body, drum = bodyOf("cylinder", facesOf("cylinder", [1, 1]), 1).body;
    this.dots = new Copies(this.stage, bodyOf("sphere", facesOf("sphere", [1]), 1).body, drawing.dots.length);
    this.pivots = new Copies(this.stage, ball, drawing.pivots.length);
    this.rods = new Copies(this.stage, drum, drawing.rods.length);
    const lit = { vertexColors: true }, faint = { vertexColors: true, transparent: true, depthWrite: false, side: THREE.DoubleSide };
    this.tubes = new Sheet(this.stage, new THREE.MeshLambertMaterial(lit), 0);
    this.floor = new Sheet(this.stage, new THREE.MeshBasicMaterial(faint), 0);
    this.surfaces = new Sheet(this.stage, new THREE.MeshLambertMaterial(faint), 1);
    this.ribbons = new Sheet(this.stage, new THREE.MeshBasicMaterial(faint), 2);
    this.triad = new Sheet(this.stage, new THREE.MeshBasicMaterial({ ...faint, depthTest: false }), 3);
    this.bodies = drawing.solids.map(() => this.newBody());
    this.inks = new Map();
    canvas.addEventListener("webglcontextrestored", () => { this.shown = null; });
  }

  // A rigid body, as yet without a shape. It keeps its materials: three.js compiles a program for each kind of them.
  newBody() {
    const skin = new THREE.MeshLambertMaterial({ vertexColors: true, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const mesh = new THREE.Mesh(new THREE.BufferGeometry(), skin);
    const edges = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0, transparent: true, opacity: 0.55 }));
    mesh.add(edges);
    for (const one of [mesh, edges]) [one.matrixAutoUpdate, one.frustumCulled] = [false, false];
    this.stage.add(mesh);
    return { mesh, edges, size: 1 };
  }

  ink(text) {
    if (!this.inks.has(text)) this.inks.set(text, new THREE.Color(text));
    return this.inks.get(text);
  }

  begin(parameters) {
    super.begin(parameters);
    this.shown = null;
    this.bodies.forEach((body, number) => {
      const faces = this.faces[number];
      body.size = Math.max(...faces.flat().map((corner) => Math.hypot(...corner))) || 1;
      const made = bodyOf(this.drawing.solids[number].shape, faces, body.size);
      for (const [one, geometry] of [[body.mesh, made.body], [body.edges, made.edges]]) {
        one.geometry.dispose();
        one.geometry = geometry;
      }
    });
  }

  clear() { this.renderer.setClearColor(this.ink(colour("paper"))); this.renderer.clear(); this.shown = null; }

  // A place, and a direction, in the axes of the picture.
  eye([x, y, z]) {
    const { centre: [a, b, c], far } = this;
    return this.turned([(x - a) / far, (y - b) / far, (z - c) / far]);
  }

  turned([x, y, z]) {
    const [a, b, c] = this.axes;
    return [a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z, c[0] * x + c[1] * y + c[2] * z];
  }

  spot(number) { return this.eye(this.at(this.points, number)); }

  // Nothing is drawn again that is there.
  show(motion, t, q) {
    const now = [
      motion, t, motion.observed, this.bounds, this.scale, this.width, this.height, this.ratio, this.trails, colour("paper"),
      ...Object.values(this.view), ...this.points,
    ];
    if (this.shown?.length === now.length && now.every((one, i) => Object.is(one, this.shown[i]))) return;
    this.shown = now;
    this.pixel = 1 / (this.scale * this.far);
    this.look();
    for (const sheet of [this.tubes, this.floor, this.surfaces, this.ribbons, this.triad]) sheet.clear();
    this.putFloor(motion);
    this.putTriad();
    if (this.trails) {
      for (const number of this.drawing.trails) {
        const { places, ink, strength } = this.trail(motion, t, number);
        this.putLine(this.ribbons, places.map((one) => this.eye(one)), 1.8, ink, strength);
      }
    }
    this.drawing.curves.forEach((curve, i) => this.putCurve(curve, this.lines(curve, i, t, q)));
    this.drawing.solids.forEach((solid, i) => this.putSolid(solid, this.bodies[i]));
    this.drawing.rods.forEach((rod, i) => this.putRod(rod, i));
    for (const spring of this.drawing.springs) this.putSpring(spring);
    this.drawing.pivots.forEach((pivot, i) => this.putBall(this.pivots, i, pivot.point, PIVOT, colour("soft")));
    this.drawing.dots.forEach((dot, i) => this.putBall(this.dots, i, dot.point, this.radius(dot), this.tint(dot.group, dot.colour)));
    for (const sheet of [this.tubes, this.floor, this.surfaces, this.ribbons, this.triad]) sheet.finish();
    this.renderer.setClearColor(this.ink(colour("paper")));
    this.renderer.render(this.stage, this.camera);
  }

  // The camera that sees what `onPaper` says.
  look() {
    const { width, height, ratio, view, pixel, camera } = this, near = 0.05, part = near * pixel;
    const [wide, high] = [width, height].map((one) => Math.round(one * ratio));
    if (this.buffer?.[0] !== wide || this.buffer?.[1] !== high || this.canvas.width !== wide || this.canvas.height !== high) {
      this.renderer.setDrawingBufferSize(wide, high, 1);
      this.buffer = [wide, high];
    }
    camera.projectionMatrix.makePerspective(
      part * (-width / 2 - view.x), part * (width / 2 - view.x), part * (height / 2 + view.y), part * (view.y - height / 2), near, 20);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  }

  // A line of some pixels that faces the reader, with its strength at each of its places.
  putLine(sheet, places, pixels, ink, strength) {
    const spots = places.filter(([x, y, z]) => Number.isFinite(x + y + z)), { r, g, b } = this.ink(ink);
    const { position, color } = sheet.rows, last = spots.length - 1, half = pixels / 2 * this.pixel;
    for (let i = 0; i <= last; i++) {
      const [x, y, z] = spots[i], before = spots[Math.max(0, i - 1)], next = spots[Math.min(i + 1, last)];
      const [s, u] = [Math.max(0.1, 1 - before[2]), Math.max(0.1, 1 - next[2])];
      const dx = next[0] / u - before[0] / s, dy = next[1] / u - before[1] / s, wide = half * (1 - z) / (Math.hypot(dx, dy) || 1);
      const alpha = strength(i), here = sheet.count;
      position.push(x - dy * wide, y + dx * wide, z, x + dy * wide, y - dx * wide, z);
      color.push(r, g, b, alpha, r, g, b, alpha);
      sheet.count += 2;
      if (i) sheet.quad(here - 2, here - 1, here + 1, here);
    }
  }

  // Round coordinates on the plane below all that moves, and below the start of what is followed; it fades.
  putFloor(motion) {
    const { bounds, centre, upward: up } = this, { follow } = this.drawing.camera;
    const [a, b] = [0, 1, 2].filter((k) => k !== up), middle = this.middle();
    const reach = FLOOR * (this.span?.[0] ?? Math.max(bounds[1][a] - middle[a], bounds[1][b] - middle[b]));
    const start = follow === null ? 0 : this.rows(motion, follow)[up][0];
    const low = start + (this.axes[1][up] < 0 ? bounds[1][up] : bounds[0][up]), ends = (k) => [centre[k] - reach, centre[k] + reach];
    const strength = (x, y) => Math.max(0, 1 - ((x - centre[a]) ** 2 + (y - centre[b]) ** 2) / reach ** 2);
    const line = (spots) => this.putLine(
      this.floor, spots.map(([x, y]) => { const place = []; [place[a], place[b], place[up]] = [x, y, low]; return this.eye(place); }),
      1.2, colour("line"), (i) => strength(...spots[i]));
    const along = (k) => Array.from({ length: 17 }, (_, i) => centre[k] + reach * (i / 8 - 1));
    for (const x of ticks(...ends(a), 10)) line(along(b).map((y) => [x, y]));
    for (const y of ticks(...ends(b), 10)) line(along(a).map((x) => [x, y]));
  }

  // The axes, and their names, in a corner.
  putTriad() {
    const { width, height, view, pixel } = this, ink = colour("soft"), full = () => 1;
    const corner = [(40 - width / 2 - view.x) * pixel, (view.y + height / 2 - height + 40) * pixel, 0];
    LETTERS.forEach((letter, k) => {
      const axis = [this.axes[0][k], this.axes[1][k], 0], at = (pixels) => moved(corner, axis, pixels * pixel);
      this.putLine(this.triad, [corner, at(26)], 1.5, ink, full);
      for (const [x, y, u, v] of letter) {
        this.putLine(this.triad, [[x, y, 0], [u, v, 0]].map((one) => moved(at(36), scaled(one, 3), pixel)), 1.3, ink, full);
      }
    });
  }

  putCurve(curve, lines) {
    const own = curve.colour || colour("soft"), mesh = curve.along.length > 1, spots = lines.map((line) => line.map((one) => this.eye(one)));
    for (const line of spots) this.putLine(this.ribbons, line, mesh ? 0.9 : 1.8, own, () => (mesh ? 0.4 : 0.85));
    if (!mesh) return;
    const rows = spots.filter((_, i) => i % 2 === 0), paint = this.ink(own), last = rows.length - 1, numbers = [];
    rows.forEach((row, i) => row.forEach((spot, j) => {
      const u = moved(rows[Math.min(i + 1, last)][j], rows[Math.max(i - 1, 0)][j], -1);
      const v = moved(row[Math.min(j + 1, last)], row[Math.max(j - 1, 0)], -1);
      const good = spot.every(Number.isFinite);
      numbers.push(good ? this.surfaces.put(spot, unit(cross(u, v)).map((one) => (Number.isFinite(one) ? one : 0)), paint, SURFACE) : null);
      if (!i || !j) return;
      const n = row.length, four = [(i - 1) * n + j - 1, i * n + j - 1, i * n + j, (i - 1) * n + j].map((one) => numbers[one]);
      if (!four.includes(null)) this.surfaces.quad(...four);
    }));
  }

  putSolid(solid, { mesh, size }) {
    const axes = solid.axes.map((one) => this.turned(scaled(this.at(this.points, one), size / this.far)));
    framed(mesh.matrix, axes, this.spot(solid.centre));
    mesh.matrixWorldNeedsUpdate = true;
    mesh.visible = mesh.matrix.elements.every(Number.isFinite);
    mesh.material.color.copy(this.ink(this.tint(solid.group, solid.colour)));
  }

  putBall(copies, number, point, pixels, ink) {
    const r = pixels * this.pixel, spot = this.spot(point);
    copies.put(number, [[r, 0, 0], [0, r, 0], [0, 0, r]], spot.every(Number.isFinite) ? spot : [0, 0, 2], this.ink(ink));
  }

  putRod(rod, number) {
    const [a, b] = rod.ends.map((end) => this.spot(end)), along = moved(b, a, -1), r = (rod.thin ? WIRE : ROD) * this.pixel;
    const [u, v] = across(along), there = along.every(Number.isFinite);
    const ink = this.ink(rod.colour || colour(rod.thin ? "soft" : "rod"));
    this.rods.put(number, [scaled(u, r), scaled(v, r), along].map((one) => (there ? one : [0, 0, 0])), there ? moved(a, along, 0.5) : [0, 0, 2], ink);
  }

  // A spring as a wire that is wound.
  putSpring(spring) {
    const [a, b] = spring.ends.map((end) => this.spot(end)), along = moved(b, a, -1), length = Math.hypot(...along);
    if (!Number.isFinite(length) || length === 0) return;
    const [u, v] = across(along), wide = Math.min(8 * this.pixel, length / 5), count = TURNS * BENDS, spots = [a];
    for (let i = 0; i <= count; i++) {
      const angle = 2 * Math.PI * i / BENDS, s = i / count, r = wide * Math.min(1, 8 * s, 8 * (1 - s));
      spots.push(moved(moved(moved(a, along, 0.1 + 0.8 * s), u, r * Math.cos(angle)), v, r * Math.sin(angle)));
    }
    this.putTube([...spots, b], WIRE * this.pixel, this.ink(spring.colour || colour("soft")));
  }

  putTube(spots, radius, paint) {
    spots.forEach((spot, i) => {
      const [u, v] = across(moved(spots[Math.min(i + 1, spots.length - 1)], spots[Math.max(i - 1, 0)], -1));
      for (let k = 0; k < AROUND; k++) {
        const angle = 2 * Math.PI * k / AROUND, normal = moved(scaled(u, Math.cos(angle)), v, Math.sin(angle));
        const here = this.tubes.put(moved(spot, normal, radius), normal, paint), next = here - k + (k + 1) % AROUND;
        if (i) this.tubes.quad(here - AROUND, next - AROUND, next, here);
      }
    });
  }
}
