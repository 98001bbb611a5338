// The page: what is computed, drawn and changed.

const SLICE = 7;          // milliseconds of a frame for computing
const FIRST = 4;          // milliseconds for the beginning of a motion, which is drawn at once
const REFRESH = 150;      // milliseconds between two paintings of graphs while the motion is computed

const SIGNS = { Play: "M4 2v12l10-6z", Pause: "M3 2h4v12H3zM9 2h4v12H9z" };

class App {
  constructor(data, engine, tables, Stage) {
    Object.assign(this, { data, engine, tables });
    this.element = (id) => document.getElementById(id);
    this.replays = tables.length > 0;
    this.members = data.members;
    this.player = new Player(data.time.stop - data.time.start, data.time.steps);
    this.scene = new Stage(this.element("scene"), data.drawing, engine);
    this.start = new Start(data, engine);
    this.controls = new Controls(this.element("controls"), data, (name, value) => this.change(name, value));
    this.controls.disable(this.replays);
    this.describe();
    this.listen();
    this.take(addressed(location.hash));
    if (this.slider && !this.start.changed.size) this.choose(this.member ?? 0); else this.begin();
    const observed = this.replays ? data.members[0].observed : engine.data.observed;
    this.observed = observed;
    this.player.playing = this.wanted === undefined && !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.graphs = new Graphs(this.element("charts"), this, data, observed);
    this.painted = -REFRESH;
    this.frame = this.frame.bind(this);
    this.before = performance.now();
    this.draw();
    requestAnimationFrame(this.frame);
  }

  get t() { return this.player.t; }

  describe() {
    const { data, element } = this, put = (id, text) => { element(id).textContent = text; };
    put("name", data.name);
    put("description", data.description);
    put("file", data.file);
    put("text", data.text);
    put("generator", `Made by ${data.generator}. This page needs no network.`);
    element("notice").textContent = data.notice;
    element("notice").hidden = !data.notice;
    if (!data.drawing) element("scene").hidden = true;
    for (const one of this.player.choices()) element("speed").append(new Option(`× ${short(one, 3)}`, one));
    element("speed").value = this.player.speed;
    element("reset").hidden = this.replays;
    if (data.members.length > 1) this.addMembers();
  }

  addMembers() {
    const box = document.createElement("fieldset"), head = document.createElement("legend");
    head.textContent = "Member";
    this.slider = document.createElement("input");
    Object.assign(this.slider, { type: "range", min: 0, max: this.data.members.length - 1, step: 1, value: 0 });
    this.slider.setAttribute("aria-label", "member");
    this.slider.style.width = "100%";
    this.label = document.createElement("p");
    this.label.style.margin = 0;
    this.slider.addEventListener("input", () => this.choose(Number(this.slider.value)));
    box.append(head, this.slider, this.label);
    this.element("controls").prepend(box);
  }

  choose(number) {
    this.member = Math.min(Math.max(0, Math.round(number)), this.members.length - 1);
    const one = this.members[this.member];
    if (this.slider) [this.slider.value, this.label.textContent] = [this.member, one.label];
    if (this.replays) { this.show(new Recorded(this.engine, one, this.tables[this.member], this.start.parameters)); return; }
    this.start.take(one.values);
    if (this.motion) this.wanted = this.player.playing ? undefined : this.t;
    this.showStart();
    this.begin();
  }

  // What an address says.
  take(values) {
    for (const [name, value] of values) {
      if (name === AT) this.wanted = value;
      else if (name === SPEED && value > 0) this.setSpeed(value);
      else if (name === MEMBER) this.member = value;
      else if (!this.replays && (name === STOP || this.start.names.includes(name) || this.start.stateNames.includes(name))) {
        this.start.changed.set(name, value);
      }
    }
    this.start.settle();
    this.showStart();
  }

