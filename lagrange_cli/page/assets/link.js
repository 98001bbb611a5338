// The state of all sliders in the address: #theta=0.5&l=2&t=3.1&speed=2.

const AT = "@t", SPEED = "@speed", MEMBER = "@member";

function address(values) {
  const text = Array.from(values, ([name, value]) => `${encodeURIComponent(name)}=${encodeURIComponent(value)}`);
  return text.length ? `#${text.join("&")}` : "#";
}

// The numbers in the address, by name; what is no number is left out.
function addressed(hash) {
  const found = new Map();
  for (const [name, text] of new URLSearchParams(hash.replace(/^#/, "").replaceAll("+", "%2B"))) {
    const value = text.trim() === "" ? NaN : Number(text);
    if (Number.isFinite(value)) found.set(name, value);
  }
  return found;
}
