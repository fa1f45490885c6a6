// The extension: the language server, commands, tasks and pages of codes.

import { tmpdir } from "node:os";
import { mkdtemp } from "node:fs/promises";
import { basename, join } from "node:path";
import * as vscode from "vscode";
import { LanguageClient } from "vscode-languageclient/node";
import { PAGES, codeOf, equationsPage, isModel } from "./model";
import { program, run, task } from "./program";

let client: LanguageClient | undefined;
let output: vscode.OutputChannel;

export async function activate(context: vscode.ExtensionContext): Promise<void> {
  output = vscode.window.createOutputChannel("bksim");
  const commands: Record<string, (argument?: unknown) => unknown> = {
    "bksim.check": () => onModel((file) => execute("check", file)),
    "bksim.solve": () => onModel((file) => execute("solve", file)),
    "bksim.view": () => onModel((file) => execute("view", file)),
    "bksim.equations": () => onModel(showEquations),
    "bksim.page": () => onModel(openPage),
    "bksim.explain": (code) => explain(typeof code === "string" ? code : undefined),
    "bksim.restart": restart,
  };
  for (const [name, command] of Object.entries(commands)) {
    context.subscriptions.push(vscode.commands.registerCommand(name, command));
  }
  context.subscriptions.push(
    output,
    vscode.tasks.registerTaskProvider("bksim", { provideTasks, resolveTask }),
    vscode.workspace.registerTextDocumentContentProvider(PAGES, { provideTextDocumentContent: page }),
    vscode.workspace.onDidOpenTextDocument(detect),
    vscode.workspace.onDidSaveTextDocument(detect),
    vscode.workspace.onDidChangeConfiguration((change) => {
      if (change.affectsConfiguration("bksim.path")) {
        void restart();
      }
    }),
  );
  await start();
  vscode.workspace.textDocuments.forEach(detect);
}

export function deactivate(): Thenable<void> | undefined {
  return client?.stop();
}

async function start(): Promise<void> {
  const server = { command: program(), args: ["lsp"] };
  client = new LanguageClient("bksim", "bksim", server, {
    // The server says nothing of TOML files that are no models.
    documentSelector: [{ language: "bksim" }, { language: "toml" }],
    initializationOptions: { pages: `${PAGES}:/{code}.md` },
    outputChannel: output,
  });
  try {
    await client.start();
  } catch (error) {
    client = undefined;
    const open = "Open the settings";
    const message = `The language server cannot be started: ${String(error)}. Install bksim, or set bksim.path.`;
    void vscode.window.showErrorMessage(message, open).then((chosen) => {
      if (chosen === open) {
        void vscode.commands.executeCommand("workbench.action.openSettings", "bksim.path");
      }
    });
  }
}

async function restart(): Promise<void> {
  await client?.stop().catch(() => undefined);
  await start();
}

/** Gives TOML files that are models their language. */
function detect(document: vscode.TextDocument): void {
  const isToml = document.uri.path.endsWith(".toml") && ["toml", "plaintext", "ini"].includes(document.languageId);
  const isAsked = vscode.workspace.getConfiguration("bksim").get<boolean>("detect") ?? true;
  if (isToml && isAsked && isModel(document.getText())) {
    void vscode.languages.setTextDocumentLanguage(document, "bksim");
  }
}

/** Does something about the model in the active editor, which is saved before. */
async function onModel(act: (file: string) => unknown): Promise<void> {
  const document = vscode.window.activeTextEditor?.document;
  if (!document || document.uri.scheme !== "file") {
    void vscode.window.showInformationMessage("Open a model file first.");
    return;
  }
  if (document.isDirty && !(await document.save())) {
    return;
  }
  try {
    await act(document.uri.fsPath);
  } catch (error) {
    void vscode.window.showErrorMessage(error instanceof Error ? error.message : String(error));
  }
}

function execute(command: string, file: string): Thenable<vscode.TaskExecution> {
  const folder = vscode.workspace.getWorkspaceFolder(vscode.Uri.file(file));
  return vscode.tasks.executeTask(task({ type: "bksim", command, file }, folder));
}

/** Runs a command that may take a while; its faults go to the output. */
async function patiently(title: string, args: string[], file: string): Promise<string | undefined> {
  const options = { location: vscode.ProgressLocation.Notification, title, cancellable: true };
  return vscode.window.withProgress(options, async (_progress, token) => {
    const printed = await run(args, file, token);
    if (token.isCancellationRequested) {
      return undefined;
    }
    if (printed.status !== 0) {
      output.append(printed.stderr);
      output.show(true);
      throw new Error(printed.stderr.split("\n")[0] || `\`bksim ${args[0]}\` ended with status ${printed.status}`);
    }
    return printed.stdout;
  });
}

async function showEquations(file: string): Promise<void> {
  const args = ["equations", file, "--format", "mathml", "--document"];
  const html = await patiently("Deriving the equations", args, file);
  if (html !== undefined) {
    const title = `Equations of ${basename(file)}`;
    const panel = vscode.window.createWebviewPanel("bksim.equations", title, vscode.ViewColumn.Beside, {});
    panel.webview.html = equationsPage(html);
  }
}

async function openPage(file: string): Promise<void> {
  const folder = await mkdtemp(join(tmpdir(), "bksim-"));
  const written = join(folder, `${basename(file, ".toml")}.html`);
  if ((await patiently("Writing a live page", ["page", file, "--live", "-o", written], file)) !== undefined) {
    await vscode.env.openExternal(vscode.Uri.file(written));
  }
}

async function explain(code: string | undefined): Promise<void> {
  const asked = code ?? (await vscode.window.showInputBox({ prompt: "A code, such as M012" }));
  if (asked) {
    const uri = vscode.Uri.parse(`${PAGES}:/${asked.trim().toUpperCase()}.md`);
    await vscode.commands.executeCommand("markdown.showPreview", uri);
  }
}

/** The page of a code, as `bksim explain` prints it. */
async function page(uri: vscode.Uri): Promise<string> {
  const code = codeOf(uri.path);
  const printed = code ? await run(["explain", code]) : undefined;
  return printed?.status === 0 ? printed.stdout : `There is no page at ${uri.path}.`;
}

/** Tasks for the model in the active editor. */
function provideTasks(): vscode.Task[] {
  const document = vscode.window.activeTextEditor?.document;
  if (document?.languageId !== "bksim" || document.uri.scheme !== "file") {
    return [];
  }
  const folder = vscode.workspace.getWorkspaceFolder(document.uri);
  const file = document.uri.fsPath;
  return ["check", "solve", "static", "kinematics"].map((command) => task({ type: "bksim", command, file }, folder));
}

function resolveTask(given: vscode.Task): vscode.Task | undefined {
  const { command, file } = given.definition;
  const folder = typeof given.scope === "object" ? given.scope : undefined;
  return command && file ? task(given.definition, folder) : undefined;
}
