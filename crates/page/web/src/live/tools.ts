// The tools: what a press, a way and a lift of the hand become.

import { positionOf } from '../poses.js';
import { localOf, type Hit } from './picking';
import { NEWTONS, type Stage } from './stage';
import type { Tool } from './tool';
import type { Edit, World } from './types';

/** What tools need of the page. */
export interface Deeds {
  stage: Stage;
  grab(hit: Hit): void;
  drag(world: World): void;
  release(): void;
  /** A point was clicked, and not dragged. */
  clicked(hit: Hit): void;
  edit(edit: Edit, isMoving: boolean): void;
  settle(): void;
  /** Scales the picture underneath by the distance of two of its places. */
  measure(from: World, to: World): void;
  say(text: string): void;
}

type Flat = [number, number];
interface End { world: Flat; on?: string; local?: Flat }

const flat = ([x, y]: World): Flat => [x, y];

/** An end at a place: a named point there, a body, or the plane. */
function endAt(hit: Hit | null, world: World): End {
  if (hit && hit.names.length > 0) return { world: flat(hit.world), on: hit.names[0] };
  return { world: flat(world) };
}

/** An end on a body that gets a point there. */
function endOn(deeds: Deeds, hit: Hit | null, world: World): End {
  if (!hit || hit.names.length > 0) return endAt(hit, world);
  const name = deeds.stage.scene?.bodies[hit.body];
  return name ? { world: flat(world), on: name, local: flat(hit.local) } : { world: flat(world) };
}

function tool(name: string, hint: string, of: Partial<Tool>): Tool {
  return {
    name, hint, from: null, press: () => {}, move: () => {}, lift: () => {}, cancel: () => {}, ...of,
  };
}

/** Drags a point or body; the mechanism follows. */
function hand(deeds: Deeds): Tool {
  let isHeld = false;
  let pressed: Hit | null = null;
  return tool('hand', 'Drag any point or body; click a point to see its path.', {
    press: (hit) => { pressed = hit; },
    move: (world) => {
      // A click takes no hold: the motion goes on.
      if (pressed && pressed.body !== 0 && !isHeld) deeds.grab(pressed);
      isHeld = pressed !== null && pressed.body !== 0;
      if (isHeld) deeds.drag(world);
    },
    lift: (_, isClick) => {
      if (isHeld) deeds.release();
      isHeld = false;
      if (isClick && pressed) deeds.clicked(pressed);
      pressed = null;
    },
    cancel: () => { if (isHeld) deeds.release(); isHeld = false; pressed = null; },
  });
}

/** Moves a named point on its bodies: lengths change. */
function shape(deeds: Deeds): Tool {
  let names: string[] = [];
  let frames: Float64Array = new Float64Array(0);
  const bodies = () => deeds.stage.scene?.bodies ?? [];
  return tool('shape', 'Drag a point to change lengths.', {
    press: (hit) => {
      names = hit?.names ?? [];
      frames = deeds.stage.numbers.slice();
      if (hit && names.length === 0) deeds.say('Drag a point with a name; bodies keep their shape.');
    },
    move: (world) => {
      if (names.length === 0) return;
      const edits = names.map((name) => {
        const body = bodies().indexOf(name.split('.')[0]);
        const [x, y] = localOf(frames, Math.max(0, body), world);
        return { edit: 'move', point: name, to: [x, y] };
      });
      deeds.edit(edits.length === 1 ? edits[0] : { edit: 'several', edits }, true);
    },
    lift: () => { if (names.length > 0) deeds.settle(); names = []; },
    cancel: () => { names = []; },
  });
}

