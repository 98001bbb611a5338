// Names and numbers as a reader writes them.

const GREEK = {
  __proto__: null, // a name such as `constructor` is none of these
  alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", zeta: "ζ", eta: "η", theta: "θ", iota: "ι", kappa: "κ",
  lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", rho: "ρ", sigma: "σ", tau: "τ", upsilon: "υ", phi: "φ", chi: "χ", psi: "ψ",
  omega: "ω", Gamma: "Γ", Delta: "Δ", Theta: "Θ", Lambda: "Λ", Xi: "Ξ", Pi: "Π", Sigma: "Σ", Upsilon: "Υ", Phi: "Φ",
  Psi: "Ψ", Omega: "Ω",
};
const LOWERED = "₀₁₂₃₄₅₆₇₈₉";

// `theta1` as θ₁; with a dot over it where it is a velocity.
function pretty(name, dot = "") {
  const [, stem, digits, rest] = name.match(/^(.*?)(\d*)(\[.*)?$/s);
  const [base, ...words] = stem.split("_");
  const lowered = Array.from(digits, (digit) => LOWERED[digit]).join("");
  const letter = (GREEK[base] ?? base) + dot;
  return letter + (words.join("_") ? `_${words.join("_")}` : "") + lowered + (rest ?? "");
}

function withUnit(name, unit) { return unit ? `${name} / ${unit}` : name; }

// A number with a few digits.
function short(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(Math.max(0, digits - 2)).replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}

// A number with six digits, as short as that can be.
function boxed(value) {
  const plain = String(Number(value.toPrecision(6)));
  return plain.length <= 9 ? plain : String(Number(value.toPrecision(6)).toExponential()).replace("e+", "e");
}

// Round numbers between two ends, about so many of them; none where the ends are the same but for rounding.
function ticks(low, high, count) {
  const span = high - low;
  if (!(span > 1e-12 * Math.max(Math.abs(low), Math.abs(high), 1e-290)) || !Number.isFinite(span)) return [];
  const rough = span / count, power = 10 ** Math.floor(Math.log10(rough)), step = power * [1, 2, 5, 10].find((one) => one * power >= rough);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * span && found.length < 100; k++) found.push(k * step);
  return found;
}

// Text of ticks with as many digits as they need to differ.
function tickText(value, all) {
  const step = all.length > 1 ? all[1] - all[0] : Math.abs(value) || 1;
  if (Math.abs(value) < 1e-9 * step) return "0";
  const size = Math.max(...all.map(Math.abs));
  const digits = Math.max(1, Math.ceil(Math.log10(size / step)) + 1);
  return short(value, Math.min(12, Math.max(digits, 2)));
}

// A colour of the theme, which is asked for once.
const COLOURS = new Map();

function colour(name) {
  if (!COLOURS.has(name)) {
    COLOURS.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  }
  return COLOURS.get(name);
}
