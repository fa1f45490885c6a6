// Buttons, lists, keys and pointers.

import { VIEWS } from './camera.js';
import { lengthText } from './scene.js';

const ICONS = {
  play: 'M8 5v14l11-7z',
  pause: 'M7 5h4v14H7zM13 5h4v14h-4z',
  back: 'M18 6v12l-9-6zM6 6h2.4v12H6z',
  forth: 'M6 6v12l9-6zM15.6 6H18v12h-2.4z',
  loop: 'M12 5V1L7 6l5 5V7a5 5 0 0 1 5 5 5 5 0 0 1-.7 2.5l1.5 1.5A7 7 0 0 0 12 5zm0 12a5 5 0 0 1-5-5c0-.9.3-1.8.7-2.5L6.200 8A7 7 0 0 0 12 19v4l5-5-5-5z',
  fit: 'M4 4h6v2H6v4H4zM14 4h6v6h-2V6h-4zM4 14h2v4h4v2H4zM18 14h2v6h-6v-2h4z',
  theme: 'M12 3a9 9 0 1 0 0 18zM12 3v2a7 7 0 0 1 0 14v2a9 9 0 0 0 0-18z',
};

const SPEEDS = [1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8, 16];

export const element = (id) => document.getElementById(id);

function setIcon(button, name) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  path.setAttribute('d', ICONS[name]);
  svg.append(path);
  button.replaceChildren(svg);
}

/** Play, pause, step, loop, speed and scrub; returns a function that updates the time shown. */
export function transport(clock) {
  const play = element('play');
  setIcon(element('back'), 'back');
  setIcon(element('forth'), 'forth');
  setIcon(element('loop'), 'loop');
  play.addEventListener('click', () => clock.toggle());
  element('back').addEventListener('click', () => clock.step(-1));
  element('forth').addEventListener('click', () => clock.step(1));
  element('loop').addEventListener('click', () => {
    clock.isLooping = !clock.isLooping;
    element('loop').setAttribute('aria-pressed', clock.isLooping);
  });
  const speed = element('speed');
  const speeds = SPEEDS.includes(clock.speed) ? SPEEDS : [...SPEEDS, clock.speed].sort((a, b) => a - b);
  for (const value of speeds) {
    const text = value < 1 ? `1/${Math.round(1 / value)}` : `${value}`;
    speed.add(new Option(`${text}×`, value, value === clock.speed, value === clock.speed));
  }
  speed.addEventListener('change', () => {
    clock.speed = Number(speed.value);
  });
  const scrub = element('scrub');
  scrub.addEventListener('input', () => {
    // A pause shows the time, and moves the slider to it.
    const part = Number(scrub.value);
    clock.pause();
    clock.seek(clock.start + part * (clock.end - clock.start));
  });
  let wasPlaying = null;
  return () => {
    const length = Math.abs(clock.end - clock.start);
    const digits = Math.min(9, Math.max(0, 3 - Math.floor(Math.log10(length || 1))));
    const time = `${clock.t.toFixed(digits)} s`.replace('-', '−');
    element('time').textContent = `t = ${time}`;
    scrub.value = clock.part;
    scrub.setAttribute('aria-valuetext', time);
    if (wasPlaying === clock.isPlaying) return;
    wasPlaying = clock.isPlaying;
    setIcon(play, wasPlaying ? 'pause' : 'play');
    play.setAttribute('aria-label', wasPlaying ? 'Pause' : 'Play');
  };
}

/** The switch between light and dark; follows the system until it is used. */
export function themes(onChange) {
  const button = element('theme');
  setIcon(button, 'theme');
  const system = matchMedia('(prefers-color-scheme: dark)');
  let isChosen = false;
  const set = (isDark) => {
    document.documentElement.dataset.theme = isDark ? 'dark' : 'light';
    button.setAttribute('aria-pressed', isDark);
    onChange(isDark ? 'dark' : 'light');
  };
  system.addEventListener('change', ({ matches }) => isChosen || set(matches));
  button.addEventListener('click', () => {
    isChosen = true;
    set(document.documentElement.dataset.theme !== 'dark');
  });
  set(system.matches);
}

/** A list of checkboxes under headings. */
export function checklist(container, groups, onChange) {
  for (const [heading, items] of groups) {
    const box = document.createElement('fieldset');
    const legend = document.createElement('legend');
    legend.textContent = heading;
    box.append(legend);
    for (const { text, title, isChecked, value } of items) {
      const label = document.createElement('label');
      const input = document.createElement('input');
      input.type = 'checkbox';
      input.checked = isChecked;
      input.addEventListener('change', () => onChange(value, input.checked));
      label.append(input, ` ${text}`);
      label.title = title ?? '';
      box.append(label);
    }
    container.append(box);
  }
}