  // The motion from the values as they are.
  begin() {
    if (this.replays) { this.choose(0); return; }
    const { data, start } = this, [from, stop] = [data.time.start, Math.max(start.stop, data.time.start)];
    this.began = performance.now();
    try {
      const motion = new Motion(this.engine, { ...start }, from, stop > from ? stop : from + 1, data.time.count);
      motion.compute(FIRST);
      this.show(motion);
    } catch (error) { // compiled code ran out of its memory
      this.say(`The engine has stopped: ${error.message}`);
      throw error;
    }
    this.milliseconds = performance.now() - this.began;
  }

  show(motion) {
    this.motion = motion;
    this.scene.begin(this.start.parameters);
    this.scene.include(motion);
    this.player.seek(this.wanted ?? motion.first, motion);
    this.due = true; // graphs follow some frames later, while a slider moves
    this.report();
  }

  change(name, value) {
    const keep = !this.player.playing && !this.start.stateNames.includes(name);
    this.wanted = keep ? this.t : undefined;
    this.start.set(name, value);
    this.showStart();
    this.begin();
    this.paint();
  }

  showStart() {
    const { start } = this, show = (names, values) => names.forEach((name, k) => this.controls.show(name, values[k]));
    show(start.names, start.parameters);
    show(start.stateNames, [...start.q, ...start.v]);
    this.controls.show(STOP, start.stop);
  }

  reset() {
    if (this.replays) return;
    this.start.reset();
    this.wanted = undefined;
    this.showStart();
    this.scene.reset();
    this.begin();
  }

  // What cannot go on, and why.
  report() {
    const { motion } = this;
    const where = `t = ${short(motion.last, 6)}`;
    let text = this.start.note;
    if (motion.ended && motion.reason) text = `${motion.failed ? "The motion cannot go on at" : "The motion ends at"} ${where}: ${motion.reason}.`;
    this.say(text);
  }

  say(text) { if (this.element("status").textContent !== text) this.element("status").textContent = text; }

  seek(t) { this.wanted = undefined; this.player.seek(t, this.motion); }

  setSpeed(value) {
    this.player.speed = value;
    const { options } = this.element("speed"), text = String(value);
    if (!Array.from(options).some((one) => one.value === text)) this.element("speed").append(new Option(`× ${short(value, 3)}`, value));
    this.element("speed").value = text;
  }

  faster(direction) {
    const all = this.player.choices(), i = all.findIndex((one) => one >= this.player.speed - 1e-12);
    this.setSpeed(all[Math.min(Math.max((i < 0 ? all.length : i) + direction, 0), all.length - 1)]);
  }

  frame(now) {
    const seconds = Math.min(0.1, Math.max(0, now - this.before) / 1000); // a first frame may have begun before
    this.before = now;
    if (!this.motion.ended) {
      this.motion.compute(SLICE);
      if (this.wanted !== undefined && !this.player.playing) this.player.seek(this.wanted, this.motion);
      this.due = true;
      this.report();
    }
    if (this.due && now - this.painted > REFRESH) {
      this.graphs.stale();
      this.scene.include(this.motion);
      this.painted = now;
      this.due = !this.motion.ended;
    }
    if (this.player.playing) this.wanted = undefined;
    this.player.move(seconds, this.motion);
    this.draw();
    requestAnimationFrame(this.frame);
  }

  draw() {
    this.paint();
    if (this.motion.observed) this.graphs?.draw();
  }

  // The drawing, and the time; not the graphs.
  paint() {
    const { motion, element } = this;
    if (!motion.observed) { this.scene.draw(motion, 0); return; }
    this.state = motion.stateAt(this.t);
    this.scene.draw(motion, this.t);
    const [scrub, unit] = [element("scrub"), this.data.time.unit];
    scrub.min = motion.first;
    scrub.max = motion.ended ? motion.last : motion.stop;
    if (Number(scrub.value) !== this.t) scrub.value = this.t;
    const clock = `t = ${short(this.t, 5)}${unit ? ` ${unit}` : ""}`;
    if (element("clock").textContent !== clock) element("clock").textContent = clock;
    const sign = this.player.playing ? "Pause" : "Play", button = element("play");
    if (button.getAttribute("aria-label") !== sign) {
      button.setAttribute("aria-label", sign);
      button.querySelector("path").setAttribute("d", SIGNS[sign]);
    }
  }

