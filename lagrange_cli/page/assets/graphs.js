// The graphs of a page: q(t), the phase portrait, h and the momenta.

const ALL = "all";
const ROUNDING_UNIT = 2 ** -53;

class Graphs {
  // `app` has the motion and the time that are shown.
  constructor(parent, app, data, observed) {
    this.app = app;
    this.data = data;
    const { coordinates } = data, names = coordinates.map((one, k) => [pretty(one.name), String(k)]);
    const whole = coordinates.length > 1 ? [["all", ALL]] : [];
    const seek = (t) => app.seek(t), time = withUnit("t", data.time.unit);
    const chosen = (choice) => (choice === ALL ? coordinates.map((_, k) => k).slice(0, MOST_LINES) : [Number(choice)]);
    const ink = (choice, i) => colour(`c${choice === ALL ? i % 8 : 0}`);
    const motion = () => app.motion;
    this.charts = [];
    const add = (title, choices, lines, mark, sought) => {
      this.charts.push({ chart: new Chart(parent, title, choices, lines, sought), mark });
    };
    const label = (k, dot = "") => withUnit(pretty(coordinates[k].name, dot), dot ? coordinates[k].unitOfVelocity : coordinates[k].unit);
    add("Coordinates", [...whole, ...names], (choice) => ({
      title: choice === ALL ? "q(t)" : `${pretty(coordinates[Number(choice)].name)}(t)`,
      lines: chosen(choice).map((k, i) => ({ x: motion().times, y: motion().q(k), ink: ink(choice, i) })),
      across: time, upward: choice === ALL ? "q" : label(Number(choice)),
    }), (choice) => chosen(choice).map((k, i) => [app.t, app.state.q[k], ink(choice, i)]), seek);
    add("Phase portrait", names, (choice) => ({
      lines: [{ x: motion().q(Number(choice)), y: motion().v(Number(choice)), ink: colour("c0"), over: true }],
      across: label(Number(choice)), upward: label(Number(choice), "\u0307"),
    }), (choice) => [[app.state.q[Number(choice)], app.state.v[Number(choice)], colour("c1")]]);
    const h = observed.indexOf("h"), kept = data.conserved.includes("h");
    const momenta = coordinates.map((one) => observed.indexOf(`p_${one.name}`));
    if (h >= 0) {
      add(kept ? "Drift of h" : "Energy function h", [["", ""]], () => (kept ? this.drift(h, momenta) : {
        lines: [{ x: motion().times, y: motion().quantity(h), ink: colour("c2") }],
        across: time, upward: withUnit("h", data.unitOfEnergy),
      }), () => [[app.t, this.near(h, kept), colour("c1")]], seek);
    }
    if (momenta.every((k) => k >= 0)) {
      add("Momenta", [...whole, ...names].map(([text, value]) => [value === ALL ? text : `p ${text}`, value]), (choice) => ({
        title: choice === ALL ? "p(t)" : `p_${pretty(coordinates[Number(choice)].name)}(t)`,
        lines: chosen(choice).map((k, i) => ({ x: motion().times, y: motion().quantity(momenta[k]), ink: ink(choice, i) })),
        across: time, upward: withUnit("p", choice === ALL ? "" : coordinates[Number(choice)].unitOfMomentum),
      }), (choice) => chosen(choice).map((k, i) => [app.t, this.value(momenta[k]), ink(choice, i)]), seek);
    }
  }

  value(k) {
    const { motion, t } = this.app, row = motion.quantity(k), i = before(motion.times, t), j = Math.min(i + 1, row.length - 1);
    const s = j === i ? 0 : Math.min(1, (t - motion.times[i]) / (motion.times[j] - motion.times[i]));
    return row[i] + s * (row[j] - row[i]);
  }

  near(h, kept) { return kept ? (this.value(h) - this.h0) / this.unit : this.value(h); }

  // h - h(0) in units of the rounding of its largest terms.
  drift(h, momenta) {
    const { motion } = this.app, row = motion.quantity(h);
    const pairs = momenta.flatMap((p, k) => (p >= 0 ? [[motion.quantity(p), motion.v(k)]] : []));
    let size = 0;
    for (let i = 0; i < row.length; i++) {
      let terms = 0;
      for (const [p, v] of pairs) terms += Math.abs(p[i] * v[i]);
      size = Math.max(size, Math.abs(row[i]), terms);
    }
    this.h0 = row[0];
    this.unit = ROUNDING_UNIT * size || 1;
    const relative = short(Math.max(...span([row], 0).map((one) => Math.abs(one - row[0]))) / (size || 1), 2);
    return {
      title: `Drift of h: ${relative}`, least: 4,
      lines: [{ x: motion.times, y: Float64Array.from(row, (one) => (one - this.h0) / this.unit), ink: colour("c2") }],
      across: withUnit("t", this.data.time.unit), upward: "(h − h(0)) / rounding",
    };
  }

  stale() { for (const { chart } of this.charts) chart.stale = true; }
  draw() { for (const { chart, mark } of this.charts) chart.draw(mark); }
}
