// The hand on the drawing: a particle is dragged to another start; elsewhere the drawing is turned or moved.

class Hand {
  constructor(app) {
    this.app = app;
    this.scene = app.scene;
    this.fingers = new Map();
    const { canvas } = app.scene, on = (what, act) => canvas.addEventListener(what, act);
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => this.move(event));
    for (const what of ["pointerup", "pointercancel"]) on(what, (event) => this.up(event));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 600), event.offsetX, event.offsetY);
    }, { passive: false });
    on("dblclick", () => { this.scene.reset(); this.scene.include(app.motion); });
  }

  down(event) {
    this.scene.canvas.setPointerCapture(event.pointerId);
    this.scene.canvas.classList.add("dragging");
    this.fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    this.held = this.app.replays || this.fingers.size > 1 ? null : this.scene.grasp(event.offsetX, event.offsetY);
    if (this.held === null) return;
    this.played = this.app.player.playing;
    this.app.player.playing = false;
    this.from = this.app.state.q;
  }

  move(event) {
    const was = this.fingers.get(event.pointerId), now = [event.offsetX, event.offsetY];
    if (!was) { this.scene.canvas.style.cursor = this.app.replays || this.scene.grasp(...now) === null ? "" : "pointer"; return; }
    if (this.fingers.size === 2) {
      const [a, b] = [...this.fingers.keys()], apart = () => {
        const [p, q] = [this.fingers.get(a), this.fingers.get(b)];
        return Math.hypot(p[0] - q[0], p[1] - q[1]) || 1;
      };
      const before = apart();
      this.fingers.set(event.pointerId, now);
      this.zoom(apart() / before, ...now);
      return;
    }
    this.fingers.set(event.pointerId, now);
    if (this.held !== null) { this.pull(now); return; }
    const { view, dimension } = this.scene, [dx, dy] = [now[0] - was[0], now[1] - was[1]];
    if (dimension === 3 && !event.shiftKey) {
      view.azimuth -= 0.4 * dx;
      const level = 180 * Math.round(this.scene.home.elevation / 180); // 180 where an axis points downward
      view.elevation = Math.min(level + 90, Math.max(level - 90, view.elevation + 0.4 * dy));
    } else {
      view.x += dx;
      view.y += dy;
    }
  }

  up(event) {
    this.fingers.delete(event.pointerId);
    this.scene.canvas.classList.remove("dragging");
    if (this.held !== null && this.held !== undefined && this.played) this.app.player.playing = true;
    this.held = null;
  }

  // Let the motion begin where the point is on the paper.
  pull(place) {
    const { app, scene } = this, { start } = app;
    app.engine.ready(start.parameters);
    this.from = reaching(scene, app.engine, this.held, place, app.data.time.start, this.from);
    app.data.coordinates.forEach((one, k) => start.changed.set(one.name, this.from[k]));
    start.settle(true);
    this.from = start.q;
    app.wanted = undefined;
    app.showStart();
    app.begin();
  }

  zoom(factor, x, y) {
    const { view, width, height } = this.scene, next = Math.min(200, Math.max(0.05, view.zoom * factor));
    const real = next / view.zoom;
    view.x = (view.x - x + width / 2) * real + x - width / 2;
    view.y = (view.y - y + height / 2) * real + y - height / 2;
    view.zoom = next;
  }
}