/** Panning, zooming and turning of the picture, by pointer, wheel and keys; `turned` is told of the latter. */
export function view(canvas, camera, fit, redraw, turned) {
  setIcon(element('fit'), 'fit');
  const zoom = (factor, at) => {
    camera.zoom(factor, at);
    redraw(true);
  };
  element('zoom-in').addEventListener('click', () => zoom(1.25));
  element('zoom-out').addEventListener('click', () => zoom(0.8));
  element('fit').addEventListener('click', fit);
  canvas.addEventListener('dblclick', fit);
  const look = element('look');
  look.hidden = camera.isPlanar;
  look.add(new Option('view', '', true, true));
  for (const name of Object.keys(VIEWS)) look.add(new Option(name, name));
  look.addEventListener('change', () => {
    if (look.value) camera.look(look.value);
    fit();
    // Turned by hand, the view is none of them; and each can be chosen again.
    look.value = '';
  });
  const pixelOf = (event) => {
    const { left, top } = canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  // The wheel belongs to the page until the picture is clicked, or with Ctrl.
  canvas.addEventListener(
    'wheel',
    (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      zoom(Math.exp(-0.0015 * event.deltaY * (event.deltaMode === 1 ? 20 : 1)), pixelOf(event));
    },
    { passive: false },
  );

  const pointers = new Map();
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, pixelOf(event));
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = pixelOf(event);
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      // Two fingers: the part of the picture between them stays between them.
      const distance = (p) => Math.max(1, Math.hypot(p[0] - other[0], p[1] - other[1]));
      camera.pan(0.5 * dx, 0.5 * dy);
      camera.zoom(distance(now) / distance(before), [0.5 * (now[0] + other[0]), 0.5 * (now[1] + other[1])]);
    } else if (camera.isPlanar || event.shiftKey || event.buttons === 4) {
      camera.pan(dx, dy);
    } else {
      camera.turn(-0.01 * dx, 0.01 * dy);
      pointers.set(event.pointerId, now);
      turned();
      return;
    }
    pointers.set(event.pointerId, now);
    redraw(true);
  });
  for (const end of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }

  const arrows = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  canvas.addEventListener('keydown', (event) => {
    const arrow = arrows[event.key];
    if (!arrow) return;
    event.preventDefault();
    if (camera.isPlanar || event.shiftKey) {
      camera.pan(40 * arrow[0], 40 * arrow[1]);
      redraw(true);
    } else {
      camera.turn(0.1 * arrow[0], 0.1 * arrow[1]);
      turned();
    }
  });
  return { zoom };
}

/** The section plane: across an axis, at a place between the ends of the mechanism; returns the actions of its keys. */
export function sections(isPlanar, extent, onChange) {
  const [axis, at, text] = ['cut', 'cut-at', 'cut-text'].map(element);
  if (isPlanar) return { across: () => {}, move: () => {} };
  element('section').hidden = false;
  const reach = [0, 1, 2].map((i) =>
    extent.reduce(
      ([low, high], p) => (Number.isFinite(p[i]) ? [Math.min(low, p[i]), Math.max(high, p[i])] : [low, high]),
      [Infinity, -Infinity],
    ),
  );
  const update = () => {
    at.hidden = axis.value === '';
    text.textContent = '';
    if (at.hidden) {
      onChange(null);
      return;
    }
    const [low, high] = reach[Number(axis.value)];
    const offset = low + Number(at.value) * (high - low);
    const size = offset < 0 ? `−${lengthText(-offset)}` : lengthText(offset);
    text.textContent = size;
    at.setAttribute('aria-valuetext', size);
    onChange({ axis: Number(axis.value), offset });
  };
  axis.addEventListener('change', update);
  at.addEventListener('input', update);
  return {
    across: (number) => {
      axis.value = axis.value === `${number}` ? '' : `${number}`;
      update();
    },
    move: (steps) => {
      if (at.hidden) return;
      at.value = Number(at.value) + steps / 50;
      update();
    },
  };
}

/** Keys that work everywhere except in elements that take keys themselves. */
export function keys(clock, zoom, fit, cut) {
  const actions = {
    ' ': () => clock.toggle(),
    ',': () => clock.step(-1),
    '.': () => clock.step(1),
    Home: () => clock.seek(clock.start),
    End: () => clock.seek(clock.end),
    l: () => element('loop').click(),
    '+': () => zoom(1.25),
    '=': () => zoom(1.25),
    '-': () => zoom(0.8),
    0: fit,
    x: () => cut.across(0),
    y: () => cut.across(1),
    z: () => cut.across(2),
    '[': () => cut.move(-1),
    ']': () => cut.move(1),
  };
  document.addEventListener('keydown', (event) => {
    const isTaken = event.target.closest('input, select, button, summary, pre');
    if (isTaken || event.ctrlKey || event.metaKey || event.altKey) return;
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
