// Events whose arguments are 0 for as long as friction holds a motion (`integrate/impacts/standstill.py`). Such
// an event has no side then. It happens once, when the motion stops.

const AHEAD = 2 ** -10; // the part of the last step after which the sign of an argument tells where the motion leads

class Standstill {
  constructor(happenings) {
    this.happenings = happenings;
    this.settling = happenings.settling;
    this.events = happenings.events.map((_, e) => e).filter((e) => !happenings.rests.has(e));
    this.until = new Map(); // by events that have been released: up to when they do not happen again
    this.possible = this.settling.count > 0;
  }

  set(e, side) { this.happenings.modes[e + this.happenings.first] = side; }
  leaving(e, t) { return t <= (this.until.get(e) ?? -Infinity); }

  // The switches that hold the motion, the series of all arguments, and which of these are constantly 0.
  now() {
    const { happenings, settling } = this, modes = settling.modes;
    const held = new Set([...Array(settling.count).keys()].filter((j) => modes[j] === 0));
    const { sizes } = happenings.actOn(happenings.state(happenings.memory));
    const rows = happenings.allCoefficients();
    const still = rows.map((values, e) => Math.abs(values[0]) <= ROUNDING * sizes[e][0]
      && !happenings.counting(values, sizes[e][1]).length);
    return { held, rows, still };
  }

  // Where the motion begins, or begins anew, arguments that are held at 0 have no side.
  hold() {
    const { held, still } = this.now();
    if (held.size) for (const e of this.events) if (still[e]) this.set(e, 0);
  }

  // The events that happen because the motion has just been stopped, which was as `before`, with the sides that
  // they come from. Those that the motion leaves get a side.
  stopped(before) {
    const now = this.now(), found = [], more = [...now.held].some((j) => !before.held.has(j));
    for (const e of this.events) {
      const side = this.happenings.side(e);
      if (!now.still[e]) {
        if (side === 0) this.release(e, now.rows[e]);
      } else if (more && side !== 0) {
        const known = this.leaving(e, this.settling.now) || before.still[e] || this.happenings.atZero(e);
        if (!known) found.push([e, side]);
        this.set(e, 0);
      }
    }
    return found;
  }

  // Choose the side that the motion leads to from 0.
  release(e, values) {
    const ahead = AHEAD * this.settling.clock(Clock.LENGTH);
    const leads = values.reduceRight((sum, one) => sum * ahead + one, 0);
    this.set(e, (Number.isFinite(leads) ? leads : values[0]) > 0 ? 1 : -1);
    this.settling.mark([e + this.happenings.first]);
    this.until.set(e, this.settling.now + ahead);
  }
}
