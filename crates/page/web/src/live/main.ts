// A live page: a model that is seen, dragged, drawn, solved and written, all of it in this page.

import './live.css';
import { Clock } from '../clock.js';
import { element, themes, transport } from '../controls.js';
import { Charts } from './charts';
import { Thread, compiled } from './engine';
import { Elements, Text, Values, showEquations, showFaults, showFreedoms, showWays } from './panels';
import { Keeper } from './keeper';
import { fragmentOf, textOf } from './share';
import { Stage } from './stage';
import { tools } from './tools';
import type { Answer, Dragged, Edit, Equations, Freedoms, Moved, Scene, State, Theme, Ways, World } from './types';

interface Embedded {
  name: string;
  text: string;
  colors: Record<'light' | 'dark', Theme['colors']>;
  /** Whether the page is served, and the file is written by it. */
  served: boolean;
}

const data = JSON.parse(element('live').textContent ?? '') as Embedded;
const stage = new Stage(element('picture') as HTMLCanvasElement, () => {});
const blank: Scene = {
  planar: true, bodies: ['ground'], shapes: [], spans: [], markers: [], pin: 0.01,
  themes: Object.fromEntries(Object.entries(data.colors).map(([name, colors]) => [name, { colors, paints: [], sections: [] }])),
};
const ORIGIN = new Float64Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0]);

let engine: Thread;
let solver: Thread;
let state: State | null = null;
let motion: { times: Float64Array; frames: Float64Array; nNumbers: number; scene: Scene; isFresh: boolean } | null = null;
let clock: Clock | null = null;
let showTime: (() => void) | null = null;
let isMoving = false;
/** Counts texts, so that answers to older ones are dropped. */
let version = 0;
const figures = { solve: 0, edit: 0, drag: 0, draw: 0 };

const charts = new Charts(element('charts'), element('chosen'), (t) => seek(t));
const values = new Values(element('values'), (path, value, moving) => edit({ edit: 'set', path, value }, moving), settle);
const elements = new Elements(element('elements'), (path, value) => edit({ edit: 'set', path, value }, false), (made) => edit(made, false));
const text = new Text(element('text') as HTMLTextAreaElement, element('lines'), (value) => edit({ edit: 'text', text: value }, false));
const keeper = new Keeper(data.served, data.name, () => state?.text ?? '', (newer) => edit({ edit: 'text', text: newer }, false), say);

function say(words: string): void {
  element('status').textContent = words;
}

// ——— Edits ———

let waitingEdit: { request: object; isMoving: boolean } | null = null;
let isEditing = false;

/** Asks for an edit; while a hand moves, only the newest one waits. */
function edit(made: Edit, moving: boolean): void {
  change({ do: 'edit', edit: made, moving }, moving);
}

function change(request: object, moving = false): void {
  if (isEditing) {
    // Of the ways of a hand the newest is enough; all else is made.
    if (waitingEdit && !(waitingEdit.isMoving && moving)) queue.push(waitingEdit.request);
    waitingEdit = { request, isMoving: moving };
    return;
  }
  void changed(request);
}

const queue: object[] = [];

async function changed(request: object): Promise<void> {
  isEditing = true;
  const began = performance.now();
  try {
    const { json, numbers } = await engine.ask<State>(request);
    figures.edit = performance.now() - began;
    if (json.fault) say(`${json.fault.code}: ${json.fault.message}${json.fault.help ? `; ${json.fault.help}` : ''}`);
    else take(json, numbers);
  } finally {
    isEditing = false;
    const next = queue.shift() ?? waitingEdit?.request;
    if (next === waitingEdit?.request) waitingEdit = null;
    if (next) void changed(next);
  }
}

function settle(): void {
  change({ do: 'settle' });
}

/** Shows a state; the last good picture stays under a fault. */
function take(next: State, numbers: Float64Array): void {
  if (!('text' in next)) return;
  const isNew = next.text !== state?.text;
  state = { ...next, scene: next.scene ?? state?.scene, points: next.points ?? state?.points, joints: next.joints ?? state?.joints };
  if (next.scene) {
    if (isMoving && motion) Object.assign(stage, { points: next.points, joints: next.joints });
    else stage.take(next, numbers);
    say('');
  }
  const isEmpty = next.text.trim() === '';
  if (isEmpty) clear();
  element('picture').classList.toggle('stale', !next.is_current && !isEmpty);
  (element('undo') as HTMLButtonElement).disabled = !next.can_undo;
  (element('redo') as HTMLButtonElement).disabled = !next.can_redo;
  values.show(next.controls ?? []);
  elements.show(next.elements ?? []);
  text.show(next);
  showFaults(element('faults'), next.faults, goTo);
  if (!isNew) return;
  version += 1;
  keeper.changed();
  if (motion) motion.isFresh = false;
  if (solver.restart()) isSolving = false;
  void solve();
}

/** The empty plane of an empty text. */
function clear(): void {
  stopMoving();
  Object.assign(stage, { points: [], joints: [] });
  if (state) state = { ...state, scene: blank, points: [], joints: [] };
  stage.setScene(blank);
  stage.pose(ORIGIN);
}

