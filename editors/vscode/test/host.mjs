// A host of extensions without windows: as much of the API of the editor as the extension and its client use. What an
// extension registers is kept, for tests to call; what it shows is kept, for tests to read.

import { createRequire } from "node:module";
import Module from "node:module";
import { pathToFileURL } from "node:url";

class Uri {
  constructor(scheme, path) {
    Object.assign(this, { scheme, path, authority: "", query: "", fragment: "" });
  }
  static parse(text) {
    const [, scheme, path] = /^([\w-]+):(?:\/\/)?(.*)$/.exec(text);
    return new Uri(scheme, decodeURIComponent(path));
  }
  static file(path) {
    return new Uri("file", path);
  }
  get fsPath() {
    return this.path;
  }
  with(change) {
    return Object.assign(new Uri(this.scheme, this.path), change);
  }
  toString() {
    return this.scheme === "file" ? String(pathToFileURL(this.path)) : `${this.scheme}:${this.path}`;
  }
}

class Position {
  constructor(line, character) {
    Object.assign(this, { line, character });
  }
}

class Range {
  constructor(a, b, c, d) {
    const isNumbers = typeof a === "number";
    this.start = isNumbers ? new Position(a, b) : a;
    this.end = isNumbers ? new Position(c, d) : b;
  }
}

class Disposable {
  constructor(dispose = () => undefined) {
    this.dispose = dispose;
  }
  static from(...all) {
    return new Disposable(() => all.forEach((one) => one.dispose()));
  }
}