/** Two clicks, or a press at one end and a lift at the other. */
function between(name: string, hint: string, deeds: Deeds, make: (from: End, to: End) => Edit | null, of: typeof endOn): Tool {
  let from: End | null = null;
  let isOpen = false;
  let second: Hit | null = null;
  const made: Tool = tool(name, hint, {
    press: (hit, world) => {
      second = hit;
      isOpen = from !== null;
      if (!from) from = of(deeds, hit, world);
    },
    lift: (world, isClick) => {
      if (!from) return;
      const distance = Math.hypot(world[0] - from.world[0], world[1] - from.world[1]);
      if (!isOpen && (isClick || distance * deeds.stage.camera.scale < 8)) return;
      // A double click is one click.
      if (distance * deeds.stage.camera.scale < 2) return;
      const { stage } = deeds;
      const [x, y] = stage.camera.project(world);
      const hit = isClick ? second : stage.found([x, y]);
      const to = of(deeds, hit, world);
      const edit = make(from, to);
      from = null;
      if (edit) deeds.edit(edit, false);
    },
    cancel: () => { from = null; },
  });
  Object.defineProperty(made, 'from', { get: () => (from ? [...from.world, 0] : null) });
  return made;
}

/** Whether a polygon has no area, against the square of its longest side. */
function isFlat(corners: End[]): boolean {
  let [area, longest] = [0, 0];
  corners.forEach(({ world: [ax, ay] }, i) => {
    const [bx, by] = corners[(i + 1) % corners.length].world;
    area += 0.5 * (ax * by - bx * ay);
    longest = Math.max(longest, Math.hypot(bx - ax, by - ay));
  });
  return !(Math.abs(area) > 1e-6 * longest * longest);
}

/** Corners of a plate by clicks; a click on the first corner, or Enter on it, ends it. */
function plate(deeds: Deeds): Tool {
  let corners: End[] = [];
  let pressed: { hit: Hit | null; world: World } | null = null;
  const made: Tool = tool('plate', 'Click the corners of a plate; click the first one again to end it.', {
    press: (hit, world) => { pressed = { hit, world }; },
    lift: () => {
      if (!pressed) return;
      const end = endOn(deeds, pressed.hit, pressed.world);
      pressed = null;
      const [first] = corners;
      const isFirst = first && Math.hypot(end.world[0] - first.world[0], end.world[1] - first.world[1]) * deeds.stage.camera.scale < 12;
      if (!isFirst) {
        corners.push(end);
        return;
      }
      const all = corners;
      corners = [];
      if (isFlat(all)) deeds.say('A plate has three corners or more, not in one line.');
      else deeds.edit({ edit: 'plate', corners: all }, false);
    },
    cancel: () => { corners = []; },
  });
  Object.defineProperty(made, 'from', { get: () => (corners.length > 0 ? [...corners[corners.length - 1].world, 0] : null) });
  Object.defineProperty(made, 'way', { get: () => corners.map(({ world }) => [...world, 0]) });
  return made;
}

/** Two places of the picture underneath, whose distance is asked for. */
function measure(deeds: Deeds): Tool {
  return between('measure', 'Click two places of the picture whose distance is known.', deeds, (from, to) => {
    deeds.measure([...from.world, 0], [...to.world, 0]);
    return null;
  }, (_, __, world) => ({ world: flat(world) }));
}

/** Says what a click should meet. */
function no(deeds: Deeds, hint: string): null {
  deeds.say(hint);
  return null;
}

/** One click on a point or body. */
function click(name: string, hint: string, deeds: Deeds, make: (hit: Hit | null, world: World) => Edit | null): Tool {
  let pressed: { hit: Hit | null; world: World } | null = null;
  return tool(name, hint, {
    press: (hit, world) => { pressed = { hit, world }; },
    lift: () => {
      if (!pressed) return;
      const edit = make(pressed.hit, pressed.world);
      pressed = null;
      if (edit) deeds.edit(edit, false);
    },
    cancel: () => { pressed = null; },
  });
}

/** From one place to another, in steps of the grid unless Alt is held: a solved pose has other places than round ones. */
function difference({ stage }: Deeds, from: Flat, to: Flat): Flat {
  const round = (x: number) => (stage.isSnapping ? Number((Math.round(x / stage.grid) * stage.grid).toPrecision(9)) : x);
  return [round(to[0] - from[0]), round(to[1] - from[1])];
}

