// The packaged extension in a host, with the real language server.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { TextDocument, host } from "./host.mjs";

const folder = mkdtempSync(join(tmpdir(), "bksim-vsix-"));
execFileSync("unzip", ["-q", new URL("../bksim.vsix", import.meta.url).pathname, "-d", folder]);
const packaged = join(folder, "extension");
const manifest = JSON.parse(readFileSync(join(packaged, "package.json"), "utf8"));

const ARM = `[bodies.arm]
mass = "1 kg"
inertia = "0.1 kg m^2"
points = { A = [0, 0] }

[joints.pivot]
type = "revolut"
between = ["ground", "arm.A"]
`;

test("the package has all that its manifest names, and no more than it needs", () => {
  const { contributes } = manifest;
  const files = [manifest.main, "dist/NOTICES.txt", ...contributes.languages.map((one) => one.configuration)];
  files.push(...contributes.grammars.map((one) => one.path), ...contributes.snippets.map((one) => one.path));
  for (const file of files) assert.ok(existsSync(join(packaged, file)), file);
  assert.ok(!existsSync(join(packaged, "node_modules")) && !existsSync(join(packaged, "src")));
  const named = new Set(contributes.commands.map((one) => one.command));
  for (const items of Object.values(contributes.menus)) {
    for (const { command } of items) assert.ok(named.has(command), command);
  }
});

test("faults of an author's file as bksim prints them are matched with their places", () => {
  const { pattern } = manifest.contributes.problemMatchers[0];
  const file = join(folder, "arm.toml");
  writeFileSync(file, ARM);
  let printed = "";
  try {
    execFileSync(process.env.BKSIM, ["check", file], { encoding: "utf8", stdio: "pipe", env: { ...process.env, LANG: "C" } });
  } catch (error) {
    printed = error.stderr;
  }
  const [title, place] = printed.split("\n");
  assert.deepEqual(new RegExp(pattern[0].regexp).exec(title).slice(1, 3), ["error", "M008"], printed);
  assert.deepEqual(new RegExp(pattern[1].regexp).exec(place).slice(1, 4), [file, "7", "9"], printed);
});

test("the extension serves a model from its opening on", { timeout: 30_000 }, async (t) => {
  const editor = host({ "bksim.path": process.env.BKSIM });
  const extension = editor.load(join(packaged, manifest.main));
  const context = { subscriptions: [] };
  t.after(() => extension.deactivate());
  await extension.activate(context);
  assert.deepEqual(editor.shown.errors, []);
  for (const { command } of manifest.contributes.commands) assert.ok(editor.registered.commands.has(command), command);

  // A file of another program stays what it is.
  const other = new TextDocument(join(folder, "Cargo.toml"), "toml", "[package]\nname = \"x\"\n");
  editor.open(other);
  assert.equal(other.languageId, "toml");

  const file = join(folder, "arm.toml");
  const document = new TextDocument(file, "toml", ARM);
  editor.open(document);
  assert.equal(document.languageId, "bksim");
  const [fault] = await editor.diagnostics(document, (all) => all.length === 1);
  assert.equal(fault.range.start.line, 6);
  assert.match(fault.message, /did you mean `revolute`/);
  assert.equal(String(fault.code.target), "bksim-page:/M008.md");

  // The page behind the code.
  const page = await editor.registered.contents.get("bksim-page").provideTextDocumentContent(fault.code.target);
  assert.match(page, /^# M008/);

  // What the server offers, by the providers of its client.
  const position = new editor.vscode.Position(6, 8);
  const token = new editor.vscode.CancellationTokenSource().token;
  const { given } = editor.registered.providers.get("CompletionItem");
  const items = await given.provideCompletionItems(document, position, token, { triggerKind: 0 });
  const labels = (items.items ?? items).map((item) => item.label ?? item.given[0]);
  assert.ok(labels.includes("revolute") && labels.includes("prismatic"), labels.join());
  for (const name of ["Hover", "Reference", "DocumentSymbol", "CodeActions", "InlayHints", "Rename"]) {
    assert.ok(editor.registered.providers.has(name), name);
  }

  // Commands about the active model.
  const right = ARM.replace("revolut\"", "revolute\"");
  document.text = right;
  writeFileSync(file, right);
  await editor.registered.commands.get("bksim.equations")();
  assert.deepEqual(editor.shown.errors, []);
  assert.match(editor.shown.panels[0].webview.html, /Content-Security-Policy.*<math/s);
  await editor.registered.commands.get("bksim.solve")();
  const [task] = editor.shown.tasks;
  assert.deepEqual([task.execution.process, ...task.execution.args], [process.env.BKSIM, "solve", file]);
  assert.deepEqual(editor.registered.tasks.provideTasks().map((one) => one.definition.command).slice(0, 2), ["check", "solve"]);
  const own = { definition: { type: "bksim", command: "solve", file, arguments: ["--t-end", "1 s"] }, scope: 2 };
  assert.deepEqual(editor.registered.tasks.resolveTask(own).execution.args, ["solve", file, "--t-end", "1 s"]);

  // Faults of a command are shown.
  writeFileSync(file, ARM);
  await editor.registered.commands.get("bksim.equations")();
  assert.match(editor.shown.errors[0], /M008/);
});
