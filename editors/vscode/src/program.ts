// The command `bksim`: started, and what it prints.

import { execFile } from "node:child_process";
import { dirname } from "node:path";
import * as vscode from "vscode";

/** What a command has printed. */
export interface Printed {
  status: number;
  stdout: string;
  stderr: string;
}

/** The path of the command. */
export function program(): string {
  return vscode.workspace.getConfiguration("bksim").get<string>("path") || "bksim";
}

/** Runs a command in the folder of a model, up to its end or until it is given up. */
export function run(args: string[], file?: string, token?: vscode.CancellationToken): Promise<Printed> {
  const options = { cwd: file && dirname(file), maxBuffer: 1 << 28, windowsHide: true };
  return new Promise((resolve, reject) => {
    const child = execFile(program(), args, options, (error, stdout, stderr) => {
      if (error && typeof error.code !== "number") {
        reject(new Error(`\`${program()}\` cannot be started: ${error.message}`));
        return;
      }
      resolve({ status: typeof error?.code === "number" ? error.code : 0, stdout, stderr });
    });
    token?.onCancellationRequested(() => child.kill());
  });
}

/** A task that runs a command about a model. */
export function task(definition: vscode.TaskDefinition, folder?: vscode.WorkspaceFolder): vscode.Task {
  const { command, file, arguments: more = [] } = definition as unknown as {
    command: string;
    file: string;
    arguments?: string[];
  };
  const execution = new vscode.ProcessExecution(program(), [command, file, ...more], {
    cwd: folder?.uri.fsPath ?? dirname(file),
  });
  const scope = folder ?? vscode.TaskScope.Workspace;
  const made = new vscode.Task(definition, scope, `${command} ${file}`, "bksim", execution, "$bksim");
  made.presentationOptions = { reveal: vscode.TaskRevealKind.Always, clear: true };
  if (command === "check") {
    made.group = vscode.TaskGroup.Build;
  }
  return made;
}
