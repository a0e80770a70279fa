// The bytes of a level, plain and lean, beside the same level as gltf-transform's `draco` command writes it by default (positions of
// 14 bits, normals 10, texture coordinates 12, colours 8), and beside uncompressed glTF. The peer is given what our level decodes to:
// positions on our grid and normals that repeat, which it codes in fewer bytes than the level itself (for that, see the benchmark
// codec). By itself it prints the table for the samples and a folder of models:
//   node tests/web/bytes.mjs LODESTREAM_SERVER [FOLDER_OF_MODELS]
import { NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS, KHRDracoMeshCompression } from "@gltf-transform/extensions";
import draco3d from "draco3dgltf";
import { pathToFileURL } from "node:url";

import { fetch_plan, list_assets, with_server } from "./server.mjs";
import { container_problems } from "./structure.mjs";

// What rounding saves the peer is up to a twentieth where most vertices are corners of boxes (the ship).
const most_of_peers = 1.05;
const counts = [300, 1000, 5000, 20000, 60000];
const gltf_transform_defaults = {
  method: KHRDracoMeshCompression.EncoderMethod.EDGEBREAKER,
  encodeSpeed: 5,
  decodeSpeed: 5,
  quantizationBits: { POSITION: 14, NORMAL: 10, COLOR: 8, TEX_COORD: 12, GENERIC: 12 },
  quantizationVolume: "mesh",
};

const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  "draco3d.decoder": await draco3d.createDecoderModule(),
  "draco3d.encoder": await draco3d.createEncoderModule(),
});

function without_extras(document) {
  document.getRoot().getAsset().extras = undefined;
  return document;
}

// How many bytes the same level takes uncompressed, and by gltf-transform's defaults.
async function peers(bytes) {
  const document = without_extras(await io.readBinary(bytes));
  document.getRoot().listExtensionsUsed().find((used) => used instanceof KHRDracoMeshCompression)?.dispose();
  const uncompressed = (await io.writeBinary(document)).length;
  document.createExtension(KHRDracoMeshCompression).setRequired(true).setEncoderOptions(gltf_transform_defaults);
  return { uncompressed, draco: (await io.writeBinary(document)).length };
}

function request(asset, triangles, profile) {
  const preference = { triangles, target_fps: 1 };
  return { asset, device: { cpu_mhz: 34000 }, preference, profile, shading: "gouraud" };
}

async function compare(url, asset, triangles) {
  const plain = await fetch_plan(url, request(asset, triangles, "plain"));
  const lean = await fetch_plan(url, request(asset, triangles, "lean"));
  const { uncompressed, draco } = await peers(plain.glb.bytes);
  return {
    asset,
    triangles: plain.plan.level.triangles,
    plain: plain.glb.bytes.length / draco,
    lean: lean.glb.bytes.length / draco,
    uncompressed: plain.glb.bytes.length / uncompressed,
    problems: (await container_problems(lean.glb.bytes)).map((problem) => `${lean.glb.name}, lean: ${problem}`),
  };
}

// Prints a row for every level of the ready assets that `wanted` names (all where it is left out), and answers how many levels
// are larger lean than plain, larger than the peer's, or not valid glTF where they are lean.
export async function check_bytes(url, wanted) {
  const rows = [];
  console.log(`${"asset".padEnd(28)}triangles   plain    lean  of gltf-transform's, plain of uncompressed`);
  for (const { name, status } of await list_assets(url)) {
    if (status !== "ready" || (wanted && !wanted.includes(name))) continue;
    for (const triangles of counts) {
      const row = await compare(url, name, triangles);
      if (rows.some((other) => other.asset === row.asset && other.triangles === row.triangles)) continue;
      rows.push(row);
      const ratios = [row.plain, row.lean, row.uncompressed].map((ratio) => ratio.toFixed(3).padStart(8)).join("");
      console.log(`${name.padEnd(28)}${String(row.triangles).padStart(9)}${ratios}`);
    }
  }
  if (rows.length === 0) throw new Error("there is no level to compare");
  for (const row of rows) {
    if (row.lean > row.plain) row.problems.push(`${row.asset}, ${row.triangles} triangles: lean is larger than plain`);
    if (row.plain > most_of_peers) row.problems.push(`${row.asset}, ${row.triangles} triangles: larger than gltf-transform's`);
    for (const problem of row.problems) console.error(problem);
  }
  return rows.filter(({ problems }) => problems.length > 0).length;
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const [server_program, folder] = process.argv.slice(2);
  process.exitCode = (await with_server(server_program, folder, check_bytes)) > 0 ? 1 : 0;
}
