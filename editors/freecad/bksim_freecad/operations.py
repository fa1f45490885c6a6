"""What the commands do, without a window: each takes a document."""

from contextlib import contextmanager

from . import editing, elements, kinds, model, motion, program, reading

# Formats of equations for the panel, the clipboard and a browser.
EQUATIONS = {
    "text": ["--format", "aligned", "--unicode", "--width", "100"],
    "latex": ["--format", "latex", "--document"],
    "html": ["--format", "mathml", "--document"],
}


@contextmanager
def step(doc, title):
    """One step of undo, of the drawn pose; what fails within leaves the document as it was."""
    motion.go_home(doc)
    doc.openTransaction(title)
    try:
        yield
    except Exception:
        doc.abortTransaction()
        raise
    doc.recompute()
    doc.commitTransaction()


def add(doc, kind_id, name="", values=None, **links):
    """Adds a body, joint, load or whatever has a kind; see `editing.add`."""
    with step(doc, f"Add {kind_id}"):
        return editing.add(doc, kind_id, name, values, **links)


def delete(doc, objects):
    """Removes elements; what they refer to in the drawing stays."""
    with step(doc, "Delete"):
        for obj in objects:
            doc.removeObject(obj.Name)


def mark_faults(doc, text, diagnostics):
    """Writes faults to the elements that they are about; returns them with these elements and the keys."""
    found = []
    for fault in diagnostics:
        labels = fault.get("labels") or [{}]
        obj, key = text.about(labels[0].get("line", 0))
        if obj is None:
            quoted = fault["message"].split("`")[1::2]
            obj = next((one for one in elements.all_of(doc) if one.ElementName in quoted and one.ElementName), None)
        found.append((fault, obj, key))
    for obj in elements.all_of(doc):
        own = [f"{fault['severity']} {fault['code']}: {fault['message']}" for fault, about, _ in found if about == obj]
        if obj.Fault != "\n".join(own):
            obj.Fault = "\n".join(own)
    return found


def ask(doc, arguments, probes=None, meanwhile=None):
    """The answer of a command about the model of a document, and its faults with their elements."""
    text = model.generate(doc, probes)
    try:
        found = program.answer(arguments, text.text, program.folder(doc), meanwhile)
    except program.Failed as failed:
        failed.faults = mark_faults(doc, text, failed.diagnostics)
        raise
    return found, mark_faults(doc, text, found.get("diagnostics", []))


def check(doc):
    """The count of freedoms and the faults of a mechanism; a rejected one has no count."""
    try:
        return ask(doc, ["check", "-"])
    except program.Failed as failed:
        if not failed.faults:
            raise
        return None, failed.faults


def equations(doc, form="text"):
    """The equations of a mechanism: as text for a panel, as a document of LaTeX, or as a page with MathML."""
    check_first(doc)
    return program.text_of(["equations", "-", *EQUATIONS[form]], model.generate(doc).text, program.folder(doc))


def check_first(doc):
    """Raises the faults of a mechanism that is rejected, with their elements."""
    ask(doc, ["check", "-"])


def start(doc):
    """Puts the parts at the consistent start, and returns what `bksim assemble` finds."""
    found, faults = ask(doc, ["assemble", "-"])
    motion.show(doc, motion.read(doc, motion.short_run(doc)), 0)
    return found, faults


def solve(doc, meanwhile=None):
    """Runs the mechanism; the motion is kept for `show` and the log for curves. Returns the answer and its faults."""
    log = motion.log_of(doc)
    found, faults = ask(doc, ["solve", "-", "-o", log, "--force"], motion.probes(doc), meanwhile)
    open_log(doc, log)
    return found, faults


def open_log(doc, log):
    """Takes the motion from a log of the model of a document."""
    motion.runs[doc.Uid] = motion.read(doc, log)
    elements.mechanism(doc).Log = log


def show(doc, t):
    """Puts the parts where the last run has them at a time."""
    run = motion.run_of(doc)
    motion.show(doc, run, run.sample(t))


def home(doc):
    """Puts the parts where they are drawn."""
    motion.go_home(doc)


def channels(doc):
    """Names and units of what the last run has logged."""
    found = program.answer(["info", elements.mechanism(doc).Log])
    return {channel["name"]: channel["unit"] for channel in found["channels"]}


def curves(doc, names):
    """Columns of the last run: channels, or whatever the model can name, such as `rod.B.x`."""
    return motion.table(elements.mechanism(doc).Log, names)


def export(doc, path):
    """Writes the model file of a document."""
    with open(path, "w", encoding="utf-8") as file:
        file.write(model.generate(doc).text)


def read_file(doc, path):
    """Adds a model file, a drawing with attributes, or a robot or linkage of another program."""
    with step(doc, "Import"):
        reading.read_file(doc, path)


def set_starts(doc, values):
    """Writes the starts of joints and bodies: a text for each name."""
    with step(doc, "Initial values"):
        for section in kinds.WITH_START:
            for obj in elements.all_of(doc, section):
                if obj.ElementName in values:
                    obj.Initial = values[obj.ElementName]
