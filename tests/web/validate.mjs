// Judges GLBs by others' eyes, and compares what three.js sees with what our own decoder sees.
//   node tests/web/validate.mjs --inspect build/release/bin/glb_inspect FOLDER_OR_SERVER_URL...
import { execFile } from "node:child_process";
import { mkdtemp, readdir, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { promisify } from "node:util";

import { open_browser, open_page, serve_pages } from "./browser.mjs";
import { collect_levels } from "./server.mjs";
import { structure_problems } from "./structure.mjs";

const files_a_call = 50;
const bounds_tolerance = 1e-6; // of the diagonal: three.js adds in float where we add in double

// What our own decoder says: a map from name to {triangles, gouraud, flat, bounds}, or null where it refuses the GLB.
async function inspect_all(program, glbs) {
  const folder = await mkdtemp(path.join(tmpdir(), "glb-inspect-"));
  try {
    const seen = new Map();
    for (let first = 0; first < glbs.length; first += files_a_call) {
      const some = glbs.slice(first, first + files_a_call);
      const files = some.map((_, i) => path.join(folder, `${first + i}.glb`));
      await Promise.all(some.map((glb, i) => writeFile(files[i], glb.bytes)));
      const { stdout, stderr } = await promisify(execFile)(program, files);
      if (stderr) console.error(stderr.trim());
      stdout.trim().split("\n").forEach((line, i) => seen.set(some[i].name, JSON.parse(line)));
    }
    return seen;
  } finally {
    await rm(folder, { recursive: true });
  }
}

function differences(ours, theirs) {
  if (ours === null) return ["our decoder refuses it"];
  const problems = [];
  for (const shading of ["gouraud", "flat"])
    if (ours[shading] !== theirs[shading])
      problems.push(`three.js: ${theirs[shading]} ${shading} triangles, our decoder: ${ours[shading]}`);
  if (ours.points !== theirs.points) problems.push(`three.js: ${theirs.points} points, our decoder: ${ours.points}`);
  if (theirs.wrongly_shaded > 0) problems.push(`three.js: ${theirs.wrongly_shaded} primitives with the wrong shading`);
  if (theirs.wrong_boxes > 0) problems.push(`three.js: ${theirs.wrong_boxes} accessors whose min and max are not their data's`);
  const extent = Math.hypot(...[0, 1, 2].map((axis) => ours.bounds[axis + 3] - ours.bounds[axis]));
  const is_one_point = ours.points > 0 && extent === 0; // no camera frames it, and its place is three.js' float
  if (theirs.pixels === 0 && !is_one_point) problems.push("three.js: draws nothing");
  const far = Math.max(...ours.bounds.map(Math.abs));
  const tolerance = bounds_tolerance * (is_one_point ? far : extent) + Number.EPSILON * 8 * far;
  if (ours.bounds.some((value, i) => !(Math.abs(value - theirs.bounds[i]) <= tolerance)))
    problems.push(`three.js: bounds ${theirs.bounds}, our decoder: ${ours.bounds}`);
  return problems;
}

async function three_problems(glbs, ours) {
  const problems = new Map();
  const pages = await serve_pages(new Map(glbs.map((glb, i) => [`/glb/${i}.glb`, glb.bytes])));
  const browser = await open_browser();
  try {
    const { page, errors } = await open_page(browser, `${pages.url}/viewer.html`);
    await page.waitForFunction(() => window.measure);
    for (const [i, glb] of glbs.entries()) {
      try {
        const theirs = await page.evaluate((url) => window.measure(url), `/glb/${i}.glb`);
        problems.set(glb.name, differences(ours.get(glb.name), theirs));
      } catch (error) {
        problems.set(glb.name, [`three.js: ${error.message.split("\n")[0]}`]);
      }
      problems.get(glb.name).push(...errors.splice(0).map((text) => `console: ${text}`));
    }
  } finally {
    await browser.close();
    pages.close();
  }
  return problems;
}

// Checks every GLB ({name, bytes}), prints a line for each that has a problem, and answers how many have one.
export async function check_glbs(glbs, inspect_program) {
  if (glbs.length === 0) throw new Error("there is no GLB to check");
  const ours = await inspect_all(inspect_program, glbs);
  const by_three = await three_problems(glbs, ours);
  let bad = 0;
  for (const glb of glbs) {
    const problems = [...(await structure_problems(glb.bytes)), ...by_three.get(glb.name)];
    for (const problem of problems) console.error(`${glb.name}: ${problem}`);
    bad += Number(problems.length > 0);
  }
  const triangles = glbs.reduce((sum, glb) => sum + (ours.get(glb.name)?.triangles ?? 0), 0);
  console.log(`${glbs.length} GLBs, ${triangles} triangles: ${bad} with problems`);
  return bad;
}

async function read_folder(folder) {
  const names = (await readdir(folder, { recursive: true })).filter((name) => name.endsWith(".glb"));
  return Promise.all(names.sort().map(async (name) => ({ name, bytes: await readFile(path.join(folder, name)) })));
}

async function main(args) {
  const [flag, inspect_program, ...sources] = args;
  if (flag !== "--inspect" || sources.length === 0) {
    console.error("usage: node tests/web/validate.mjs --inspect GLB_INSPECT FOLDER_OR_SERVER_URL...");
    return 2;
  }
  const collected = await Promise.all(sources.map((s) => (/^https?:/.test(s) ? collect_levels(s) : read_folder(s))));
  return (await check_glbs(collected.flat(), inspect_program)) > 0 ? 1 : 0;
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) process.exitCode = await main(process.argv.slice(2));