/** A press on a point, and a lift that gives a direction. */
function directed(name: string, hint: string, deeds: Deeds, make: (at: End, by: Flat) => Edit): Tool {
  return between(name, hint, deeds, (from, to) => {
    return make(from, difference(deeds, from.world, to.world));
  }, endOn);
}

/** A joint at a place: where two bodies have a point in common. */
function jointAt(deeds: Deeds, hit: Hit | null): { name: string; value: number; isDriven: boolean } | null {
  if (!hit || hit.names.length === 0) return null;
  const bodies = deeds.stage.scene?.bodies ?? [];
  const there = new Set(hit.names.map((name) => bodies.indexOf(name.split('.')[0])));
  const markers = deeds.stage.scene?.markers ?? [];
  const isHere = (name: string) => markers.some((marker) => {
    if (marker.kind !== 'joint' || marker.name !== name) return false;
    const [x, y] = positionOf(deeds.stage.numbers, marker.at.body, ...marker.at.position);
    return Math.hypot(x - hit.world[0], y - hit.world[1]) * deeds.stage.camera.scale < 2;
  });
  const all = deeds.stage.joints.filter(({ name, bodies: [a, b] }) => isHere(name) && (there.has(a) || there.has(b)));
  const found = all.find(({ bodies: [a] }) => a === 0) ?? all[0];
  return found ? { name: found.name, value: found.value ?? 0, isDriven: found.is_driven } : null;
}

/** Angle of the second of two equal wheels where that of the first is zero, as they stand: angles count against their carrier. */
function phaseOf({ stage }: Deeds, first: string, second: string): number {
  const [a, b] = [first, second].map((name) => stage.joints.find((joint) => joint.name === name));
  if (!a || !b) return 0;
  const angle = (joint: typeof a, other: typeof a) => (other.bodies.includes(joint.bodies[0]) ? 1 : -1) * (joint.value ?? 0);
  return angle(a, b) + angle(b, a);
}

/** Two clicks on joints. */
function betweenJoints(name: string, hint: string, deeds: Deeds, make: (joints: [string, string], distance: number, phase: number) => Edit): Tool {
  const isJoint = ({ on }: End) => on !== undefined;
  return between(name, hint, deeds, (from, to) => {
    const [dx, dy] = [0, 1].map((i) => to.world[i] - from.world[i]);
    if (isJoint(from) && isJoint(to)) return make([from.on ?? '', to.on ?? ''], Math.hypot(dx, dy), phaseOf(deeds, from.on ?? '', to.on ?? ''));
    deeds.say(hint);
    return null;
  }, (_, hit, world) => ({ world: hit ? flat(hit.world) : flat(world), on: jointAt(deeds, hit)?.name }));
}

/** Bodies that are held together: a click takes one, with Shift one more, and a way around them all; dragged, they move. */
function select(deeds: Deeds): Tool {
  const { stage } = deeds;
  let pressed: { hit: Hit | null; world: World } | null = null;
  let corner: World | null = null;
  const bodyOf = (hit: Hit | null) => (hit && hit.body !== 0 ? stage.scene?.bodies[hit.body] : undefined);
  const made: Tool = tool('select', 'Click bodies or draw around them; drag, Ctrl+D or Delete moves, copies or deletes them.', {
    press: (hit, world) => {
      pressed = { hit, world };
      const name = bodyOf(hit);
      if (name && stage.isAdding) stage.selected = stage.selected.includes(name) ? stage.selected.filter((own) => own !== name) : [...stage.selected, name];
      else if (name && !stage.selected.includes(name)) stage.selected = [name];
    },
    move: (world) => {
      if (!pressed) return;
      if (bodyOf(pressed.hit)) deeds.edit({ edit: 'group', names: stage.selected, to: { move: [0, 1].map((i) => world[i] - (pressed?.world[i] ?? 0)) } }, true);
      else corner = world;
    },
    lift: () => {
      if (pressed && bodyOf(pressed.hit)) deeds.settle();
      else if (pressed) {
        const within = corner ? stage.bodiesWithin(pressed.world, corner) : [];
        stage.selected = [...new Set([...(stage.isAdding ? stage.selected : []), ...within])];
      }
      pressed = null;
      corner = null;
    },
    cancel: () => { pressed = null; corner = null; stage.selected = []; },
    nudge: (by) => {
      if (stage.selected.length > 0) deeds.edit({ edit: 'group', names: stage.selected, to: { move: by } }, false);
      return stage.selected.length > 0;
    },
  });
  Object.defineProperty(made, 'band', { get: () => (pressed && corner ? [pressed.world, corner] : null) });
  return made;
}

