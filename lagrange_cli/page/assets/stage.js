// Which painter a page of a system in space takes.

const NO_WEBGL = "This browser has no WebGL: the drawing is a plain one.";

// What draws in space: three.js and space.js, which the page has packed. Without WebGL the painter of the plane does it.
async function inSpace(data) {
  const about = { alpha: false, antialias: true, preserveDrawingBuffer: true };
  if (!document.getElementById("scene").getContext("webgl2", about)) {
    data.notice = [data.notice, NO_WEBGL].filter(Boolean).join(" ");
    return Scene;
  }
  await addScript(data.space);
  return Space;
}