function goTo(from: number, to: number): void {
  openTab('text');
  text.goTo(from, to);
}

// ——— Motion ———

let isSolving = false;

/** Solves the newest text, one after the other. */
async function solve(): Promise<void> {
  if (isSolving || !state) return;
  isSolving = true;
  const own = version;
  const began = performance.now();
  const now = state.text;
  await solver.ask({ do: 'open', text: now, name: data.name });
  if (own !== version) {
    isSolving = false;
    void solve();
    return;
  }
  const { json, numbers } = await solver.ask<Moved>({ do: 'solve' });
  isSolving = false;
  figures.solve = performance.now() - began;
  if (own !== version) {
    void solve();
    return;
  }
  takeMotion(json, numbers);
  const freedoms = await solver.ask<Freedoms>({ do: 'freedoms' });
  if (own !== version) return;
  showFreedoms(element('freedoms'), freedoms.json);
  refreshTab();
}

function takeMotion(moved: Moved, numbers: Float64Array): void {
  const n = moved.n_frames ?? 0;
  const known = state?.faults ?? [];
  const more = moved.faults.filter(({ code, message }) => !known.some((fault) => fault.code === code && fault.message === message));
  showFaults(element('faults'), [...known, ...more], goTo);
  element('transport').classList.toggle('off', n < 2);
  if (n < 2 || !moved.scene) {
    motion = null;
    isMoving = false;
    clock?.pause();
    return;
  }
  const nCurves = moved.curves?.length ?? 0;
  const times = numbers.subarray(0, n);
  const frames = numbers.subarray(n * (1 + nCurves));
  motion = { times, frames, nNumbers: frames.length / n, scene: moved.scene, isFresh: true };
  const curves = (moved.curves ?? []).map((curve, k) => ({ ...curve, values: numbers.subarray(n * (1 + k), n * (2 + k)) }));
  charts.take(times, curves);
  const [first, last] = [times[0], times[n - 1]];
  if (!clock) {
    clock = new Clock(first, last, tick);
    clock.pause();
    showTime = transport(clock);
  } else {
    clock.start = first;
    clock.end = last;
    if (clock.t > last || clock.t < first) clock.seek(first);
  }
  if (isMoving) {
    stage.setScene(moved.scene);
    frame(clock.t);
  }
  showTime?.();
}

/** Shows the motion where the clock is. */
function tick(): void {
  if (!clock || !motion) return;
  if (clock.isPlaying && !isMoving) startMoving();
  if (isMoving) frame(clock.t);
  charts.seek(clock.t);
  showTime?.();
}

function startMoving(): void {
  if (!motion) return;
  isMoving = true;
  stage.setScene(motion.scene);
}

function stopMoving(): void {
  if (!isMoving) return;
  isMoving = false;
  clock?.pause();
  if (state?.scene) stage.setScene(state.scene);
}

function seek(t: number): void {
  clock?.pause();
  startMoving();
  clock?.seek(t);
}

/** The frame at a time, between those next to it. */
function frame(t: number): void {
  if (!motion) return;
  const { times, frames, nNumbers } = motion;
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  const width = times[high] - times[low];
  const part = width > 0 ? Math.min(1, Math.max(0, (t - times[low]) / width)) : 0;
  const [a, b] = [low, high].map((k) => frames.subarray(k * nNumbers, (k + 1) * nNumbers));
  if (part === 0) stage.pose(a.slice());
  else if (part === 1) stage.pose(b.slice());
  else stage.pose(a.map((x, i) => x + part * (b[i] - x)));
}

// ——— Poses ———

let target: World | null = null;
let isDragging = false;

async function drag(): Promise<void> {
  if (isDragging) return;
  isDragging = true;
  while (target) {
    const [x, y] = target;
    target = null;
    const began = performance.now();
    const { json, numbers } = await engine.ask<Dragged>({ do: 'drag', to: [x, y, 0] });
    figures.drag = performance.now() - began;
    if (numbers.length > 0) stage.pose(numbers);
    say(json.limit ?? '');
  }
  isDragging = false;
}

const all = tools({
  stage,
  grab: ({ body, local }) => {
    stopMoving();
    void engine.ask({ do: 'grab', body, point: local });
  },
  drag: (world) => { target = world; void drag(); },
  release: () => { void engine.ask({ do: 'release' }); },
  edit: (made, moving) => { stopMoving(); edit(made, moving); },
  settle,
  say,
});

function choose(name: string): void {
  stage.tool?.cancel();
  stage.tool = all.find((tool) => tool.name === name) ?? all[0];
  for (const button of document.querySelectorAll<HTMLElement>('[data-tool]')) {
    button.setAttribute('aria-pressed', String(button.dataset.tool === stage.tool.name));
  }
  stage.canvas.dataset.tool = stage.tool.name;
  say(stage.tool.hint);
  if (name !== 'hand') stopMoving();
  stage.redraw();
}

// ——— Panels ———

let tab = 'values';

