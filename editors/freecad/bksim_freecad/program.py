"""The command `bksim`: where it is, how it is called, what it answers."""

import json
import os
import shutil
import subprocess
import tempfile

import FreeCAD

PREFERENCES = "User parameter:BaseApp/Preferences/Mod/bksim"
# Done, ended early, and interrupted: the log is valid.
WITH_RESULT = (0, 3, 130, 143)

# On Windows, no console comes up for a call.
NO_CONSOLE = getattr(subprocess, "CREATE_NO_WINDOW", 0)


class Failed(Exception):
    """A call that failed, with the diagnostics that `bksim` gives, or a message."""

    def __init__(self, message, diagnostics=()):
        super().__init__(message)
        self.diagnostics = list(diagnostics)


def path():
    """The program: of the preference `Command`, of the variable `BKSIM`, or that on the path."""
    preferred = FreeCAD.ParamGet(PREFERENCES).GetString("Command", "")
    found = shutil.which(preferred or os.environ.get("BKSIM", "bksim"))
    if found is None:
        raise Failed(
            "the command `bksim` is not found: install it, or name it in the preference "
            "`Mod/bksim/Command` (Tools, Edit parameters)"
        )
    return found


def folder(doc):
    """The folder of a document, where files of its model are looked for and its logs are written."""
    if doc.FileName:
        return os.path.dirname(doc.FileName)
    own = os.path.join(tempfile.gettempdir(), f"bksim-{os.getpid()}")
    os.makedirs(own, exist_ok=True)
    return own


def run(arguments, text=None, cwd=None, meanwhile=None):
    """The process that has ended, after `bksim ARGUMENTS`, with a text as standard input.

    `meanwhile` is called some times a second; the run is ended where it returns `False`.
    """
    process = subprocess.Popen(
        [path(), *arguments],
        cwd=cwd,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        creationflags=NO_CONSOLE,
    )
    given = text
    while True:
        try:
            out, err = process.communicate(given, timeout=0.1 if meanwhile else None)
            return subprocess.CompletedProcess(arguments, process.returncode, out, err)
        except subprocess.TimeoutExpired:
            given = None
            if not meanwhile():
                process.terminate()


def text_of(arguments, text=None, cwd=None):
    """What `bksim ARGUMENTS` prints."""
    done = run([*arguments, "--quiet"], text, cwd)
    if done.returncode:
        raise Failed(done.stderr.strip() or f"bksim {arguments[0]} failed")
    return done.stdout


def answer(arguments, text=None, cwd=None, meanwhile=None):
    """The object that `bksim ARGUMENTS --json` prints; a run that ended early has one, too."""
    done = run([*arguments, "--json"], text, cwd, meanwhile)
    try:
        found = json.loads(done.stdout)
    except ValueError:
        raise Failed(done.stderr.strip() or f"bksim {arguments[0]} was interrupted") from None
    if done.returncode not in WITH_RESULT:
        diagnostics = found.get("diagnostics", [])
        message = found.get("message") or "; ".join(fault["message"] for fault in diagnostics)
        help_line = found.get("help")
        raise Failed(f"{message}\n{help_line}" if help_line else message, diagnostics)
    return found
