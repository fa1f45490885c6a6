// Live pages in Firefox, driven by mouse, touch and keys over WebDriver BiDi. What is tested comes in the environment:
//
//   BKSIM_LIVE_PAGES   a JSON file: {"firefox", "screenshots", "pages": {"four-bar": file, "empty": file}}

import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';

import puppeteer from 'puppeteer-core';

const plan = process.env.BKSIM_LIVE_PAGES && JSON.parse(fs.readFileSync(process.env.BKSIM_LIVE_PAGES, 'utf8'));
const skip = plan?.firefox ? false : 'no module of live pages, or no Firefox';

let browser;

before(async () => {
  if (skip) return;
  fs.mkdirSync(plan.screenshots, { recursive: true });
  browser = await puppeteer.launch({ browser: 'firefox', executablePath: plan.firefox, headless: true });
});

after(() => browser?.close());

/** Opens a page, and closes it again after `use`; nothing may be said on the way. */
async function opened(name, use) {
  const page = await browser.newPage();
  await page.setViewport({ width: 1280, height: 860 });
  const faults = [];
  page.on('console', (message) => faults.push(`console: ${message.text()}`));
  page.on('pageerror', (error) => faults.push(`error: ${error.message}`));
  await page.goto(pathToFileURL(plan.pages[name]).href);
  await page.waitForFunction(() => document.documentElement.dataset.ready === 'yes');
  await idle(page);
  await use(page);
  await page.screenshot({ path: path.join(plan.screenshots, `firefox-${name}.png`) });
  assert.deepEqual(faults, []);
  await page.close();
}

const idle = (page) => page.waitForFunction(() => globalThis.bksim.isIdle);
const text = (page) => page.evaluate(() => globalThis.bksim.state.text);

/** The pixel of the window at a place of the world. */
const pixel = (page, x, y) => page.evaluate((p) => {
  const { left, top } = document.getElementById('picture').getBoundingClientRect();
  const [px, py] = globalThis.bksim.camera.project(p);
  return [left + px, top + py];
}, [x, y, 0]);

/** The end of the crank in the world. */
const crank = (page) => page.evaluate(() => {
  const { numbers: n } = globalThis.bksim;
  return [n[18] + 0.1 * n[21], n[19] + 0.1 * n[24]];
});

test('Firefox: the crank is dragged by mouse, finger and keys', { skip }, () =>
  opened('four-bar', async (page) => {
    const from = await pixel(page, ...(await crank(page)));
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move(...(await pixel(page, -0.06, 0.08)), { steps: 10 });
    await idle(page);
    await page.mouse.up();
    await idle(page);
    const dragged = await crank(page);
    assert.ok(Math.hypot(dragged[0] + 0.06, dragged[1] - 0.08) < 2e-3, `${dragged}`);
    await page.touchscreen.touchStart(...(await pixel(page, ...dragged)));
    for (const angle of [2.1, 2.0, 1.9, 1.8]) {
      await page.touchscreen.touchMove(...(await pixel(page, 0.1 * Math.cos(angle), 0.1 * Math.sin(angle))));
      await idle(page);
    }
    await page.touchscreen.touchEnd();
    await idle(page);
    const touched = await crank(page);
    assert.ok(Math.hypot(touched[0] - 0.1 * Math.cos(1.8), touched[1] - 0.1 * Math.sin(1.8)) < 2e-3, `${touched}`);
    await page.focus('#picture');
    for (let k = 0; k < 6; k += 1) {
      await page.keyboard.press('n');
      await page.keyboard.press('Enter');
      for (let i = 0; i < 6; i += 1) await page.keyboard.press('ArrowLeft');
      await idle(page);
      await page.keyboard.press('Enter');
      await idle(page);
    }
    const keyed = await crank(page);
    assert.ok(Math.hypot(keyed[0] - touched[0], keyed[1] - touched[1]) > 1e-3, 'nothing moved');
  }));

test('Firefox: a four-bar is drawn from nothing and moves', { skip }, () =>
  opened('empty', async (page) => {
    const click = async (x, y) => {
      await page.mouse.click(...(await pixel(page, x, y)));
      await idle(page);
    };
    const [a, b, c, d] = [[-0.15, -0.05], [-0.1, 0.03], [0.1, 0.08], [0.08, -0.06]];
    await page.click('[data-tool=link]');
    for (const end of [a, b, b, c, c, d]) await click(...end);
    await page.click('[data-tool=ground]');
    for (const end of [a, d]) await click(...end);
    await page.click('[data-tool=motor]');
    await click(...a);
    await page.click('#play');
    await page.waitForFunction(() => globalThis.bksim.time > 0.1);
    await page.click('#play');
    await idle(page);
    assert.match(await text(page), /\[bodies\.link3\]/);
    assert.equal(await page.evaluate(() => globalThis.bksim.state.faults.filter((fault) => fault.is_error).length), 0);
  }));
