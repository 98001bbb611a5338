// Makes lagrange_cli/page/assets/three.js from npm's three:
//
//     cd tools/three && npm install && npm run build
//
// What pages do not use is left out: imports that nothing refers to (esbuild does that), and those that the
// renderer refers to for what pages do not have: textures, shadows, environments, headsets, physical materials.

import { readFileSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url)), three = join(here, "node_modules", "three");
const assets = join(here, "..", "..", "lagrange_cli", "page", "assets");
const { version, homepage } = JSON.parse(readFileSync(join(three, "package.json")));

// Pieces of shaders that plain and matt surfaces consist of. Others stand there for nothing.
const PIECES = new Set(`
  common begin_vertex beginnormal_vertex defaultnormal_vertex project_vertex worldpos_vertex
  color_vertex color_pars_vertex color_fragment color_pars_fragment colorspace_fragment colorspace_pars_fragment
  normal_vertex normal_pars_vertex normal_pars_fragment normal_fragment_begin
  bsdfs lights_pars_begin lights_lambert_fragment lights_lambert_pars_fragment lights_fragment_begin lights_fragment_end
  specularmap_fragment opaque_fragment premultiplied_alpha_fragment meshbasic meshlambert
`.trim().split(/\s+/));

// Modules of the renderer for what pages do not have, with as much as it calls of each.
const ABSENT = {
  WebXRManager: "export class WebXRManager { enabled = false; getEnvironmentBlendMode() {} addEventListener() {} removeEventListener() {} setAnimationLoop() {} dispose() {} }",
  WebGLEnvironments: "export function WebGLEnvironments() { return { get: () => null, dispose() {} }; }",
  WebGLMorphtargets: "export function WebGLMorphtargets() { return {}; }",
  WebGLOutput: "export function WebGLOutput() {}",
  WebGLShadowMap: "export function WebGLShadowMap() { this.render = () => {}; }",
  WebGLTextures: `export function WebGLTextures() {
    for (const name of ["getTextureUnits", "resetTextureUnits", "setTextureUnits", "dispose"]) this[name] = () => {};
  }`,
  WebGLUniformsGroups: "export function WebGLUniformsGroups() { return { dispose() {} }; }",
  DFGLUTData: "export function getDFGLUT() {}",
};

const without = {
  name: "without",
  setup({ onLoad }) {
    onLoad({ filter: /\.glsl\.js$/ }, ({ path }) => {
      const left = PIECES.has(basename(path, ".glsl.js"));
      return left ? undefined : { contents: 'export const vertex = "", fragment = ""; export default "";' };
    });
    onLoad({ filter: /\.js$/ }, ({ path }) => {
      const contents = ABSENT[basename(path, ".js")];
      return contents && { contents };
    });
  },
};

const { outputFiles: [made] } = await build({
  entryPoints: [join(here, "parts.js")], bundle: true, minify: true, format: "iife", globalName: "THREE", target: "es2022",
  legalComments: "none", plugins: [without], write: false,
});
// Every call of `exec` says where it stands why it is safe, in the order in which they stand.
const COLOUR = "a checked colour (spec/draw/colours.py): searched, not run";
const SAFE = [
  COLOUR, COLOUR, COLOUR, COLOUR, COLOUR, "a name in three.js's own shaders: searched, not run",
  "a message of the compiler of shaders: searched, not run", "the version of WebGL: searched, not run",
  "the version of WebGL: searched, not run",
];
const calls = made.text.match(/\bexec\(/g).length;
if (calls !== SAFE.length) throw new Error(`three.js calls exec ${calls} times: say of each why it is safe`);
const parts = made.text.split(/(?<=\bexec\()/);
const explained = parts.map((part, i) => (i < SAFE.length ? `${part}/* ${SAFE[i]} */` : part)).join("");
const license = readFileSync(join(three, "LICENSE"), "utf8").trim();
const text = `/* three.js ${version}, ${homepage}, as far as pages use it: made by tools/three/build.js.

\`exec\` in it is always that of a regular expression, which matches text, such as a colour of the system file, and runs
none. \`setTimeout\` is given functions. It calls neither \`eval\` nor \`Function\`: no text is run as a program.

${license}
*/
// Why each \`exec\` below is safe: all nine are RegExp.prototype.exec, which searches a text and runs none of it.
// - Five in Color.setStyle take a colour apart. Of a system file only colours get here, as text that
//   \`spec/draw/colours.py\` has checked: a known name, or # and hexadecimal digits.
// - One takes apart the name of a variable of a shader; all shaders are three.js's own.
// - One finds the line in an error message of the compiler of shaders, two the number in the version of WebGL.
// Each says so where it stands.
// tests/test_structure.py counts them, and checks that there is neither \`eval\` nor \`Function\`.
${explained}`;
writeFileSync(join(assets, "three.js"), text);
writeFileSync(join(assets, "three.LICENSE"), `${license}\n`);
console.log(`three.js ${version}: ${text.length} bytes`);
