// A graph: lines over an axis, and a mark where the motion is. The lines are painted once, the mark each time.

const MARGIN = { left: 54, right: 10, top: 8, bottom: 30 };
const MOST_LINES = 8;

class Chart {
  // `choices` are names that can be chosen; `lines(choice)` gives {lines: [{x, y, ink}], across, upward, note}.
  constructor(parent, title, choices, lines, seek) {
    const box = document.createElement("figure"), head = document.createElement("div");
    box.className = "chart";
    box.style.margin = 0;
    this.title = document.createElement("h2");
    this.title.textContent = title;
    head.append(this.title);
    if (choices.length > 1) {
      this.select = document.createElement("select");
      this.select.setAttribute("aria-label", `${title}: which`);
      choices.forEach(([text, value]) => this.select.append(new Option(text, value)));
      this.select.addEventListener("change", () => { this.stale = true; });
      head.append(this.select);
    }
    this.choices = choices;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", title);
    box.append(head, this.canvas);
    parent.append(box);
    this.back = document.createElement("canvas");
    this.lines = lines;
    this.stale = true;
    if (seek) {
      this.canvas.style.cursor = "crosshair";
      const go = (event) => { if (event.buttons & 1) seek(this.valueAt(event.offsetX)); };
      this.canvas.addEventListener("pointerdown", go);
      this.canvas.addEventListener("pointermove", go);
    }
  }

  get choice() { return this.select?.value ?? this.choices[0]?.[1]; }
  valueAt(x) { return this.range ? this.range.left + (x - MARGIN.left) / this.range.perX : 0; }

  resize() {
    const ratio = window.devicePixelRatio || 1, { clientWidth: w, clientHeight: h } = this.canvas;
    if (this.canvas.width !== Math.round(w * ratio) || this.canvas.height !== Math.round(h * ratio)) {
      for (const one of [this.canvas, this.back]) [one.width, one.height] = [Math.round(w * ratio), Math.round(h * ratio)];
      this.stale = true;
    }
    [this.width, this.height, this.ratio] = [w, h, ratio];
  }

  // Paint; `mark(choice)` gives the places [x, y, ink] of what is now.
  draw(mark) {
    this.resize();
    if (!this.width) return;
    if (this.stale) this.paint();
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.back, 0, 0);
    if (!this.range) return;
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    const { left, low, perX, perY } = this.range;
    for (const [x, y, ink] of mark(this.choice)) {
      pen.fillStyle = ink;
      pen.beginPath();
      pen.arc(MARGIN.left + (x - left) * perX, this.height - MARGIN.bottom - (y - low) * perY, 4, 0, 2 * Math.PI);
      pen.fill();
    }
  }

  paint() {
    this.stale = false;
    const found = this.lines(this.choice), pen = this.back.getContext("2d"), { width, height } = this;
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    if (found.title) this.title.textContent = found.title;
    const xs = found.lines.map((one) => one.x), single = span(xs, 0)[0] === span(xs, 0)[1];
    const [left, right] = span(xs, single ? 0.06 : 0), [low, high] = span(found.lines.map((one) => one.y), 0.06, found.least);
    this.range = null;
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = colour("soft");
    if (!(right > left) || !(high > low)) return;
    const perX = (width - MARGIN.left - MARGIN.right) / (right - left), perY = (height - MARGIN.top - MARGIN.bottom) / (high - low);
    this.range = { left, low, perX, perY };
    const x = (one) => MARGIN.left + (one - left) * perX, y = (one) => height - MARGIN.bottom - (one - low) * perY;
    const [across, upward] = [ticks(left, right, width / 80), ticks(low, high, height / 42)];
    pen.strokeStyle = colour("grid");
    pen.lineWidth = 1;
    const rule = (a, b, c, d) => { pen.beginPath(); pen.moveTo(a, b); pen.lineTo(c, d); pen.stroke(); };
    pen.textAlign = "center";
    for (const one of across) {
      rule(x(one), MARGIN.top, x(one), height - MARGIN.bottom);
      const text = tickText(one, across), room = width - pen.measureText(text).width / 2;
      pen.fillText(text, Math.min(x(one), room), height - MARGIN.bottom + 12);
    }
    pen.textAlign = "right";
    for (const one of upward) {
      rule(MARGIN.left, y(one), width - MARGIN.right, y(one));
      pen.fillText(tickText(one, upward), MARGIN.left - 4, y(one) + 4);
    }
    pen.textAlign = "right";
    pen.fillText(found.across, width - MARGIN.right, height - 3);
    pen.save();
    pen.translate(9, MARGIN.top);
    pen.rotate(-Math.PI / 2);
    pen.fillText(found.upward, 0, 0);
    pen.restore();
    pen.save();
    pen.beginPath();
    pen.rect(MARGIN.left, MARGIN.top - 2, width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom + 4);
    pen.clip();
    pen.lineWidth = 1.3;
    pen.lineJoin = "round";
    for (const line of found.lines) {
      pen.strokeStyle = line.ink;
      pen.beginPath();
      line.over ? trace(pen, line, x, y) : columns(pen, line, x, y);
      pen.stroke();
    }
    pen.restore();
  }
}

// The least and the greatest of several rows, with room around them.
function span(rows, room, least = 0) {
  let [low, high] = [Infinity, -Infinity];
  for (const row of rows) {
    for (let i = 0; i < row.length; i++) {
      if (row[i] < low) low = row[i];
      if (row[i] > high && row[i] < Infinity) high = row[i];
    }
  }
  if (!(low <= high) || low === -Infinity) return [0, 0];
  const size = Math.max(Math.abs(low), Math.abs(high)); // what changes by rounding alone is a straight line
  if (room && !least && high - low < 1e-9 * size) return [low - 0.1 * size, high + 0.1 * size];
  if (high - low < least) [low, high] = [(low + high - least) / 2, (low + high + least) / 2];
  const more = (high - low) * room || (room && (Math.abs(low) * 0.1 || 1));
  return [low - more, high + more];
}

// A curve through all of its places.
function trace(pen, line, x, y) {
  const each = Math.max(1, Math.floor(line.x.length / 6000));
  let going = false;
  for (let i = 0; i < line.x.length; i += each) {
    if (!Number.isFinite(line.y[i])) { going = false; continue; }
    if (going) pen.lineTo(x(line.x[i]), y(line.y[i])); else pen.moveTo(x(line.x[i]), y(line.y[i]));
    going = true;
  }
}

// A function of what is across: in each column of the picture its first, least, greatest and last value.
function columns(pen, line, x, y) {
  let column = NaN, low = 0, high = 0, last = 0, going = false;
  const close = () => { if (going && high !== low) { pen.lineTo(column, y(low)); pen.lineTo(column, y(high)); pen.lineTo(column, y(last)); } };
  for (let i = 0; i < line.x.length; i++) {
    const value = line.y[i], at = Math.round(2 * x(line.x[i])) / 2;
    if (!Number.isFinite(value)) { close(); going = false; column = NaN; continue; }
    if (at === column && going) {
      [low, high, last] = [Math.min(low, value), Math.max(high, value), value];
      continue;
    }
    close();
    if (going) pen.lineTo(at, y(value)); else pen.moveTo(at, y(value));
    [column, low, high, last, going] = [at, value, value, value, true];
  }
  close();
}
