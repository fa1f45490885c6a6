"""Opens drawings as a CAD program opens damaged files, and saves them: `resave.py FOLDER FILE…`."""

import sys
from pathlib import Path

from ezdxf import recover

folder, *drawings = sys.argv[1:]
for path in map(Path, drawings):
    doc, auditor = recover.readfile(path)
    assert not auditor.has_errors, [error.message for error in auditor.errors]
    # New handles, a new order of the tables, the newest version.
    doc.dxfversion = "R2018"
    doc.saveas(Path(folder) / path.name)
    print(path.name)
