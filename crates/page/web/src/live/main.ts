// A live page: a model that is seen, dragged, drawn, solved and written, all of it in this page.

import './live.css';
import { element, themes } from '../controls.js';
import { css } from '../colors.js';
import { Charts } from './charts';
import { Dimensions } from './dimensions';
import { Frame, embed } from './embed';
import { Thread, unpacked } from './engine';
import { blankScene, type Embedded } from './embedded';
import { Formulas } from './formulas';
import { Elements, Text, Values, showFaults, showFreedoms, showLimits, showTransmissions, showWays } from './panels';
import { Keeper } from './keeper';
import { keep } from './files';
import { Player } from './player';
import { Running, type Recorded } from './running';
import { fragmentOf, partOf, textOf } from './share';
import { Stage } from './stage';
import { Study } from './study';
import { tools } from './tools';
import { Underlay, metresOf } from './underlay';
import { faultWords, takeCodes, translate, word } from './words';
import type { Answer, Dragged, Edit, Equations, Freedoms, Limits, Moved, State, Ways, World } from './types';

const data = JSON.parse(element('live').textContent ?? '') as Embedded;
const stage = new Stage(element('picture') as HTMLCanvasElement, () => {});
const blank = blankScene(data);
const ORIGIN = new Float64Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0]);

let engine: Thread;
let solver: Thread;
let state: State | null = null;
/** Counts texts, so that answers to older ones are dropped. */
let version = 0;
const figures = { solve: 0, edit: 0, drag: 0, draw: 0 };

const study: Study = new Study(element('study'), stage, () => player.show());
const player: Player = new Player(stage, () => charts, () => state?.scene, rested, (motion) => study.take(motion));
const formulas = new Formulas(element('equations'), (bodies) => { stage.lit = bodies; stage.redraw(); }, valuesNow);
const charts: Charts = new Charts(element('charts'), element('chosen'), (t) => player.seek(t));
const dimensions = new Dimensions(stage, element('dimensions'), (made) => { player.stop(); edit(made, false); });
const values = new Values(element('values'), (path, value, moving) => edit({ edit: 'set', path, value }, moving), settle);
const elements = new Elements(element('elements'), (path, value) => edit({ edit: 'set', path, value }, false), (made) => edit(made, false));
const text = new Text(element('text') as HTMLTextAreaElement, element('lines'), (value) => edit({ edit: 'text', text: value }, false));
const underlay = new Underlay(data.under);
const keeper = new Keeper(data.served, data.name, () => state?.text ?? '', (newer) => edit({ edit: 'text', text: newer }, false), say);

let selected = '';
const owner = new Frame(
  () => ({ text: state?.text ?? '', time: player.clock?.t ?? 0, selected }),
  (text) => edit({ edit: 'text', text }, false),
);
const running = new Running(() => engine, () => player.clock?.speed ?? 1, showRunning, say, endRunning);

/** Brings what shows numbers of one instant up to date. */
function rested(): void {
  owner.tell();
  study.list();
  if (tab === 'equations' && formulas.isShown) void formulas.refresh();
}

/** Coordinates and rates by name: those of the motion at its instant, or those of the pose, which is at rest. */
async function valuesNow(): Promise<Map<string, number>> {
  if (stage.t !== null) return charts.at(stage.t);
  const { json } = await engine.ask<{ names?: string[]; values?: number[] }>({ do: 'coordinates' });
  return new Map(json.names?.flatMap((name, k): [string, number][] => [[name, json.values?.[k] ?? 0], [`${name}_dot`, 0]]));
}

