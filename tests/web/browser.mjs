// Chromium without a display, and a server on loopback for the page, three.js and the files that it is to load.
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const here = path.dirname(fileURLToPath(import.meta.url));
const media_types = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };

export function open_browser() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
           "--disable-background-networking", "--disable-dev-shm-usage"],
  });
}

async function answer(request, response, files) {
  const name = decodeURIComponent(new URL(request.url, "http://loopback").pathname);
  const below = path.join(here, path.normalize(name));
  try {
    const body = files.get(name) ?? (await readFile(below));
    response.writeHead(200, { "content-type": media_types[path.extname(name)] ?? "application/octet-stream" }).end(body);
  } catch {
    response.writeHead(404).end();
  }
}

// Serves this folder, and `files` (a map from path to bytes) on top of it.
export async function serve_pages(files) {
  const server = createServer((request, response) => answer(request, response, files));
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

// A page whose errors are collected in `errors`.
export async function open_page(browser, url) {
  const page = await browser.newPage();
  const errors = [];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(url);
  return { page, errors };
}
