// 3DTilesRendererJS and CesiumJS load the tileset of every scene and of a cloud: no tile fails, close views are refined down to the leaves,
// far ones are not, every leaf is covered once, and the finest picture is that of the whole model.
// One of the scenes is of instances, whose tiles share contents, and is told in several documents.
// Then all nodes of a scene are turned and moved while it is served: seen by a camera that is turned and moved likewise, it
// shows the same.
//   node tests/web/tileset.mjs LODESTREAM_SERVER [FOLDER_FOR_PICTURES]
import { mkdir, mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";

import { open_browser, open_page, serve_pages } from "./browser.mjs";
import { copy_models, fetch_plan, list_assets, with_server } from "./server.mjs";

const samples = ["sample:fine-ship:600"];
const models = ["gltf/pins_instances.glb", "scene/2CylinderEngine.glb", "scene/CesiumMilkTruck.glb"];

const finest_px = 1e-3, usual_px = 16;
const most_moved_tiles = 30;
const most_silhouette = 0.003; // of the pixels that show something: edges fall between pixels differently
const most_color = 0.02;

// With what is told in other documents in place of the tiles that name these.
async function fetch_tileset(url) {
  const tileset = await (await fetch(url)).json();
  let documents = 1;
  const open = async (tile) => {
    const uri = tile.content.uri;
    if (uri.split("?")[0].endsWith(".json")) {
      ++documents;
      const { root } = await (await fetch(new URL(uri, url))).json();
      if (root.content.uri !== tile.extras.content) throw new Error(`${uri}: another content than the tile tells that names it`);
      Object.assign(tile, { content: root.content, children: root.children });
    }
    for (const child of tile.children ?? []) await open(child);
  };
  await open(tileset.root);
  return { ...tileset, documents };
}

// As tiles.mjs names them.
const name_of = ({ content, extras }) => extras?.id ?? content.uri.split("/").pop();

function* tiles_below(tile) {
  yield tile;
  for (const child of tile.children ?? []) yield* tiles_below(child);
}

function view_of({ bounds_min: low, bounds_max: high }, radii, error_px) {
  const target = low.map((l, i) => (l + high[i]) / 2);
  const radius = Math.hypot(...low.map((l, i) => high[i] - l)) / 2;
  const direction = [0.48, 0.36, 0.8];
  return { eye: target.map((t, i) => t + radii * radius * direction[i]), target, up: [0, 1, 0], fov_y_deg: 45, error_px };
}

// How many of the drawn tiles stand on the way from the root to each leaf: one, or the picture has a hole or shows a place twice.
function covers_each_leaf_once(tile, drawn, above = 0) {
  const covers = above + Number(drawn.has(name_of(tile)));
  return tile.children ? tile.children.every((child) => covers_each_leaf_once(child, drawn, covers)) : covers === 1;
}

const names = (tiles) => new Set(tiles.map(name_of));
const equal = (a, b) => a.size === b.size && [...a].every((name) => b.has(name));

async function save(folder, name, data_url) {
  if (folder) await writeFile(path.join(folder, name), Buffer.from(data_url.split(",")[1], "base64"));
}

async function check_asset(page, url, asset, pictures) {
  const problems = [];
  const tileset_url = `${url}/v1/assets/${asset.id}/tileset.json`;
  const tileset = await fetch_tileset(tileset_url);
  const tiles = [...tiles_below(tileset.root)];
  const leaves = names(tiles.filter(({ children }) => !children));
  const near = view_of(asset, 2.8, finest_px), far = view_of(asset, 400, usual_px);
  const glb = new URL(asset.levels[0].url, url).href;

  const three = await page.evaluate(([t, g, v]) => window.measure_three(t, g, v), [tileset_url, glb, far]);
  if (!equal(new Set(three.drawn), names([tileset.root]))) problems.push(`three.js, far away: ${three.drawn.length} tiles, not the root`);
  const finest = await page.evaluate(([t, g, v]) => window.measure_three(t, g, v), [tileset_url, glb, near]);
  await save(pictures, `${asset.id}-three.png`, await page.evaluate(() => window.picture_three()));
  const cesium = await page.evaluate(([t, v]) => window.measure_cesium(t, v), [tileset_url, near]);
  await save(pictures, `${asset.id}-cesium.png`, cesium.picture);
  for (const [viewer, { drawn, failed }] of Object.entries({ "three.js": finest, CesiumJS: cesium })) {
    if (failed > 0) problems.push(`${viewer}: ${failed} tiles failed`);
    if (!covers_each_leaf_once(tileset.root, new Set(drawn))) problems.push(`${viewer}: a leaf is not covered once by ${drawn.length} tiles`);
    if (!equal(new Set(drawn), leaves)) problems.push(`${viewer}: ${drawn.length} tiles drawn, not the ${leaves.size} leaves`);
  }
  const { silhouette, color, pixels } = finest.difference;
  if (!(pixels > 0 && silhouette <= most_silhouette && color <= most_color))
    problems.push(`beside the whole model: ${pixels} pixels, ${silhouette} of the silhouette and ${color} of the colours differ`);
  if (asset.name === "fine-ship" && (tileset.documents < 2 || new Set(tiles.map(({ content }) => content.uri)).size > tiles.length / 2))
    problems.push("it shows neither several documents nor shared contents");
  console.log(`${asset.name}: ${tiles.length} tiles in ${tileset.documents} documents, ${leaves.size} leaves; silhouette ${(100 * silhouette).toFixed(3)} %, ` +
              `colour ${(100 * color).toFixed(3)} % of ${pixels} pixels differ; ${problems.length} problems`);
  for (const problem of problems) console.error(`${asset.name}: ${problem}`);
  return problems.length;
}

// Even points on a ball, as a PLY file without faces.
function ball_of_points(count) {
  const header = ["ply", "format ascii 1.0", `element vertex ${count}`, ..."x y z nx ny nz".split(" ").map((p) => `property float ${p}`), "end_header"];
  const lines = Array.from({ length: count }, (_, i) => {
    const height = 1 - (2 * i + 1) / count, around = Math.sqrt(1 - height * height), turn = i * Math.PI * (3 - Math.sqrt(5));
    const place = [around * Math.cos(turn), height, around * Math.sin(turn)].join(" ");
    return `${place} ${place}`;
  });
  return `${header.concat(lines).join("\n")}\n`;
}

// Tiles of points add to each other: from far the root alone is drawn, from near all of them, which are the whole cloud.
async function check_cloud(page, url, asset, pictures) {
  const problems = [];
  const tileset_url = `${url}/v1/assets/${asset.id}/tileset.json`;
  const tileset = await (await fetch(tileset_url)).json();
  const all = names([...tiles_below(tileset.root)]);
  const near = view_of(asset, 2.8, finest_px), far = view_of(asset, 400, usual_px);
  const whole = { asset: asset.id, primitives: "points", device: { cpu_mhz: 1e9 }, display: { width: 16384, height: 16384 }, preference: { target_fps: 1 } };
  const { plan } = await fetch_plan(url, whole);
  const glb = new URL(plan.content.url, url).href;
  if (all.size < 2) problems.push("one tile alone");
  const root = await page.evaluate(([t, g, v]) => window.measure_three(t, g, v), [tileset_url, glb, far]);
  if (!equal(new Set(root.drawn), names([tileset.root]))) problems.push(`three.js, far away: ${root.drawn.length} tiles, not the root`);
  const three = await page.evaluate(([t, g, v]) => window.measure_three(t, g, v), [tileset_url, glb, near]);
  await save(pictures, `${asset.id}-three.png`, await page.evaluate(() => window.picture_three()));
  const cesium = await page.evaluate(([t, v]) => window.measure_cesium(t, v), [tileset_url, near]);
  await save(pictures, `${asset.id}-cesium.png`, cesium.picture);
  for (const [viewer, { drawn, failed }] of Object.entries({ "three.js": three, CesiumJS: cesium })) {
    if (failed > 0) problems.push(`${viewer}: ${failed} tiles failed`);
    if (!equal(new Set(drawn), all)) problems.push(`${viewer}: ${drawn.length} tiles drawn, not all ${all.size}`);
  }
  const { silhouette, color, pixels } = three.difference;
  if (!(pixels > 0 && silhouette <= most_silhouette && color <= most_color))
    problems.push(`beside the whole cloud: ${pixels} pixels, ${silhouette} of the silhouette and ${color} of the colours differ`);
  console.log(`${asset.name}: ${all.size} tiles of ${plan.level.points} points; silhouette ${(100 * silhouette).toFixed(3)} % of ${pixels} pixels differs; ${problems.length} problems`);
  for (const problem of problems) console.error(`${asset.name}: ${problem}`);
  return problems.length;
}

// By the radius along each axis, and a turn about y, by which the pages' light does not change.
function motion_of({ bounds_min: low, bounds_max: high }) {
  const radius = Math.hypot(...low.map((l, i) => high[i] - l)) / 2, angle = 1.1;
  return { translation: [1.5 * radius, -0.7 * radius, 0.4 * radius], angle, rotation: [0, Math.sin(angle / 2), 0, Math.cos(angle / 2)] };
}

function moved_view(view, { translation, angle }) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const moved = ([x, y, z]) => [c * x + s * z, y, c * z - s * x].map((v, i) => v + translation[i]);
  return { ...view, eye: moved(view.eye), target: moved(view.target) };
}

