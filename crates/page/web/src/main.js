// The page of a run: makes the embedded data move.

import './page.css';
import { Camera } from './camera.js';
import { Clock } from './clock.js';
import { checklist, element, keys, sections, themes, transport, view } from './controls.js';
import { Curves } from './curves.js';
import { Extras } from './extras.js';
import { Motion } from './motion.js';
import { Poses } from './poses.js';
import { Drawing, outline } from './scene.js';

/** Number of instants whose poses all fit into the picture. */
const N_FITTED = 60;
/** Margin around a fitted motion, pixels. */
const MARGIN = 34;

const data = JSON.parse(element('run').textContent);
const run = playable(data);
const { scene, motion } = run;
const canvas = element('picture');
const camera = new Camera(scene.planar);
const drawing = new Drawing(canvas, scene, camera);

const extent = [];
for (let k = 0; k <= N_FITTED; k += 1) {
  const t = motion.start + ((motion.end - motion.start) * k) / N_FITTED;
  extent.push(...outline(scene, run.at(t)));
}
const extras = new Extras(run, sizeOf(extent), data.load);
const clock = new Clock(motion.start, motion.end, redraw);
const curves = new Curves(data.curves, document.querySelector('#curves .charts'), (t) => {
  clock.pause();
  clock.seek(t);
});
const showTime = transport(clock);
let theme = scene.themes.light;
// Until the picture is moved by hand, it is fitted to every new size.
let isFitted = true;
let isWaiting = false;

/** The run as functions of time: numbers of the bodies, and the forces of joints at the same instant. */
function playable({ motion: embedded, poses: tape, scene: shapes }) {
  const polynomials = new Motion(embedded);
  const poses = new Poses(tape);
  const state = new Float64Array(polynomials.nColumns);
  const { nAxes } = polynomials;
  return {
    motion: polynomials,
    scene: shapes,
    at: (t) => poses.at(polynomials.at(t, state)),
    forceAt: (joint) => {
      const first = tape.inputs + nAxes * joint;
      const [x, y, z = 0] = state.subarray(first, first + nAxes);
      return [x, y, z];
    },
  };
}

/** Largest extent of points along an axis. */
function sizeOf(points) {
  const extents = [0, 1, 2].map((i) => {
    const [low, high] = points.reduce(
      ([a, b], p) => (Number.isFinite(p[i]) ? [Math.min(a, p[i]), Math.max(b, p[i])] : [a, b]),
      [Infinity, -Infinity],
    );
    return high > low ? high - low : 0;
  });
  return Math.max(...extents);
}

/** Draws once, in the next frame; `isMoved` means that the picture was moved by hand. */
function redraw(isMoved) {
  if (isMoved === true) isFitted = false;
  if (isWaiting) return;
  isWaiting = true;
  requestAnimationFrame(() => {
    isWaiting = false;
    extras.prepare();
    const numbers = run.at(clock.t);
    drawing.turnTo(clock.t);
    drawing.draw(numbers, theme, extras.at(clock.t, numbers, theme));
    curves.seek(clock.t);
    showTime();
  });
}

function fit() {
  isFitted = true;
  camera.fit(extent, MARGIN);
  redraw();
}

/** The list of trails, of all points but those of the ground; that of the widest path is on at first. */
function trails() {
  const moving = scene.markers.filter(({ at }) => at.body !== 0);
  const first = extras.widest();
  if (first) extras.trailed.add(first);
  const titles = { joint: 'Joints', point: 'Points', mass: 'Centres of mass' };
  const groups = Object.entries(titles).map(([kind, title]) => {
    const items = moving.filter((marker) => marker.kind === kind);
    const item = (marker) => ({ text: marker.name, isChecked: marker === first, value: marker });
    return [title, items.map(item)];
  });
  const filled = groups.filter(([, items]) => items.length > 0);
  checklist(document.querySelector('#trails .list'), filled, (marker, isChecked) => {
    if (isChecked) extras.trailed.add(marker);
    else extras.trailed.delete(marker);
    redraw();
  });
}

/** The list of curves, grouped by the topics in their names. */
function channels() {
  const topics = new Map();
  for (const channel of curves.channels) {
    const [topic, name] = channel.name.split(/\.(?=[^.]*$)/);
    const text = channel.unit ? `${name}, ${channel.unit}` : name;
    const isChecked = curves.chosen.includes(channel);
    const item = { text, title: channel.description, isChecked, value: channel };
    topics.set(topic, [...(topics.get(topic) ?? []), item]);
  }
  checklist(document.querySelector('#channels .list'), topics, (channel, isChecked) => {
    curves.chosen = curves.channels.filter((other) =>
      other === channel ? isChecked : curves.chosen.includes(other),
    );
    curves.show(theme);
  });
}

/** The switches of names and arrows. */
function switches() {
  const of = { labels: 'hasNames', velocities: 'hasVelocities', reactions: 'hasReactions' };
  for (const [id, key] of Object.entries(of)) {
    element(id).addEventListener('change', ({ target }) => {
      extras[key] = target.checked;
      redraw();
    });
  }
}

trails();
channels();
switches();
// A picture that was not moved by hand shows all of the mechanism from every side.
const { zoom } = view(canvas, camera, fit, redraw, () => {
  if (isFitted) camera.fit(extent, MARGIN);
  redraw();
});
const cut = sections(camera.isPlanar, extent, (section) => {
  drawing.section = section;
  redraw();
});
keys(clock, zoom, fit, cut);
themes((name) => {
  theme = scene.themes[name];
  curves.show(theme);
  redraw();
});
new ResizeObserver(() => {
  drawing.resize();
  if (isFitted) camera.fit(extent, MARGIN);
  redraw();
}).observe(canvas);
new ResizeObserver(() => curves.resize()).observe(curves.container);

// For the browser's console: the time, and the poses of the bodies.
globalThis.bksim = {
  get time() {
    return clock.t;
  },
  get isPlaying() {
    return clock.isPlaying;
  },
  span: [motion.start, motion.end],
  camera,
  seek: (t) => clock.seek(t),
  poses: (t) => Array.from(run.at(t)),
  curves: curves.channels.map(({ name, unit, largest }) => ({ name, unit, largest })),
};
