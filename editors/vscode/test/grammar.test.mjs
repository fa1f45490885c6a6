// Colours of a model by the grammar, as an editor reads it; snippets by what the reader says of them.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import test from "node:test";
import oniguruma from "vscode-oniguruma";
import textmate from "vscode-textmate";

const here = (name) => new URL(`../${name}`, import.meta.url);
const wasm = createRequire(import.meta.url).resolve("vscode-oniguruma/release/onig.wasm");
await oniguruma.loadWASM(readFileSync(wasm).buffer);
const registry = new textmate.Registry({
  onigLib: Promise.resolve({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  }),
  loadGrammar: async () =>
    textmate.parseRawGrammar(readFileSync(here("syntaxes/bksim.tmLanguage.json"), "utf8"), "grammar.json"),
});
const grammar = await registry.loadGrammar("source.bksim");

/** The innermost scope of each token of a text. */
function scopes(text) {
  let state = textmate.INITIAL;
  return text.split("\n").flatMap((line) => {
    const read = grammar.tokenizeLine(line, state);
    state = read.ruleStack;
    return read.tokens.map((token) => [line.slice(token.startIndex, token.endIndex), token.scopes.at(-1)]);
  });
}

test("sections, keys, quantities, functions and names have their colours", () => {
  const text = `[bodies.rod] # the rod
mass = "2*m1 + 0.5 kg"
com = [0.5, "-hypot(l1, 3 mm)/2"]
points = { B = [0, "9.81 m/s^2*t^2"] }
type = "revolute"
free = true
value = "if t > 1 s then rod.B.vx*5 N s/m else 0"
shapes = [
  { type = "box", size = ["1 m", 2, 3] },
]`;
  const found = scopes(text);
  const of = (word) => found.find(([own]) => own.trim() === word)?.[1];
  for (const [word, scope] of [
    ["bodies", "keyword.control.section"],
    ["rod", "entity.name.section"],
    ["# the rod", "comment.line"],
    ["mass", "variable.other.property"],
    ["kg", "keyword.other.unit"],
    ["m1", "variable.other.bksim"],
    ["0.5", "constant.numeric"],
    ["hypot", "support.function"],
    ["mm", "keyword.other.unit"],
    ["m/s^2", "keyword.other.unit"],
    ["t", "variable.language"],
    ["\"revolute\"", "string.quoted"],
    ["true", "constant.language"],
    ["then", "keyword.control"],
    ["vx", "variable.other.member"],
    ["N s/m", "keyword.other.unit"],
    ["\"box\"", "string.quoted"],
    ["size", "variable.other.property"],
  ]) {
    assert.ok(of(word)?.startsWith(scope), `${word} is ${of(word)}: ${JSON.stringify(found)}`);
  }
});

test("whatever stands in the examples leaves no text open", () => {
  for (const name of ["slider-crank", "eccentric-press", "four-bar"]) {
    const text = readFileSync(new URL(`../../../examples/${name}/model.toml`, import.meta.url), "utf8");
    const lost = scopes(`${text}\n[bodies.last]`).at(-2);
    assert.deepEqual(lost, ["last", "entity.name.section.bksim"], name);
  }
});

test("a snippet has keys that the reader knows, with values of their kind", () => {
  const snippets = JSON.parse(readFileSync(here("snippets/bksim.json"), "utf8"));
  assert.ok(Object.keys(snippets).length > 40);
  const filled = (lines) => lines.join("\n").replace(/\$\{\d+:([^}]*)\}/g, "$1").replace(/\$\d/g, "");
  const others = '[bodies.body]\nmass = 1\nfree = true\n';
  for (const [name, { body }] of Object.entries(snippets)) {
    let said = "";
    try {
      const text = filled(body);
      const input = text.includes("[bodies.") ? text : `${others}${text}`;
      execFileSync(process.env.BKSIM, ["check", "-", "--json"], { input, stdio: "pipe" });
    } catch (error) {
      said = `${error.stdout}${error.stderr}`;
    }
    // Syntax, dimensions, kinds of values and keys; names of other parts are the author's.
    const codes = said.match(/"M0(01|02|05|20|30|31|32)"/g);
    assert.equal(codes, null, `${name}: ${said}`);
  }
});
