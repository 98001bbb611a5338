// A slider and a box for every number. A box takes any number; the slider's range grows with it.

const MANY = 14;

class Control {
  constructor({ name, label, unit, hint, value, range, change }) {
    this.name = name;
    this.value = this.original = value;
    this.element = document.createElement("div");
    this.element.className = "control";
    const text = document.createElement("label");
    text.textContent = label;
    text.title = [name, unit && `in ${unit}`, hint].filter(Boolean).join(" · ");
    if (unit) {
      const small = document.createElement("small");
      small.textContent = ` ${unit}`;
      text.append(small);
    }
    this.slider = document.createElement("input");
    this.box = document.createElement("input");
    Object.assign(this.slider, { type: "range", min: range[0], max: range[1], step: "any" });
    Object.assign(this.box, { type: "number", step: "any" });
    this.slider.setAttribute("aria-label", name);
    this.box.setAttribute("aria-label", `${name}, as a number`);
    this.slider.addEventListener("input", () => this.give(round(Number(this.slider.value), range), change));
    this.slider.addEventListener("dblclick", () => this.give(this.original, change));
    this.box.addEventListener("change", () => {
      const value = this.box.value.trim() === "" ? NaN : Number(this.box.value);
      this.element.classList.toggle("bad", !Number.isFinite(value));
      if (Number.isFinite(value)) this.give(value, change);
    });
    this.element.append(text, this.slider, this.box);
    this.show(value);
  }

  give(value, change) { this.show(value); change(this.name, value); }
  enable(enabled) { this.slider.disabled = this.box.disabled = !enabled; }

  show(value) {
    this.value = value;
    if (value < Number(this.slider.min)) this.slider.min = value;
    if (value > Number(this.slider.max)) this.slider.max = value;
    this.slider.value = value;
    this.box.title = String(value);
    if (document.activeElement !== this.box || Number(this.box.value) !== value) this.box.value = boxed(value);
    this.element.classList.remove("bad");
    this.element.classList.toggle("changed", value !== this.original);
  }
}

// A slider's value with as many digits as its range has steps for.
function round(value, [low, high]) {
  const step = 10 ** Math.floor(Math.log10((high - low) / 400));
  return Number((Math.round(value / step) * step).toPrecision(12));
}

function around(value) {
  if (value === 0) return [-1, 1];
  return value > 0 ? [value / 20, 2 * value] : [2 * value, value / 20];
}

function rangeOfState(value, reach, angle) {
  const size = Math.max(1.2 * Math.abs(value), reach, angle ? Math.PI : 0) || 1;
  return [-size, size];
}

class Controls {
  // `change(name, value)` is told what the reader does.
  constructor(parent, data, change) {
    this.byName = new Map();
    this.values = new Map(); // what is shown, for controls that are not there yet
    this.disabled = false;
    const given = data.drawing?.sliders ?? {};
    const group = (title, entries) => {
      if (!entries.length) return;
      const many = entries.length > MANY, box = document.createElement(many ? "details" : "fieldset");
      const head = document.createElement(many ? "summary" : "legend");
      head.textContent = many ? `${title} (${entries.length})` : title;
      box.append(head);
      const fill = () => {
        for (const entry of entries) {
          const control = new Control({ ...entry, range: given[entry.name] ?? entry.range, change });
          control.enable(!this.disabled);
          if (this.values.has(entry.name)) control.show(this.values.get(entry.name));
          this.byName.set(entry.name, control);
          box.append(control.element);
        }
      };
      if (many) box.addEventListener("toggle", fill, { once: true }); else fill();
      parent.append(box);
    };
    const span = data.time.stop - data.time.start;
    group("Parameters", data.parameters.filter((one) => !one.fixed).map((one) => ({
      name: one.name, label: pretty(one.name), unit: one.unit, value: one.value, range: around(one.value),
      hint: [one.description, one.expression && `= ${one.expression} until its slider is moved`].filter(Boolean).join(" · "),
    })));
    group("Start", data.coordinates.map((one) => ({
      name: one.name, label: pretty(one.name), unit: one.unit, value: one.q, hint: one.description,
      range: rangeOfState(one.q, one.reach[0], one.unit === "rad"),
    })));
    group("Velocities at the start", data.coordinates.map((one, k) => ({
      name: data.velocities[k], label: pretty(one.name, "\u0307"), unit: one.unitOfVelocity, value: one.v,
      hint: "", range: rangeOfState(one.v, one.reach[1], false),
    })));
    group("Time", [{
      name: "stop", label: "until t", unit: data.time.unit, value: data.time.stop, hint: "when the motion ends",
      range: [data.time.start + span / 50, data.time.start + 5 * span],
    }].map((one) => ({ ...one, name: STOP })));
  }

  show(name, value) {
    this.values.set(name, value);
    this.byName.get(name)?.show(value);
  }

  disable(disabled) {
    this.disabled = disabled;
    for (const control of this.byName.values()) control.enable(!disabled);
  }
}

const STOP = "until t";
