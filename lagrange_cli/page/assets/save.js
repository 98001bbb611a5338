// Files of what is shown.

function save(blob, name) {
  const link = document.createElement("a"), url = URL.createObjectURL(blob);
  link.href = url;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

function cell(text) { return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text; }

// A table of all samples.
function table(motion, data, observed) {
  const names = ["t", ...data.coordinates.map((one) => one.name), ...data.velocities, ...observed];
  const n = data.coordinates.length;
  const rows = [motion.times, ...Array.from({ length: n }, (_, k) => motion.q(k)), ...Array.from({ length: n }, (_, k) => motion.v(k)),
    ...observed.map((_, k) => motion.quantity(k))];
  const lines = [names.map(cell).join(",")];
  for (let i = 0; i < motion.observed; i++) lines.push(rows.map((row) => row[i]).join(","));
  return `${lines.join("\n")}\n`;
}

// The canvas on the paper's colour: a picture that can be printed.
function picture(canvas) {
  const copy = document.createElement("canvas"), pen = copy.getContext("2d");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  pen.fillStyle = colour("paper");
  pen.fillRect(0, 0, copy.width, copy.height);
  pen.drawImage(canvas, 0, 0);
  return new Promise((done) => copy.toBlob(done, "image/png"));
}
