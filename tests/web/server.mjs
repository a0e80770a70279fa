// Starts the real server for a test, and fetches what it serves.
import { spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { cp, mkdtemp, readFile, rm } from "node:fs/promises";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

export const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
const shared_data = process.env.LODESTREAM_DATA ?? path.join(root, "../shared/data");

const progress_limit_ms = 400_000;
const poll_ms = 250;
const stop_limit_ms = 10_000;

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

async function free_port() {
  const probe = createServer();
  await new Promise((resolve) => probe.listen(0, "127.0.0.1", resolve));
  const { port } = probe.address();
  await new Promise((resolve) => probe.close(resolve));
  return port;
}

async function get_json(url, options) {
  const answer = await fetch(url, options);
  const body = await answer.json();
  if (!answer.ok) throw new Error(`${url}: ${answer.status} ${body.title}: ${body.detail}`);
  return body;
}

export const list_assets = async (url) => (await get_json(`${url}/v1/assets`)).assets;

// Resolves once no asset is baking any more; a slow machine is given time for as long as bakes go on.
async function baked(url, child) {
  let end = Date.now() + progress_limit_ms;
  let baking = "none listed yet";
  while (Date.now() < end) {
    if (child.exitCode !== null) throw new Error(`the server stopped with exit code ${child.exitCode}`);
    const ready = await fetch(`${url}/readyz`).then((answer) => answer.ok, () => false);
    const assets = ready ? await list_assets(url) : [];
    const left = assets.filter(({ status }) => status === "baking").map(({ name, progress }) => `${name} at ${progress}`);
    if (assets.length > 0 && left.length === 0) return;
    if (ready && left.join(", ") !== baking) {
      baking = left.join(", ");
      end = Date.now() + progress_limit_ms;
    }
    await pause(poll_ms);
  }
  throw new Error(`no bake went on for ${progress_limit_ms / 1000} s: ${baking}`);
}

// Copies models of the shared data to a folder; where that is not here, it says that the samples alone are used.
export async function copy_models(models, folder) {
  if (!existsSync(shared_data)) return console.log(`${shared_data} is not here: the samples alone are checked`);
  for (const model of models) await cp(path.join(shared_data, model), path.join(folder, path.basename(model)));
}

async function run(program, args) {
  const child = spawn(program, args, { stdio: ["ignore", "ignore", "inherit"] });
  const code = await new Promise((resolve) => child.on("exit", resolve));
  if (code !== 0) throw new Error(`${[program, ...args].join(" ")}: exit code ${code}`);
}

// Runs `use(url)` against a server with the samples and, where given, the models of a folder, and what `more` names,
// which is baked before.
export async function with_server(program, assets, use, more = []) {
  const store = await mkdtemp(path.join(tmpdir(), "lodestream-web-"));
  const url = `http://127.0.0.1:${await free_port()}`;
  if (more.length > 0) await run(program, ["bake", ...more, "--store", store]);
  const args = ["serve", "--listen", url.slice("http://".length), "--store", store, "--samples"];
  const child = spawn(program, assets ? [...args, "--assets", assets] : args, { stdio: ["ignore", "ignore", "inherit"] });
  const stopped = new Promise((resolve) => child.on("exit", resolve));
  try {
    await baked(url, child);
    return await use(url);
  } finally {
    child.kill("SIGTERM");
    await Promise.race([stopped, pause(stop_limit_ms).then(() => child.kill("SIGKILL"))]);
    await rm(store, { recursive: true, force: true });
  }
}

async function fetch_glb(url, name) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.status}`);
  return { name, bytes: Buffer.from(await answer.arrayBuffer()) };
}

// The GLB of every level of every ready asset, as {name, bytes}.
export async function collect_levels(url) {
  const glbs = [];
  for (const asset of await list_assets(url))
    for (const level of asset.status === "ready" ? asset.levels : [])
      glbs.push(await fetch_glb(new URL(level.url, url), `${asset.name}, level of ${level.triangles}`));
  return glbs;
}

// What a plan request is answered with, and its GLB as {name, bytes}.
export async function fetch_plan(url, request) {
  const options = { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(request) };
  const plan = await get_json(`${url}/v1/plans`, options);
  return { plan, glb: await fetch_glb(new URL(plan.content.url, url), `${request.asset}, ${plan.level.triangles} triangles`) };
}

// The GLB that each device's plan answers with, for every ready asset.
export async function collect_plans(url, device_files) {
  const points = ["plain", "lean"].map((profile) => ({ primitives: "points", profile }));
  const glbs = [];
  for (const file of device_files) {
    const device = JSON.parse(await readFile(file));
    for (const asset of (await list_assets(url)).filter(({ status }) => status === "ready"))
      for (const asked of asset.kind === "points" ? points : [{ primitives: "triangles" }, ...points]) {
        const { plan, glb } = await fetch_plan(url, { asset: asset.name, ...device, ...asked });
        const what = `${plan.content.profile}${asked.primitives === "points" ? " points" : ""}`;
        glbs.push({ ...glb, name: `${asset.name}, ${what} plan for ${path.basename(file, ".json")}` });
      }
  }
  return glbs;
}
