// The page in a real browser. What is tested comes in the environment:
//
//   BKSIM_PAGES        a JSON file: {"browser", "screenshots", "pages": [{"name", "file", "instants":
//                      [{"t", "poses"}], "hostile"} …]}, poses as Rust's playback has them
//   BKSIM_REFERENCES   the folder of reference pictures
//   BKSIM_BLESS        write them anew

import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';

import pixelmatch from 'pixelmatch';
import { chromium } from 'playwright-core';
import { PNG } from 'pngjs';

import { tickTexts } from '../src/numbers.js';

const plan = JSON.parse(fs.readFileSync(process.env.BKSIM_PAGES, 'utf8'));
const references = process.env.BKSIM_REFERENCES;

/** Largest difference between a number of a pose and Rust's, as a part of the largest number. */
const CLOSE = 1e-9;
/** Part of what is drawn that may differ: other fonts and another version of the browser. */
const ALLOWED = 0.1;
/** Widths that every page is looked at with. */
const WIDTHS = [360, 800, 1600];

// Without the last five the browser would ask its maker's servers for this and that.
const ARGUMENTS = [
  '--no-sandbox',
  '--disable-gpu',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

let browser;

before(async () => {
  fs.mkdirSync(plan.screenshots, { recursive: true });
  browser = await chromium.launch({ executablePath: plan.browser, args: ARGUMENTS });
});

after(() => browser?.close());

/** Opens a page, and closes it again after `use`; nothing may be said or asked for on the way. */
async function opened(file, options, use) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  const page = await context.newPage();
  const faults = [];
  page.on('console', (message) => {
    // Pixels are read by this test alone.
    if (!message.text().includes('getImageData')) faults.push(`console: ${message.text()}`);
  });
  page.on('pageerror', (error) => faults.push(`error: ${error.message}`));
  page.on('dialog', (dialog) => faults.push(`dialog: ${dialog.message()}`));
  page.on('request', (request) => {
    const url = request.url();
    if (!url.startsWith('file:') && !url.startsWith('data:')) faults.push(`request: ${url}`);
  });
  await page.goto(pathToFileURL(file).href);
  await page.waitForFunction(() => globalThis.bksim !== undefined);
  await settled(page);
  await use(page);
  assert.deepEqual(faults, []);
  await context.close();
}

/** Until what was asked for is drawn. */
async function settled(page) {
  await page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
  );
}

/** What the canvas shows. */
function picture(page) {
  return page.evaluate(() => document.getElementById('picture').toDataURL());
}

/** How many pixels differ between two pictures, as a part of those of the first that are drawn on. */
function difference(a, b) {
  if (a.width !== b.width || a.height !== b.height) return 1;
  const count = (other) =>
    pixelmatch(a.data, other, null, a.width, a.height, { threshold: 0.15, includeAA: true });
  // In the upper left corner of a picture is its background.
  const at = 4 * (20 * a.width + 20);
  const empty = Buffer.alloc(a.data.length, a.data.subarray(at, at + 4));
  return count(b.data) / count(empty);
}

/** Compares a screenshot with the reference of its name, and keeps it. */
function compare(name, bytes) {
  fs.writeFileSync(path.join(plan.screenshots, `${name}.png`), bytes);
  const reference = path.join(references, `${name}.png`);
  if (process.env.BKSIM_BLESS) fs.writeFileSync(reference, bytes);
  const part = difference(PNG.sync.read(bytes), PNG.sync.read(fs.readFileSync(reference)));
  assert.ok(part <= ALLOWED, `${name}: ${(100 * part).toFixed(1)} % of what is drawn differs`);
}

const first = plan.pages[0];

