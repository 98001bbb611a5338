// Rigid bodies as faces: corners in body axes, about the centre of mass.

const ROUND = 28;

function circle(radius, height) {
  return Array.from({ length: ROUND }, (_, i) => {
    const angle = 2 * Math.PI * i / ROUND;
    return [radius * Math.cos(angle), radius * Math.sin(angle), height];
  });
}

function drum(radius, height) {
  const [top, bottom] = [circle(radius, height / 2), circle(radius, -height / 2)];
  const sides = top.map((one, i) => [one, bottom[i], bottom[(i + 1) % ROUND], top[(i + 1) % ROUND]]);
  return [top, bottom.slice().reverse(), ...sides];
}

function box(a, b, c) {
  const corner = (i) => [(i & 1 ? a : -a) / 2, (i & 2 ? b : -b) / 2, (i & 4 ? c : -c) / 2];
  const faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  return faces.map((face) => face.map(corner));
}

function ball(radius) {
  const rings = 8, found = [];
  const at = (i, j) => {
    const [theta, phi] = [Math.PI * i / rings, 2 * Math.PI * j / ROUND];
    return [radius * Math.sin(theta) * Math.cos(phi), radius * Math.sin(theta) * Math.sin(phi), radius * Math.cos(theta)];
  };
  for (let i = 0; i < rings; i++) {
    for (let j = 0; j < ROUND; j++) found.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
  }
  return found;
}

function facesOf(shape, sizes) {
  if (shape === "sphere") return ball(sizes[0]);
  if (shape === "cylinder") return drum(sizes[0], sizes[1]);
  if (shape === "disc") return drum(sizes[0], sizes[0] / 20);
  if (shape === "rod") return drum(sizes[0] / 60, sizes[0]);
  return box(...sizes);
}

// Whether a face of a round body is one of those that are lighter.
function striped(shape, i) {
  if (shape === "sphere") return i % ROUND < ROUND / 2 === (i < ROUND * 4);
  return (shape === "cylinder" || shape === "disc") && i >= 2 && (i - 2) % (ROUND / 2) < 3;
}
