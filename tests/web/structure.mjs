// Judges a GLB's structure: the Khronos validator, and the validator again on what glTF-Transform decodes from Draco and
// meshoptimizer's codec, because the validator does not look inside.
import { NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS, EXTMeshoptCompression, KHRDracoMeshCompression } from "@gltf-transform/extensions";
import draco3d from "draco3dgltf";
import validator from "gltf-validator";
import { MeshoptDecoder } from "three/examples/jsm/libs/meshopt_decoder.module.js";

const max_issues_shown = 5;
const error_severity = 0;
const warning_severity = 1;

const io = new NodeIO()
  .registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({ "draco3d.decoder": await draco3d.createDecoderModule(), "meshopt.decoder": MeshoptDecoder });

async function issues(bytes, worst_allowed, where) {
  const report = await validator.validateBytes(bytes, { maxIssues: 0 });
  const bad = report.issues.messages.filter((message) => message.severity < worst_allowed);
  const shown = bad.slice(0, max_issues_shown).map((m) => `${where}: ${m.code} ${m.message} at ${m.pointer ?? m.offset}`);
  return bad.length > shown.length ? [...shown, `${where}: ${bad.length - shown.length} more`] : shown;
}

async function decoded(bytes) {
  const document = await io.readBinary(bytes);
  for (const used of document.getRoot().listExtensionsUsed())
    if (used instanceof KHRDracoMeshCompression || used instanceof EXTMeshoptCompression) used.dispose();
  return io.writeBinary(document);
}

// What the validator says of the container alone, for content that only this project decodes; empty where all is well.
export async function container_problems(bytes) {
  return issues(bytes, warning_severity + 1, "validator");
}

// The list of what is wrong; empty where all is well.
export async function structure_problems(bytes) {
  const problems = await container_problems(bytes);
  try {
    return [...problems, ...(await issues(await decoded(bytes), error_severity + 1, "validator, decoded"))];
  } catch (error) {
    return [...problems, `glTF-Transform: ${error.message}`];
  }
}