function say(words: string): void {
  element('status').textContent = word(words);
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
    if (json.fault) say(faultWords(json.fault));
    else take(json, numbers, 'moving' in request && request.moving === true);
    if ('do' in request && request.do === 'settle') stage.bringIn();
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
function take(next: State, numbers: Float64Array, isMoving = false): void {
  if (!('text' in next)) return;
  const isNew = next.text !== state?.text;
  state = { ...next, scene: next.scene ?? state?.scene, points: next.points ?? state?.points, joints: next.joints ?? state?.joints, forces: next.forces ?? state?.forces };
  if (next.scene) {
    const { bodies } = next.scene;
    const known = stage.scene?.bodies ?? [];
    stage.selected = isCopying ? bodies.filter((name) => !known.includes(name)) : stage.selected.filter((name) => bodies.includes(name));
    isCopying = false;
    if (running.isOn) stage.setScene(next.scene);
    if (running.isOn || (player.isMoving && player.motion)) Object.assign(stage, { points: next.points, joints: next.joints, forces: next.forces ?? [] });
    else stage.take(next, numbers);
    if (!isMoving) stage.bringIn();
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
  owner.tell();
  version += 1;
  keeper.changed();
  if (player.motion) player.motion.isFresh = false;
  if (solver.restart()) isSolving = false;
  void solve();
}

/** The empty plane of an empty text. */
function clear(): void {
  player.stop();
  player.take({ faults: [] }, new Float64Array(0));
  showFreedoms(element('freedoms'), {});
  Object.assign(stage, { points: [], joints: [], forces: [] });
  if (state) state = { ...state, scene: blank, points: [], joints: [], forces: [] };
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
  if (isSolving || !state || state.text.trim() === '') return;
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
  const known = state?.faults ?? [];
  const more = moved.faults.filter(({ code, message }) => !known.some((fault) => fault.code === code && fault.message === message));
  showFaults(element('faults'), [...known, ...more], goTo);
  const isFirst = !player.motion;
  player.take(moved, numbers);
  if (isFirst && !player.isMoving) stage.refit();
}

// ——— Motion under the hand ———

function showRunning(numbers: Float64Array, t: number): void {
  stage.pose(numbers);
  element('time').textContent = `t = ${t.toFixed(2)} s`;
}

/** What was recorded can be played until the model changes. */
function endRunning(recorded: Recorded | null): void {
  element('live-run').setAttribute('aria-pressed', 'false');
  if (!recorded || !state?.scene) return;
  player.takeRecorded(recorded, state.scene);
  say('Recorded: play it, or change something to have the model’s own motion again.');
}

async function toggleRunning(): Promise<void> {
  if (running.isOn) {
    await running.end();
    return;
  }
  const t = player.isMoving && player.motion?.isFresh ? (player.clock?.t ?? null) : null;
  player.stop();
  stage.ghost = null;
  choose('hand');
  element('live-run').setAttribute('aria-pressed', 'true');
  say('It moves: pull at it, slide a length; press Live again to stop.');
  await running.begin(t);
}

// ——— Poses ———

let target: World | null = null;
let isDragging = false;

async function drag(): Promise<void> {
  if (isDragging) return;
  isDragging = true;
  while (target) {
    const to = target;
    target = null;
    const began = performance.now();
    const { json, numbers } = await engine.ask<Dragged>({ do: 'drag', to });
    figures.drag = performance.now() - began;
    if (numbers.length > 0) stage.pose(numbers);
    say(json.limit ?? '');
    showTransmissions(element('transmissions'), json.transmissions ?? []);
    if (tab === 'equations' && formulas.isShown) void formulas.refresh();
  }
  isDragging = false;
}

const all = tools({
  stage,
  grab: (hit) => {
    selected = state?.scene?.bodies[hit.body] ?? '';
    owner.tell();
    player.stop();
    stage.ghost = null;
    if (running.isOn) running.pull(hit);
    else void engine.ask({ do: 'grab', body: hit.body, point: hit.local });
  },
  drag: (world) => {
    if (running.isOn) {
      running.to(world);
      return;
    }
    target = world;
    void drag();
  },
  release: () => {
    if (running.isOn) running.release();
    else void engine.ask({ do: 'release' });
  },
  clicked: ({ world, names }) => { if (names.length > 0 && !running.isOn) study.click(world); },
  edit: (made, moving) => { player.stop(); edit(made, moving); },
  settle,
  measure: (from, to) => {
    const distance = metresOf(window.prompt(word('How far are these two places apart?'), '100 mm') ?? '');
    if (distance === null) return;
    underlay.measure(from, to, distance);
    choose('link');
    stage.redraw();
  },
  say,
});

/** Deletes or copies what is selected; false where nothing is. */
function ofSelection(deed: string): boolean {
  const names = stage.selected;
  if (names.length === 0) return false;
  const by = 40 / stage.camera.scale;
  player.stop();
  if (deed === 'delete') edit({ edit: 'group', names, to: 'delete' }, false);
  else {
    // The copies are selected next.
    isCopying = true;
    edit({ edit: 'group', names, to: { copy: [by, -by] } }, false);
  }
  return true;
}

let isCopying = false;

function choose(wanted: string): void {
  stage.tool?.cancel();
  const isDrawing = wanted !== 'hand';
  const name = isDrawing && state?.scene && !state.scene.planar ? 'hand' : wanted;
  if (isDrawing && running.isOn) void running.end();
  stage.tool = all.find((tool) => tool.name === name) ?? all[0];
  for (const button of document.querySelectorAll<HTMLElement>('[data-tool]')) {
    button.setAttribute('aria-pressed', String(button.dataset.tool === stage.tool.name));
  }
  stage.canvas.dataset.tool = stage.tool.name;
  say(name === wanted ? stage.tool.hint : 'Mechanisms in space are held and seen, not drawn.');
  if (name !== 'hand') player.stop();
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
  if (tab === 'study') study.list();
  if (tab === 'equations') {
    void solver.ask<Equations>({ do: 'equations' }).then(({ json }) => {
      if (own === version) formulas.show(json);
    });
  }
  if (tab === 'limits') {
    void solver.ask<Limits>({ do: 'limits' }).then(({ json }) => {
      if (own === version) showLimits(element('limits'), json);
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
    player.stop();
    void engine.ask({ do: 'pose', pose: 'start' }).then(({ numbers }) => stage.pose(numbers));
  });
  on('save', () => void keeper.save());
  on('live-run', () => void toggleRunning());
  element('export').addEventListener('change', ({ target: list }) => {
    const { value } = list as HTMLSelectElement;
    (list as HTMLSelectElement).value = '';
    keep(value, { name: data.name, stage, charts, text: state?.text ?? '', picture: (request) => engine.ask(request) });
  });
  underlay.wire(stage.camera, () => stage.redraw(), (isThere) => {
    if (isThere) choose('measure');
    else say('This file is no picture.');
  });
  // Who scrubs or steps sees the motion, played or not.
  for (const id of ['scrub', 'back', 'forth']) element(id).addEventListener(id === 'scrub' ? 'input' : 'click', () => player.start());
  element('ghost').addEventListener('change', () => player.compare());
  element('sized').addEventListener('change', ({ target: box }) => dimensions.show((box as HTMLInputElement).checked));
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
    button.addEventListener('click', () => {
      const name = button.dataset.tool ?? 'hand';
      const isOfSelection = name === 'delete' || name === 'copy';
      if (!isOfSelection || !ofSelection(name)) choose(name);
    });
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
    const isCopy = (event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'd';
    if (isRedo) change({ do: 'redo' });
    else if (isUndo) change({ do: 'undo' });
    else if (isCopy && ofSelection('copy')) say('');
    else if (event.key === 'Delete' && ofSelection('delete')) say('');
    else if (event.key === ' ' && !(event.target as HTMLElement).closest('button')) player.clock?.toggle();
    else return;
    event.preventDefault();
  });
}

async function begin(): Promise<void> {
  const isOther = translate(partOf(location.hash, 'lang') ?? navigator.language);
  if (isOther) takeCodes(await (await unpacked(element('codes').textContent ?? '')).json());
  wire();
  stage.extras = (t, numbers, theme) => study.at(t, numbers, theme);
  stage.cut = (scene) => study.cut(scene);
  stage.over = (context) => {
    if (stage.t !== null && stage.scene) study.paint(context, stage.scene.themes[stage.theme]);
    underlay.paint(context, stage.camera, css(data.colors[stage.theme].text));
    dimensions.paint(context);
  };
  stage.near = (world, reach) => underlay.near(world, reach);
  stage.backdrop = () => underlay.corners();
  stage.motion = () => player.corners();
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
  const code = await WebAssembly.compile(await (await unpacked(element('module').textContent ?? '')).arrayBuffer());
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
  const panels = partOf(location.hash, 'panels');
  if (panels !== null) embed(panels.split(','), openTab);
  document.documentElement.dataset.ready = 'yes';
}

// For the browser's console and for tests.
Object.assign(globalThis, {
  bksim: {
    get state() { return state; },
    get motion() { return player.motion; },
    get numbers() { return Array.from(stage.numbers); },
    get time() { return player.clock?.t ?? 0; },
    get isPlaying() { return player.clock?.isPlaying ?? false; },
    get ghost() { return stage.ghost; },
    get shown() { return study.shown; },
    get lit() { return stage.lit; },
    get selected() { return stage.selected; },
    get isRunning() { return running.isOn; },
    get isIdle() { return !isEditing && !isDragging && !isSolving && (running.isOn || !(engine?.isBusy ?? true)) && !(solver?.isBusy ?? true); },
    camera: stage.camera,
    figures,
    ask: (request: object) => engine.ask(request),
  },
});

begin().catch((error: unknown) => say(`This page cannot begin: ${String(error)}`));