const leaves_of = (tileset) => [...tiles_below(tileset.root)].filter(({ children }) => !children);

async function check_moved(page, url, asset) {
  const tileset_url = `${url}/v1/assets/${asset.id}/tileset.json`, motion = motion_of(asset);
  const { translation, rotation } = motion;
  const { nodes } = await (await fetch(`${url}/v1/assets/${asset.id}/nodes`)).json();
  const roots = nodes.filter(({ parent }) => parent === null).map(({ node }) => ({ node, translation, rotation }));
  const answer = await fetch(`${url}/v1/assets/${asset.id}/nodes`, { method: "PATCH", body: JSON.stringify({ nodes: roots }) });
  if (!answer.ok) throw new Error(`${asset.name}: ${await answer.text()}`);
  let tileset;
  do tileset = await (await fetch(`${tileset_url}`)).json();
  while (leaves_of(tileset).some(({ geometricError }) => geometricError > 0));
  const problems = [], moved = [...tiles_below(tileset.root)].filter(({ transform }) => transform).length;
  if (moved === 0) problems.push("no tile has moved");
  const view = view_of(asset, 2.8, finest_px), glb = new URL(asset.levels[0].url, url).href;
  const three = await page.evaluate(([t, g, v, w]) => window.measure_three(t, g, v, w), [tileset_url, glb, moved_view(view, motion), view]);
  const cesium = await page.evaluate(([t, v]) => window.measure_cesium(t, v), [tileset_url, moved_view(view, motion)]);
  for (const [viewer, { failed, drawn }] of Object.entries({ "three.js": three, CesiumJS: cesium })) {
    if (failed > 0) problems.push(`moved, ${viewer}: ${failed} tiles failed`);
    if (drawn.length === 0) problems.push(`moved, ${viewer}: nothing is drawn`);
  }
  const { silhouette, color, pixels } = three.difference;
  if (!(pixels > 0 && silhouette <= most_silhouette && color <= most_color))
    problems.push(`moved, beside the whole model: ${pixels} pixels, ${silhouette} of the silhouette and ${color} of the colours differ`);
  console.log(`${asset.name}, moved: ${moved} tiles with a transform; silhouette ${(100 * silhouette).toFixed(3)} %, ` +
              `colour ${(100 * color).toFixed(3)} % of ${pixels} pixels differ; ${problems.length} problems`);
  for (const problem of problems) console.error(`${asset.name}: ${problem}`);
  return problems.length;
}