for (const { name, file, instants } of plan.pages) {
  test(`${name}: poses are those of the equations at any instant`, () =>
    opened(file, {}, async (page) => {
      for (const { t, poses } of instants) {
        const found = await page.evaluate((time) => globalThis.bksim.poses(time), t);
        assert.equal(found.length, poses.length);
        const size = Math.max(1, ...poses.map(Math.abs));
        const worst = Math.max(...found.map((x, i) => Math.abs(x - poses[i]))) / size;
        assert.ok(worst <= CLOSE, `t = ${t}: poses differ by ${worst}`);
      }
    }));

  test(`${name}: nothing overflows at any width, in both themes`, async () => {
    for (const width of WIDTHS) {
      for (const colorScheme of ['light', 'dark']) {
        const options = { viewport: { width, height: 900 }, colorScheme };
        await opened(file, options, async (page) => {
          const widest = await page.evaluate(() => document.documentElement.scrollWidth);
          assert.ok(widest <= width, `${widest} pixels wide at ${width}`);
          const [play, speed] = await Promise.all(
            ['#play', '#speed'].map((id) => page.locator(id).boundingBox()),
          );
          const isInRow = speed.y < play.y + play.height && play.y < speed.y + speed.height;
          assert.ok(isInRow, `the speed is ${speed.y - play.y} pixels below the buttons at ${width}`);
          const bytes = await page.screenshot({ fullPage: true });
          fs.writeFileSync(path.join(plan.screenshots, `${name}-${width}-${colorScheme}.png`), bytes);
        });
      }
    }
  });

  test(`${name}: the equations are typeset`, () =>
    opened(file, {}, async (page) => {
      const sizes = await page.evaluate(() =>
        [...document.querySelectorAll('#equations math')].map((math) => {
          const { width, height } = math.getBoundingClientRect();
          return [math.namespaceURI, width, height];
        }),
      );
      assert.ok(sizes.length >= 3, `${sizes.length} formulas`);
      for (const [namespace, width, height] of sizes) {
        assert.equal(namespace, 'http://www.w3.org/1998/Math/MathML');
        assert.ok(width > 5 && height > 5, `a formula of ${width} by ${height} pixels`);
      }
      const text = await page.textContent('#equations');
      assert.match(text, /Kinetic energy/);
      assert.match(text, /Equations of motion/);
    }));
}

test('a spatial mechanism turns by dragging, and moves with Shift', () => {
  const spatial = plan.pages.find(({ name }) => name === 'governor');
  return opened(spatial.file, {}, async (page) => {
    const view = () =>
      page.evaluate(() => {
        const { azimuth, elevation, centre } = globalThis.bksim.camera;
        return [azimuth, elevation, ...centre];
      });
    const drag = async (dx, dy) => {
      await page.mouse.move(300, 300);
      await page.mouse.down();
      await page.mouse.move(300 + dx, 300 + dy, { steps: 4 });
      await page.mouse.up();
      await settled(page);
    };
    const [azimuth, elevation] = await view();
    const before = await picture(page);
    await drag(80, 30);
    const turned = await view();
    assert.ok(Math.abs(turned[0] - azimuth + 0.8) < 1e-9 && Math.abs(turned[1] - elevation - 0.3) < 1e-9);
    assert.notEqual(await picture(page), before);
    const bytes = await page.locator('.picture').screenshot();
    fs.writeFileSync(path.join(plan.screenshots, 'governor-turned.png'), bytes);
    await page.keyboard.down('Shift');
    await drag(50, 0);
    await page.keyboard.up('Shift');
    const moved = await view();
    assert.deepEqual(moved.slice(0, 2), turned.slice(0, 2));
    assert.notDeepEqual(moved.slice(2), turned.slice(2));
  });
});