/** A body, then the place of another one like it. */
function copied(name: string, hint: string, deeds: Deeds, mirrored: boolean): Tool {
  return between(name, hint, deeds, (from, to) => {
    const [body] = (from.on ?? 'ground').split('.');
    if (body !== 'ground') return { edit: 'copy', name: body, at: to.world, mirrored };
    deeds.say(hint);
    return null;
  }, endOn);
}

export function tools(deeds: Deeds): Tool[] {
  const bodyOf = (hit: Hit | null) => (hit && hit.body !== 0 ? deeds.stage.scene?.bodies[hit.body] : undefined);
  return [
    hand(deeds),
    shape(deeds),
    select(deeds),
    between('link', 'Click both ends of a link; an end on a point gets a pin.', deeds, (from, to) => ({ edit: 'link', from, to }), (d, hit, world) => (hit && hit.names.length === 0 ? endOn(d, hit, world) : endAt(hit, world))),
    plate(deeds),
    measure(deeds),
    click('ground', 'Click a point to pin it to the ground.', deeds, (hit, world) => (hit && hit.body !== 0 ? { edit: 'ground', at: endOn(deeds, hit, world) } : no(deeds, 'Click a point to pin it to the ground.'))),
    between('pin', 'Click two points to join them with a pin.', deeds, (from, to) => ({ edit: 'pin', from, to }), endOn),
    directed('slide', 'Click a point, then a place in the direction in which it slides.', deeds, (at, by) => ({ edit: 'slide', at, angle: Math.atan2(by[1], by[0]) })),
    between('slot', 'Click the body with the slot, then the point that slides along it.', deeds, (guide, at) => {
      const along = guide.local ? { ...guide, local: [guide.local[0], 0] } : guide;
      return { edit: 'slide', at, angle: 0, guide: along };
    }, endOn),
    betweenJoints('gear', 'Click the joints of two wheels that mesh.', deeds, (joints, distance, phase) => ({ edit: 'gear', between: joints, distance, phase })),
    between('spring', 'Click both ends of a spring.', deeds, (from, to) => ({ edit: 'spring', from, to }), endOn),
    between('damper', 'Click both ends of a damper.', deeds, (from, to) => ({ edit: 'damper', from, to }), endOn),
    directed('force', 'Click a point, then the tip of the force.', deeds, (at, by) => ({ edit: 'force', at, vector: by.map((x) => Number((NEWTONS * x).toPrecision(6))) })),
    click('motor', 'Click a joint to drive it.', deeds, (hit) => {
      const joint = jointAt(deeds, hit);
      if (joint?.isDriven) deeds.say('This joint is driven already.');
      else if (joint) return { edit: 'motor', joint: joint.name, angle: joint.value };
      return joint ? null : no(deeds, 'Click a joint to drive it.');
    }),
    copied('copy', 'Click a body, then the place of its copy.', deeds, false),
    copied('mirror', 'Click a body, then the place of its mirror image.', deeds, true),
    click('delete', 'Click a body to delete it with all that hangs on it.', deeds, (hit) => {
      const name = bodyOf(hit);
      return name ? { edit: 'delete', name } : no(deeds, 'Click a body to delete it with all that hangs on it.');
    }),
  ];
}