function openTab(name: string): void {
  tab = name;
  for (const button of document.querySelectorAll<HTMLElement>('[role=tab]')) {
    button.setAttribute('aria-selected', String(button.dataset.tab === name));
    button.tabIndex = button.dataset.tab === name ? 0 : -1;
  }
  for (const panel of document.querySelectorAll<HTMLElement>('[role=tabpanel]')) {
    panel.hidden = panel.dataset.tab !== name;
  }
  refreshTab();
}

/** Fills the panels whose answers are asked for only while they are seen. */
function refreshTab(): void {
  const own = version;
  if (tab === 'curves') charts.show();
  if (tab === 'equations') {
    void solver.ask<Equations>({ do: 'equations' }).then(({ json }) => {
      if (own === version) showEquations(element('equations'), json);
    });
  }
  if (tab === 'ways') {
    void solver.ask<Ways>({ do: 'assemblies' }).then(({ json, numbers }: Answer<Ways>) => {
      if (own !== version) return;
      const n = numbers.length / Math.max(1, json.assemblies?.length ?? 1);
      showWays(element('ways'), json, (number) => edit({ edit: 'set', path: 'initial.assembly', value: String(number) }, false), (place) => {
        stage.ghost = place === null ? null : numbers.slice(place * n, (place + 1) * n);
        stage.redraw();
      });
    });
  }
}

function wire(): void {
  const on = (id: string, deed: () => void) => element(id).addEventListener('click', deed);
  on('undo', () => change({ do: 'undo' }));
  on('redo', () => change({ do: 'redo' }));
  on('fit', () => stage.fit());
  on('zoom-in', () => stage.zoom(1.25));
  on('zoom-out', () => stage.zoom(0.8));
  on('gravity', () => edit({ edit: 'gravity' }, false));
  on('start-here', () => change({ do: 'start_here' }));
  on('to-start', () => {
    stopMoving();
    void engine.ask({ do: 'pose', pose: 'start' }).then(({ numbers }) => stage.pose(numbers));
  });
  on('save', () => void keeper.save());
  on('share', async () => {
    history.replaceState(null, '', `#${await fragmentOf(state?.text ?? '')}`);
    try {
      await navigator.clipboard.writeText(location.href);
      say('The link to this model is in the clipboard.');
    } catch {
      say('The address of this page now holds the model.');
    }
  });
  for (const button of document.querySelectorAll<HTMLElement>('[data-tool]')) {
    button.addEventListener('click', () => choose(button.dataset.tool ?? 'hand'));
  }
  for (const button of document.querySelectorAll<HTMLElement>('[role=tab]')) {
    button.addEventListener('click', () => openTab(button.dataset.tab ?? 'values'));
  }
  element('labels').addEventListener('change', ({ target: box }) => {
    stage.hasNames = (box as HTMLInputElement).checked;
    stage.redraw();
  });
  document.addEventListener('keydown', (event) => {
    const isTyping = (event.target as HTMLElement).closest('input[type=text], textarea, select');
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 's') {
      event.preventDefault();
      void keeper.save();
    }
    if (isTyping) return;
    const isUndo = (event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'z';
    const isRedo = (event.ctrlKey || event.metaKey) && (event.key.toLowerCase() === 'y' || (isUndo && event.shiftKey));
    if (isRedo) change({ do: 'redo' });
    else if (isUndo) change({ do: 'undo' });
    else if (event.key === ' ' && !(event.target as HTMLElement).closest('button')) clock?.toggle();
    else return;
    event.preventDefault();
  });
}

async function begin(): Promise<void> {
  wire();
  stage.setScene(blank);
  stage.numbers = ORIGIN;
  themes((name: 'light' | 'dark') => {
    stage.theme = name;
    charts.paint(data.colors[name]);
    stage.redraw();
  });
  stage.resize();
  charts.paint(data.colors[stage.theme]);
  const script = element('worker').textContent ?? '';
  const code = await compiled(element('module').textContent ?? '');
  engine = new Thread(script, code);
  solver = new Thread(script, code);
  const shared = await textOf(location.hash);
  const { json, numbers } = await engine.ask<State>({ do: 'open', text: shared ?? data.text, name: data.name });
  // The first picture is fitted to what is there.
  if (json.scene) stage.scene = null;
  choose(json.points?.length ? 'hand' : 'link');
  take(json, numbers);
  stage.fit();
  keeper.begin(json.text);
  openTab('values');
  document.documentElement.dataset.ready = 'yes';
}

// For the browser's console and for tests.
Object.assign(globalThis, {
  bksim: {
    get state() { return state; },
    get motion() { return motion; },
    get numbers() { return Array.from(stage.numbers); },
    get time() { return clock?.t ?? 0; },
    get isPlaying() { return clock?.isPlaying ?? false; },
    get isIdle() { return !isEditing && !isDragging && !isSolving && !(engine?.isBusy ?? true) && !(solver?.isBusy ?? true); },
    camera: stage.camera,
    figures,
    ask: (request: object) => engine.ask(request),
  },
});

begin().catch((error: unknown) => say(`This page cannot begin: ${String(error)}`));
