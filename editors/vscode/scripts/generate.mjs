// Writes the snippets and the grammar from what `bksim` says of itself: its schema, its functions and its units.
// `node scripts/generate.mjs [--check]`, with the command in BKSIM; --check compares, and writes nothing.

import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";

const bksim = process.env.BKSIM ?? "bksim";
const said = (...args) => execFileSync(bksim, args, { encoding: "utf8", env: { ...process.env, LANG: "C" } });
const here = (name) => new URL(`../${name}`, import.meta.url);

const sections = JSON.parse(said("schema")).properties;

/** Values that a snippet begins with, by key; `$` are the places to fill in. */
const VALUES = {
  between: '["${:ground}", "${:body}"]',
  axis: "[${:1}, ${:0}]",
  second: "[${:0}, ${:1}, ${:0}]",
  lead: '"${:5 mm}"',
  length: '"${:200 mm}"',
  curve: '"${:curve}"',
  second_curve: '"${:curve}"',
  on: '"${:body}"',
  vector: '["${:10 N}", ${:0}]',
  value: '"${:1 N m}"',
  joint: '"${:joint}"',
  stiffness: '"${:100 N/m}"',
  damping: '"${:1 N s/m}"',
  min: '"${:0 mm}"',
  max: '"${:100 mm}"',
  mu: "${:0.1}",
  acceleration: '[0, "-9.81 m/s^2"]',
  ratio: "${:-0.5}",
  relation: '"${:A.angle - 2*B.angle}"',
  radius: '"${:50 mm}"',
  radii: '["${:50 mm}", "${:100 mm}"]',
  formula: '["${:0.5 m*cos(p)}", "${:0.3 m*sin(p)}"]',
  range: '[${:0}, ${:2}]',
  points: '[[${:0}, ${:0}], [${:1}, ${:0}], [${:2}, ${:1}]]',
  segments: '[{ rise = "${:20 mm}", over = "${:120 deg}", law = "3-4-5" }]',
  law: '"${:lift}"',
  base_circle: '"${:30 mm}"',
  follower: '{ kind = "roller", radius = "${:10 mm}" }',
};

/** Keys of the snippet of a type, where they are not those that every table of its section has. */
const KEYS = {
  joints: { "": ["between"], prismatic: ["axis"], slot: ["axis"], link: ["length"], universal: ["axis", "second"],
    screw: ["axis", "lead"], cylindrical: ["axis"], planar: ["axis"], "point-on-line": ["axis"], "point-on-plane": ["axis"],
    "parallel-axes": ["axis"], "perpendicular-axes": ["axis", "second"], "constant-velocity": ["axis"],
    "point-on-curve": ["curve"], "line-on-curve": ["curve", "axis"], "curve-on-curve": ["curve", "second_curve"],
    distance: ["length"] },
  loads: { "": [], gravity: ["acceleration"], force: ["on", "vector"], torque: ["on", "value"],
    spring: ["between", "stiffness", "length"], damper: ["between", "damping"], torsion: ["joint", "stiffness"],
    stop: ["joint", "max"], friction: ["joint", "mu"] },
  couplings: { "": ["between"], gear: ["ratio"], belt: ["radii"], chain: ["radii"], rack: ["radius"], screw: ["lead"],
    relation: ["relation"] },
  curves: { "": [], formula: ["formula", "range"], points: ["points"], "cam-law": ["segments"],
    cam: ["law", "base_circle", "follower"] },
};
/** Values that one type needs otherwise. */
const OWN = { "loads.torsion.stiffness": '"${:5 N m/rad}"', "loads.stop.max": '"${:90 deg}"' };