test('a spatial mechanism is cut across an axis, by the list and by keys', async () => {
  await opened(first.file, {}, async (page) => assert.ok(await page.locator('#section').isHidden()));
  const spatial = plan.pages.find(({ name }) => name === 'governor');
  await opened(spatial.file, {}, async (page) => {
    // How much is drawn on the left and on the right of the middle of the picture.
    const drawn = () =>
      page.evaluate(() => {
        const { width, height } = document.getElementById('picture');
        const { data } = document.getElementById('picture').getContext('2d').getImageData(0, 0, width, height);
        const halves = [0, 0];
        for (let at = 0; at < data.length; at += 4) {
          const isDrawn = [0, 1, 2].some((i) => Math.abs(data[at + i] - data[i]) > 40);
          // The scale bar stands in the lower left corner.
          if (isDrawn && at / 4 < 0.9 * width * height) halves[(at / 4) % width < 0.5 * width ? 0 : 1] += 1;
        }
        return halves;
      });
    await page.selectOption('#look', 'front');
    await settled(page);
    const [before, whole] = [await picture(page), await drawn()];
    assert.ok(whole[0] > 500 && whole[1] > 500, `${whole} pixels`);
    // Seen from the front a little from the right, the right half is nearer.
    await page.evaluate(() => globalThis.bksim.camera.turn(1e-3, 0));
    await page.selectOption('#cut', '0');
    await settled(page);
    const [left, right] = await drawn();
    assert.ok(left > 0.5 * whole[0] && right < 0.1 * whole[1], `${left} and ${right} pixels of ${whole}`);
    const bytes = await page.locator('.picture').screenshot();
    fs.writeFileSync(path.join(plan.screenshots, 'governor-cut.png'), bytes);
    const cut = await picture(page);
    await page.locator('#picture').focus();
    await page.keyboard.press(']');
    await settled(page);
    assert.notEqual(await picture(page), cut);
    await page.keyboard.press('x');
    await page.selectOption('#look', 'front');
    await settled(page);
    assert.equal(await picture(page), before);
    assert.ok(await page.locator('#cut-at').isHidden());
  });
});

test('what is rounding on the scale of its curve is shown as zero', () => {
  // The slider of the press begins where positions are counted from, but for rounding.
  const { file } = plan.pages.find(({ name }) => name === 'press');
  return opened(file, {}, async (page) => {
    await page.click('#channels summary');
    for (const box of await page.locator('#channels input').all()) await box.check();
    const largest = await page.evaluate(() =>
      Object.fromEntries(globalThis.bksim.curves.map(({ name, largest }) => [name, largest])),
    );
    for (const part of [0, 0.1, 0.37, 0.5, 1]) {
      await page.evaluate((k) => {
        const [from, to] = globalThis.bksim.span;
        globalThis.bksim.seek(from + k * (to - from));
      }, part);
      await settled(page);
      const shown = await page.evaluate(() =>
        [...document.querySelectorAll('figcaption > span')].map((entry) => [
          entry.querySelector('b').textContent,
          entry.querySelector('.value').textContent,
        ]),
      );
      assert.ok(shown.length > 10, `${shown.length} curves`);
      if (part === 0) assert.equal(Object.fromEntries(shown)['state.guide_position'], '0.000');
      for (const [name, text] of shown) {
        const value = Math.abs(Number(text.replaceAll('−', '-')));
        const isSeen = value === 0 || value >= largest[name] * 1e-7;
        assert.ok(isSeen, `${name}: ${text} on a scale of ${largest[name]}`);
      }
    }
  });
});

test('labels of ticks are where their ticks are', () => {
  for (const step of [1, 2, 2.5, 5, 0.25, 0.1, 2.5e-6, 2.5e5, 1e7]) {
    const ticks = [-5, -4, -3, -2, -1, 0, 1, 2, 3].map((k) => k * step);
    for (const [k, text] of tickTexts(ticks).entries()) {
      const shown = Number(text.replaceAll('−', '-'));
      assert.ok(Math.abs(shown - ticks[k]) < 1e-6 * step, `${text} at ${ticks[k]}`);
    }
  }
  assert.deepEqual(tickTexts([-10, -7.5, -5, -2.5, 0]), ['−10.0', '−7.5', '−5.0', '−2.5', '0.0']);
});

