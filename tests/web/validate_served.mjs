// The real server bakes the samples and a few telling models; every ladder level and the plans of the four devices are judged,
// and lean and plain levels of the samples are weighed.
//   node tests/web/validate_served.mjs LODESTREAM_SERVER GLB_INSPECT
import { mkdtemp, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";

import { check_bytes } from "./bytes.mjs";
import { collect_levels, collect_plans, copy_models, list_assets, root, with_server } from "./server.mjs";
import { check_glbs } from "./validate.mjs";

const models = [
  "gltf/Duck.glb", // textured, UV seams
  "gltf/cube_vertexcolor.glb",
  "gltf/pins_instances.glb",
  "scene/CesiumMilkTruck.glb", // textured, four materials
  "scene/delft_city.glb", // 570 components
  "hard/mat_test_7materials.obj",
  "hard/mat_test.mtl",
  "hard/cycloidal_100comp_color.ply",
  "hard/edge_with_four_triangles.off",
  "hard/points_only.ply", // a cloud
  "hard/large_block_offset.STL",
  "classic/dragon_11k_res4.ply", // non-manifold
  "terrain/stubai_10m_georef_window.obj", // far from the origin
];

function distinct(glbs) {
  return [...new Map(glbs.map((glb) => [glb.bytes.toString("latin1"), glb])).values()];
}

async function check_served(url, inspect_program) {
  const failed = (await list_assets(url)).filter(({ status }) => status === "failed");
  for (const asset of failed) console.error(`${asset.name}: not baked: ${asset.error}`);
  const folder = path.join(root, "deploy/devices");
  const devices = (await readdir(folder)).map((name) => path.join(folder, name));
  const glbs = [...(await collect_levels(url)), ...(await collect_plans(url, devices))];
  const bad = await check_glbs(distinct(glbs), inspect_program);
  return failed.length + bad + (await check_bytes(url, ["teapot", "ship", "terrain"]));
}

const [server_program, inspect_program] = process.argv.slice(2);
const folder = await mkdtemp(path.join(tmpdir(), "lodestream-models-"));
try {
  await copy_models(models, folder);
  const bad = await with_server(server_program, folder, (url) => check_served(url, inspect_program));
  process.exitCode = bad > 0 ? 1 : 0;
} finally {
  await rm(folder, { recursive: true });
}