async function check_tilesets(url, pictures) {
  const pages = await serve_pages(new Map());
  const browser = await open_browser();
  try {
    const ready = (await list_assets(url)).filter(({ status }) => status === "ready");
    const scenes = ready.filter(({ hierarchy }) => hierarchy), clouds = ready.filter(({ kind }) => kind === "points");
    if (scenes.length === 0 || clouds.length === 0) throw new Error("no scene or no cloud was baked");
    if (!scenes.some(({ name }) => name === "fine-ship")) throw new Error("no scene of instances was baked");
    let bad = 0;
    for (const asset of [...scenes, ...clouds]) {
      const { page, errors } = await open_page(browser, `${pages.url}/tiles.html`);
      await page.waitForFunction(() => window.measure_cesium);
      bad += await (asset.kind === "points" ? check_cloud : check_asset)(page, url, asset, pictures);
      if (asset.hierarchy?.tiles <= most_moved_tiles) bad += await check_moved(page, url, asset);
      for (const error of errors) console.error(`${asset.name}: console: ${error}`);
      bad += errors.length;
      await page.close();
    }
    return bad;
  } finally {
    await browser.close();
    pages.close();
  }
}

const [server_program, pictures] = process.argv.slice(2);
const folder = await mkdtemp(path.join(tmpdir(), "lodestream-scenes-"));
try {
  await copy_models(models, folder);
  await writeFile(path.join(folder, "ball.ply"), ball_of_points(60_000));
  if (pictures) await mkdir(pictures, { recursive: true });
  process.exitCode = (await with_server(server_program, folder, (url) => check_tilesets(url, pictures), samples)) > 0 ? 1 : 0;
} finally {
  await rm(folder, { recursive: true });
}