test('it plays, pauses, steps and loops', () =>
  opened(first.file, {}, async (page) => {
    const before = await picture(page);
    await page.click('#play');
    // One frame may move less than a pixel.
    await page.waitForFunction(() => globalThis.bksim.time > globalThis.bksim.span[0] + 0.2);
    assert.notEqual(await picture(page), before);
    assert.equal(await page.getAttribute('#play', 'aria-label'), 'Pause');
    await page.click('#play');
    const paused = await page.evaluate(() => globalThis.bksim.time);
    await page.click('#forth');
    assert.ok((await page.evaluate(() => globalThis.bksim.time)) > paused);

    // At the end it starts again, unless it shall not.
    await page.evaluate(() => globalThis.bksim.seek(globalThis.bksim.span[1] - 0.01));
    await page.locator('#picture').focus();
    await page.keyboard.press('Space');
    await page.waitForFunction(() => globalThis.bksim.time < 0.5 * globalThis.bksim.span[1]);
    await page.keyboard.press('l');
    await page.evaluate(() => globalThis.bksim.seek(globalThis.bksim.span[1] - 0.01));
    await page.waitForFunction(() => !globalThis.bksim.isPlaying);
    assert.equal(await page.evaluate(() => globalThis.bksim.time === globalThis.bksim.span[1]), true);
  }));

test('it scrubs with the slider and with the line in the curves', () =>
  opened(first.file, {}, async (page) => {
    const [start, end] = await page.evaluate(() => globalThis.bksim.span);
    const time = () => page.evaluate(() => globalThis.bksim.time);
    const slider = await page.locator('#scrub').boundingBox();
    await page.mouse.click(slider.x + 0.5 * slider.width, slider.y + 0.5 * slider.height);
    assert.ok(Math.abs((await time()) - 0.5 * (start + end)) < 0.02 * (end - start));
    await settled(page);

    const line = await page.locator('.now').first().boundingBox();
    const chart = await page.locator('.u-over').first().boundingBox();
    const y = chart.y + 0.5 * chart.height;
    await page.mouse.move(line.x + 1, y);
    await page.mouse.down();
    await page.mouse.move(chart.x + 0.8 * chart.width, y, { steps: 4 });
    await page.mouse.up();
    assert.ok(Math.abs((await time()) - (start + 0.8 * (end - start))) < 0.01 * (end - start));
    const text = await page.textContent('#time');
    assert.match(text, /^t = [\d.]+ s$/);
  }));

test('the picture zooms, pans and fits; the curves zoom', () =>
  opened(first.file, {}, async (page) => {
    const before = await picture(page);
    const scale = () => page.evaluate(() => globalThis.bksim.camera.scale);
    const fitted = await scale();
    await page.click('#zoom-in');
    await settled(page);
    assert.ok((await scale()) > 1.2 * fitted);
    const zoomed = await picture(page);
    assert.notEqual(zoomed, before);
    await page.mouse.move(300, 300);
    await page.mouse.down();
    await page.mouse.move(360, 320, { steps: 3 });
    await page.mouse.up();
    await settled(page);
    assert.notEqual(await picture(page), zoomed);
    await page.click('#fit');
    await settled(page);
    assert.equal(await picture(page), before);

    const chart = await page.locator('.u-over').first().boundingBox();
    const y = chart.y + 0.5 * chart.height;
    const curves = () =>
      page.evaluate(() => document.querySelector('.u-wrap canvas').toDataURL());
    const whole = await curves();
    await page.mouse.move(chart.x + 0.4 * chart.width, y);
    await page.mouse.down();
    await page.mouse.move(chart.x + 0.6 * chart.width, y, { steps: 4 });
    await page.mouse.up();
    await settled(page);
    assert.notEqual(await curves(), whole);
    await page.mouse.dblclick(chart.x + 0.5 * chart.width, y);
    await settled(page);
    assert.equal(await curves(), whole);
  }));

