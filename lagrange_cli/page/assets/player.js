// Time as the reader sees it: playing, steps, speed.

const SPEEDS = [1 / 100, 1 / 20, 1 / 10, 1 / 4, 1 / 2, 1, 2, 4, 10, 20, 50, 100, 1000];

// Real time where one can follow it; else about as many steps a second as one can, in not too long a time.
function natural(span, rate) {
  if ((span >= 2 && span <= 60) || (rate > 1.5 && rate < 80)) return 1;
  const speed = Math.min(Math.max(15 / rate, span / 120), span / 6), power = 10 ** Math.floor(Math.log10(speed));
  return Number((power * [5, 2, 1].find((one) => one * power <= speed * 1.0001)).toPrecision(3));
}

class Player {
  // The motion lasts for `span` and took so many `steps`, each a part of a swing or a turn.
  constructor(span, steps) {
    this.t = 0;
    this.playing = false;
    this.natural = natural(span, steps / span);
    this.speed = this.natural;
  }

  choices() {
    const all = SPEEDS.map((one) => this.natural * one).filter((one) => one > 0);
    return this.natural === 1 ? all : [...new Set([...all, 1])].sort((a, b) => a - b);
  }

  // Move on by the seconds that have passed; what is not computed yet is waited for.
  move(seconds, motion) {
    if (!this.playing) return;
    this.t = Math.min(this.t + seconds * this.speed, motion.last);
    if (this.t >= motion.last && motion.ended) this.playing = false;
  }

  seek(t, motion) { this.t = Math.min(Math.max(t, motion.first), motion.last); }

  // To the next sample, or to the one before.
  step(direction, motion) {
    this.playing = false;
    const { times } = motion, i = before(times, this.t);
    const next = direction > 0 ? i + 1 : times[i] < this.t ? i : i - 1;
    this.t = times[Math.min(Math.max(next, 0), times.length - 1)] ?? motion.first;
  }

  toggle(motion) {
    if (!this.playing && this.t >= motion.last && motion.ended) this.t = motion.first;
    this.playing = !this.playing;
  }
}