class EventEmitter {
  #listeners = new Set();
  event = (listener, self) => {
    const bound = self ? listener.bind(self) : listener;
    this.#listeners.add(bound);
    return new Disposable(() => this.#listeners.delete(bound));
  };
  fire(value) {
    for (const listener of this.#listeners) listener(value);
  }
  dispose() {
    this.#listeners.clear();
  }
}

class CancellationTokenSource {
  token = { isCancellationRequested: false, onCancellationRequested: new EventEmitter().event };
  cancel() {
    this.token.isCancellationRequested = true;
  }
  dispose() {}
}

/** A document in memory. */
export class TextDocument {
  constructor(path, languageId, text) {
    Object.assign(this, { uri: Uri.file(path), languageId, text, version: 1, isDirty: false, isClosed: false });
    this.fileName = path;
  }
  getText() {
    return this.text;
  }
  get lineCount() {
    return this.text.split("\n").length;
  }
  save() {
    return Promise.resolve(true);
  }
}

/** A namespace in which whatever is not there is a class of plain data, an event, or a function without effect. */
function open(known) {
  return new Proxy(known, {
    get(target, name) {
      if (name in target || typeof name !== "string" || name === "then") return target[name];
      const Plain = class {
        constructor(...given) {
          this.given = given;
        }
      };
      const isEvent = /^on(Did|Will)/.test(name);
      const isRegistration = /^(register|create|set)/.test(name);
      const made = isEvent || isRegistration ? () => new Disposable() : /^[A-Z]/.test(name) ? Plain : () => undefined;
      target[name] = made;
      return made;
    },
  });
}

/** A host with the settings of an author. */
export function host(settings) {
  const shown = { errors: [], tasks: [], panels: [], opened: [], commands: [], output: "", diagnostics: new Map() };
  const registered = { commands: new Map(), providers: new Map(), contents: new Map(), tasks: undefined };
  const events = {};
  const event = (name) => (events[name] ??= new EventEmitter()).event;
  const provider = (name) => (selector, given, ...more) => {
    registered.providers.set(name, { selector, given, more });
    return new Disposable();
  };
  const channel = {
    append: (text) => (shown.output += text),
    appendLine: (text) => (shown.output += `${text}\n`),
    show() {},
    dispose() {},
  };
  const matches = (one, document) =>
    (one.language === undefined || one.language === document.languageId) &&
    (one.scheme === undefined || one.scheme === document.uri.scheme);
  class Task {
    constructor(definition, scope, name, source, execution, problemMatchers) {
      Object.assign(this, { definition, scope, name, source, execution, problemMatchers });
    }
  }
  class ProcessExecution {
    constructor(process, args, options) {
      Object.assign(this, { process, args, options });
    }
  }
  class Diagnostic {
    constructor(range, message, severity) {
      Object.assign(this, { range, message, severity });
    }
  }
  class CodeActionKind {
    constructor(value) {
      this.value = value;
    }
    static QuickFix = new CodeActionKind("quickfix");
    static Empty = new CodeActionKind("");
    append(part) {
      return new CodeActionKind(this.value ? `${this.value}.${part}` : part);
    }
  }
  const documents = [];
  const api = {
    Uri, Position, Range, Disposable, EventEmitter, CancellationTokenSource, Task, ProcessExecution, Diagnostic,
    CodeActionKind,
    version: "1.82.0",
    ViewColumn: { Beside: -2 },
    TaskScope: { Global: 1, Workspace: 2 },
    TaskRevealKind: { Always: 1 },
    TaskGroup: { Build: "build" },
    ProgressLocation: { Notification: 15 },
    DiagnosticSeverity: { Error: 0, Warning: 1, Information: 2, Hint: 3 },
    TextDocumentSaveReason: { Manual: 1, AfterDelay: 2, FocusOut: 3 },
    LogLevel: { Off: 0, Info: 3 },
    env: { appName: "host", language: "en", logLevel: 3, onDidChangeLogLevel: event("level"),
      openExternal: async (uri) => shown.opened.push(uri) },
    commands: {
      registerCommand(name, run) {
        registered.commands.set(name, run);
        return new Disposable(() => registered.commands.delete(name));
      },
      executeCommand: async (name, ...given) => {
        shown.commands.push([name, ...given]);
        return registered.commands.get(name)?.(...given);
      },
    },
    tasks: {
      registerTaskProvider(_type, given) {
        registered.tasks = given;
        return new Disposable();
      },
      executeTask: async (task) => shown.tasks.push(task),
    },
    languages: open({
      match: (selector, document) => ([selector].flat().some((one) => matches(one, document)) ? 10 : 0),
      createDiagnosticCollection: () => ({
        set: (uri, diagnostics) => {
          shown.diagnostics.set(String(uri), diagnostics ?? []);
          events.diagnostics?.fire(String(uri));
        },
        delete: (uri) => shown.diagnostics.delete(String(uri)),
        get: (uri) => shown.diagnostics.get(String(uri)),
        clear() {}, dispose() {}, forEach() {},
      }),
      async setTextDocumentLanguage(document, language) {
        events.close?.fire(document);
        document.languageId = language;
        events.open?.fire(document);
        return document;
      },
      ...Object.fromEntries(
        ["Hover", "Definition", "Reference", "DocumentHighlight", "DocumentSymbol", "CodeActions", "InlayHints", "Rename",
          "DocumentFormattingEdit", "CompletionItem"].map((name) => [`register${name}Provider`, provider(name)]),
      ),
    }),
    workspace: open({
      textDocuments: documents,
      workspaceFolders: undefined,
      getConfiguration: (section) => ({ get: (key, other) => settings[section ? `${section}.${key}` : key] ?? other }),
      getWorkspaceFolder: () => undefined,
      onDidOpenTextDocument: event("open"),
      onDidCloseTextDocument: event("close"),
      onDidChangeTextDocument: event("change"),
      onDidSaveTextDocument: event("save"),
      onDidChangeConfiguration: event("configuration"),
      registerTextDocumentContentProvider(scheme, given) {
        registered.contents.set(scheme, given);
        return new Disposable();
      },
    }),
    window: open({
      activeTextEditor: undefined,
      visibleTextEditors: [],
      tabGroups: { all: [], onDidChangeTabs: event("tabs"), onDidChangeTabGroups: event("groups") },
      createOutputChannel: () => channel,
      showErrorMessage: async (message) => void shown.errors.push(message),
      withProgress: (_options, act) => act({ report() {} }, new CancellationTokenSource().token),
      createWebviewPanel(_type, title) {
        const panel = { title, webview: { html: "" } };
        shown.panels.push(panel);
        return panel;
      },
    }),
    l10n: { t: (text) => text },
    extensions: { getExtension: () => undefined },
  };
  const vscode = open(api);

  const load = Module._load;
  Module._load = (request, ...more) => (request === "vscode" ? vscode : load(request, ...more));
  return {
    shown,
    registered,
    vscode,
    load: (path) => createRequire(import.meta.url)(path),
    open(document) {
      documents.push(document);
      api.window.activeTextEditor = { document };
      events.open?.fire(document);
    },
    /** Diagnostics of a document as soon as they satisfy a condition. */
    diagnostics(document, isAsExpected) {
      const found = () => shown.diagnostics.get(String(document.uri));
      return new Promise((resolve, reject) => {
        const late = setTimeout(() => reject(new Error(`not as expected: ${JSON.stringify(found())}`)), 10_000);
        const look = () => {
          if (!found() || !isAsExpected(found())) return;
          clearTimeout(late);
          resolve(found());
        };
        event("diagnostics")(look);
        look();
      });
    },
  };
}