test('curves and trails are chosen from lists, arrows and names are switched on', () =>
  opened(first.file, {}, async (page) => {
    const n = await page.locator('figure').count();
    await page.click('#channels summary');
    const box = page.locator('#channels input:not(:checked)').last();
    await box.check();
    assert.ok((await page.locator('figure').count()) >= n);
    for (const id of ['labels', 'velocities', 'reactions']) {
      const before = await picture(page);
      await page.check(`#${id}`);
      await settled(page);
      assert.notEqual(await picture(page), before, id);
    }
    const before = await picture(page);
    await page.click('#trails summary');
    await page.locator('#trails input:checked').first().uncheck();
    await settled(page);
    assert.notEqual(await picture(page), before);
  }));

test('everything that is used has a name', () =>
  opened(first.file, {}, async (page) => {
    const nameless = await page.evaluate(() =>
      [...document.querySelectorAll('button, input, select, canvas[tabindex]')]
        .filter((e) => !(e.ariaLabel || e.getAttribute('aria-label') || e.closest('label')?.textContent.trim()))
        .map((e) => e.outerHTML),
    );
    assert.deepEqual(nameless, []);
  }));

test('pictures are those that were looked at, and a different one is not', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await opened(first.file, { colorScheme, viewport: { width: 800, height: 900 } }, async (page) => {
      const shot = () => page.locator('.picture').screenshot();
      await page.evaluate(([from, to]) => globalThis.bksim.seek(from + 0.3 * (to - from)), first.span);
      await settled(page);
      compare(`${first.name}-${colorScheme}`, await shot());
      const right = PNG.sync.read(await shot());
      await page.evaluate(([from, to]) => globalThis.bksim.seek(from + 0.7 * (to - from)), first.span);
      await page.click('#zoom-in');
      await page.click('#zoom-in');
      await settled(page);
      const other = difference(right, PNG.sync.read(await shot()));
      assert.ok(other > ALLOWED, `another instant differs in ${(100 * other).toFixed(1)} % only`);
    });
  }
});

test('the switch changes the theme', () =>
  opened(first.file, { colorScheme: 'light' }, async (page) => {
    const background = () =>
      page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);
    assert.equal(await background(), 'rgb(255, 255, 255)');
    await page.click('#theme');
    assert.notEqual(await background(), 'rgb(255, 255, 255)');
  }));

test('what a hostile model says stays text', () =>
  opened(plan.hostile.file, {}, async (page) => {
    const shown = await page.textContent('#model pre');
    for (const text of plan.hostile.texts) assert.ok(shown.includes(text), text);
    assert.equal(await page.title(), plan.hostile.title);
    const nScripts = await page.evaluate(() => document.scripts.length);
    assert.equal(nScripts, 2);
    assert.equal(await page.evaluate(() => globalThis.isBroken), undefined);
  }));

test('the policy stops other scripts and the network', async () => {
  // A server of our own counts who asks.
  let nAsked = 0;
  const server = http.createServer((_, response) => {
    nAsked += 1;
    response.end();
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address();
  const addition =
    '<script>globalThis.isBroken = true</script>' + `<img src="http://127.0.0.1:${port}/x.png"></body>`;
  const html = fs.readFileSync(first.file, 'utf8').replace('</body>', addition);
  const file = path.join(plan.screenshots, 'changed.html');

  const broken = async (text) => {
    fs.writeFileSync(file, text);
    const page = await browser.newPage();
    await page.goto(pathToFileURL(file).href);
    await page.waitForFunction(() => globalThis.bksim !== undefined);
    const isBroken = await page.evaluate(() => globalThis.isBroken === true);
    await page.close();
    return isBroken;
  };
  assert.equal(await broken(html), false);
  assert.equal(nAsked, 0);
  // Without the policy both would have come through.
  assert.equal(await broken(html.replace(/<meta http-equiv[^>]*>/, '')), true);
  assert.equal(nAsked, 1);
  fs.unlinkSync(file);
  server.close();
});