  values() {
    const found = new Map(this.start.changed);
    found.set(AT, Number(this.t.toPrecision(8)));
    if (this.player.speed !== this.player.natural) found.set(SPEED, this.player.speed);
    if (this.member) found.set(MEMBER, this.member);
    return found;
  }

  async share() {
    const link = location.href.replace(/#.*$/s, "") + address(this.values());
    location.replace(link);
    try {
      await navigator.clipboard.writeText(link);
      this.flash("share", "Copied");
    } catch { // a page from disk may not: the address has it
      this.flash("share", "In the address");
    }
  }

  flash(id, text) {
    const button = this.element(id), was = button.dataset.text ?? button.textContent;
    button.dataset.text = was;
    button.textContent = text;
    setTimeout(() => { button.textContent = was; }, 1500);
  }

  get dark() { return document.documentElement.dataset.theme === "dark"; }

  theme(dark) {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    COLOURS.clear();
    this.graphs.stale();
    this.draw();
  }

  get stem() { return this.data.name.replace(/[^\p{L}\p{N}]+/gu, "_").replace(/^_+|_+$/g, "").slice(0, 80) || "motion"; }

  listen() {
    const on = (id, what, act) => this.element(id).addEventListener(what, act);
    on("play", "click", () => this.player.toggle(this.motion));
    on("first", "click", () => this.seek(this.motion.first));
    on("back", "click", () => this.player.step(-1, this.motion));
    on("forth", "click", () => this.player.step(1, this.motion));
    on("scrub", "input", (event) => { this.player.playing = false; this.seek(Number(event.target.value)); });
    on("speed", "change", (event) => { this.player.speed = Number(event.target.value); });
    on("trails", "change", (event) => { this.scene.trails = event.target.checked; });
    on("reset", "click", () => this.reset());
    on("theme", "click", () => this.theme(!this.dark));
    on("share", "click", () => this.share());
    on("png", "click", async () => save(await picture(this.scene.canvas), `${this.stem}.png`));
    on("csv", "click", () => save(new Blob([table(this.motion, this.data, this.observed)], { type: "text/csv" }), `${this.stem}.csv`));
    const dark = matchMedia("(prefers-color-scheme: dark)");
    document.documentElement.dataset.theme = dark.matches ? "dark" : "light";
    dark.addEventListener("change", () => this.theme(dark.matches));
    document.addEventListener("keydown", (event) => this.key(event));
    new Hand(this);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches("input[type=number], select")) return;
    const slider = event.target.matches("input[type=range]"), click = (id) => this.element(id).click();
    const acts = {
      " ": () => this.player.toggle(this.motion), r: () => this.reset(), d: () => this.theme(!this.dark), l: () => this.share(),
      t: () => click("trails"), "+": () => this.faster(1), "=": () => this.faster(1), "-": () => this.faster(-1),
      ...(slider ? {} : {
        ArrowLeft: () => this.player.step(-1, this.motion), ArrowRight: () => this.player.step(1, this.motion),
        Home: () => this.seek(this.motion.first), End: () => this.seek(this.motion.last),
      }),
    };
    const act = acts[event.key];
    if (!act || (event.key === " " && event.target.matches("button, summary, input[type=checkbox]"))) return;
    event.preventDefault();
    act();
  }
}

async function main(data) {
  const code = await unpacked(data.engine.code), module = await WebAssembly.compile(code);
  const tables = await Promise.all(data.members.filter((one) => one.rows).map(async (one) => new Float64Array((await unpacked(one.rows)).buffer)));
  const engine = new Engine(data.engine, module);
  await engine.load();
  // Markup made by symbolic/mathml.py, where every text of the system file is escaped.
  document.querySelector(".equations").innerHTML = await unpackedText(data.equations);
  window.app = new App(data, engine, tables, data.space ? await inSpace(data) : Scene);
}
