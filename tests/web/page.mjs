// The page at / opens in Chromium without an error and lists every asset.
//   node tests/web/page.mjs LODESTREAM_SERVER
import { open_browser, open_page } from "./browser.mjs";
import { list_assets, with_server } from "./server.mjs";

async function check_page(url) {
  const browser = await open_browser();
  try {
    const { page, errors } = await open_page(browser, url);
    for (const { name } of await list_assets(url)) await page.getByText(name, { exact: true }).first().waitFor({ timeout: 10_000 });
    return errors;
  } finally {
    await browser.close();
  }
}

const errors = await with_server(process.argv[2], null, check_page);
for (const error of errors) console.error(`console: ${error}`);
process.exitCode = errors.length > 0 ? 1 : 0;