/** Tables without a type. */
const OTHERS = {
  "bodies": ["body", ["[bodies.${:rod}]", 'mass = "${:1 kg}"', 'com = ["${:100 mm}", 0]', 'inertia = "${:0.01 kg m^2}"',
    'points = { ${:A} = [0, 0], ${:B} = ["${:200 mm}", 0] }']],
  "drives": ["drive", ["[drives.${:motor}]", 'joint = "${:joint}"', 'motion = "${:2 rad/s*t}"']],
  "states": ["state", ["[states.${:charge}]", 'rate = "${:1/s}"', "start = ${:0}"]],
  "signals": ["signal", ["[signals.${:held}]", 'value = "${:t}"']],
  "clocks": ["clock", ["[clocks.${:tick}]", 'every = "${:1 ms}"']],
  "tables": ["table", ["[tables.${:gas}]", "points = [[${:0}, ${:1}], [${:1}, ${:2}]]"]],
  "solve": ["solve", ["[solve]", 't_end = "${:10 s}"']],
  "parameters": ["parameters", ["[parameters]", '${:l1} = "${:100 mm}"']],
  "use": ["use", ["[use.${:part}]", 'part = "${:gas-spring}"']],
};

/** Lines with their places numbered. */
function numbered(lines) {
  let n = 0;
  return [...lines.map((line) => line.replaceAll("${:", () => `\${${++n}:`)), "$0"];
}

function snippets() {
  const all = {};
  for (const [section, [prefix, lines]] of Object.entries(OTHERS)) {
    if (!(section in sections)) throw new Error(`no section ${section}`);
    all[`${section}`] = { prefix, description: sections[section].description ?? `[${section}]`, body: numbered(lines) };
  }
  for (const [section, own] of Object.entries(KEYS)) {
    const singular = section.slice(0, -1);
    for (const form of sections[section].additionalProperties.allOf) {
      const type = form.if.properties.type.const;
      const known = form.then.propertyNames.enum;
      const wanted = [...own[""], ...(own[type] ?? [])].filter((key) => known.includes(key));
      const lost = (own[type] ?? []).filter((key) => !known.includes(key));
      if (lost.length) throw new Error(`${section} of type ${type} have no ${lost}`);
      const value = (key) => OWN[`${section}.${type}.${key}`] ?? VALUES[key];
      const lines = [`[${section}.\${:${type.replaceAll("-", "_")}}]`, `type = "${type}"`];
      lines.push(...wanted.map((key) => `${key} = ${value(key)}`));
      all[`${singular} ${type}`] = {
        prefix: [`${singular} ${type}`, type],
        description: `[${section}] of type ${type}`,
        body: numbered(lines),
      };
    }
  }
  return all;
}

/** Names in backticks in the table below a title of the page of a code. */
function listed(code, title) {
  const page = said("explain", code).split(`## ${title}`)[1];
  const cells = page.split("\n").filter((line) => line.startsWith("|")).map((line) => line.split("|"));
  const words = cells.flatMap((parts) => parts.slice(1, -1).join(" ").match(/`[^`]+`/g) ?? []);
  return [...new Set(words.map((word) => word.slice(1, -1).split("(")[0]))];
}

const escaped = (word) => word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
/** Longest first, so that no word hides one that it begins. */
const oneOf = (words) => [...words].sort((a, b) => b.length - a.length || (a < b ? -1 : 1)).map(escaped).join("|");

function grammar() {
  const template = readFileSync(here("scripts/grammar.json"), "utf8");
  const is = (pattern) => (word) => pattern.test(word);
  const units = listed("M030", "Units").filter(is(/^[\p{L}°]+$/u));
  const functions = listed("M022", "Functions").filter(is(/^[a-z]\w*$/)).filter((word) => !["a", "s", "x"].includes(word));
  const lists = { UNITS: oneOf(units), FUNCTIONS: oneOf(functions), SECTIONS: oneOf(Object.keys(sections)) };
  const text = template.replace(/@(UNITS|FUNCTIONS|SECTIONS)@/g, (_, name) => JSON.stringify(lists[name]).slice(1, -1));
  return JSON.parse(text);
}

const made = { "snippets/bksim.json": snippets(), "syntaxes/bksim.tmLanguage.json": grammar() };
for (const [name, value] of Object.entries(made)) {
  const text = `${JSON.stringify(value, null, 2)}\n`;
  if (!process.argv.includes("--check")) {
    writeFileSync(here(name), text);
  } else if (readFileSync(here(name), "utf8") !== text) {
    console.error(`${name} is not what bksim says; run BKSIM=… node scripts/generate.mjs`);
    process.exitCode = 1;
  }
}
