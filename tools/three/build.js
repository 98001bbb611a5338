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

// Nothing in a page is called `exec`, so that nobody has to find out of what: texts are searched by `match` and
// `matchAll` instead of RegExp.prototype.exec, which gives the same.
const PARTS = [
  ["RePathPart.lastIndex = 0;", "const parts = path.matchAll( RePathPart );"],
  ["RePathPart.exec( path )", "parts.next().value"],
  ["matchEnd = RePathPart.lastIndex", "matchEnd = match.index + match[ 0 ].length"],
];
function searched(contents) {
  for (const [before, after] of PARTS) contents = contents.replace(before, after);
  return contents.replace(/(\/(?:\\.|[^\/\n])+\/)\.exec\( (\w+) \)/g, "$2.match( $1 )");
}

const without = {
  name: "without",
  setup({ onLoad }) {
    onLoad({ filter: /\.glsl\.js$/ }, ({ path }) => {
      const left = PIECES.has(basename(path, ".glsl.js"));
      return left ? undefined : { contents: 'export const vertex = "", fragment = ""; export default "";' };
    });
    onLoad({ filter: /\.js$/ }, ({ path }) => {
      return { contents: ABSENT[basename(path, ".js")] ?? searched(readFileSync(path, "utf8")) };
    });
  },
};

const { outputFiles: [made] } = await build({
  entryPoints: [join(here, "parts.js")], bundle: true, minify: true, format: "iife", globalName: "THREE", target: "es2022",
  legalComments: "none", plugins: [without], write: false,
});
const running = made.text.match(/\b(?:exec|eval|Function)\s*\(/g);
if (running) throw new Error(`three.js calls ${running.join(", ")}: search texts by match`);
const license = readFileSync(join(three, "LICENSE"), "utf8").trim();
const text = `/* three.js ${version}, ${homepage}, as far as pages use it: made by tools/three/build.js.

It calls neither \`eval\` nor \`exec\` nor \`Function\`, and \`setTimeout\` is given functions: no text is run as a program.
Of a system file only colours get here, as text that \`spec/draw/colours.py\` has checked: a known name, or # and
hexadecimal digits.

${license}
*/
${made.text}`;
writeFileSync(join(assets, "three.js"), text);
writeFileSync(join(assets, "three.LICENSE"), `${license}\n`);
console.log(`three.js ${version}: ${text.length} bytes`);
