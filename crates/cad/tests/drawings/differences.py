"""What differs between drawings, as an independent reader sees them.

    python differences.py BEFORE AFTER [BEFORE AFTER]…

Prints, for each pair, `== AFTER` and a line for each record that is only in BEFORE (`-`) or only in
AFTER (`+`): a header variable, a table entry, an entity, an object or a comment, with all of its groups.
AFTER is audited, too, and what ezdxf finds under the name BKSIM is listed.
"""

import difflib
import sys
from pathlib import Path

import ezdxf
from ezdxf.lldxf.encoding import decode_dxf_unicode
from ezdxf.lldxf.tagger import ascii_tags_loader, binary_tags_loader


def records(path: Path) -> list[str]:
    data = path.read_bytes()
    if data.startswith(b"AutoCAD Binary DXF"):
        tags = binary_tags_loader(data)
    else:
        with open(path, encoding="utf-8", errors="surrogateescape") as stream:
            tags = list(ascii_tags_loader(stream, skip_comments=False))
    found: list[list[tuple]] = []
    for tag in tags:
        if tag.code in (0, 9, 999) or not found:
            found.append([])
        found[-1].append((tag.code, tag.value))
    return [" ".join(f"{code}:{value!r}" for code, value in record) for record in found]


def compare(before: Path, after: Path) -> None:
    print("==", after.name)
    old, new = records(before), records(after)
    matcher = difflib.SequenceMatcher(None, old, new, autojunk=False)
    for kind, i, j, k, m in matcher.get_opcodes():
        if kind != "equal":
            for line in old[i:j]:
                print("-", line)
            for line in new[k:m]:
                print("+", line)
    doc = ezdxf.readfile(after)
    auditor = doc.audit()
    for fault in auditor.errors + auditor.fixes:
        print("audit", fault.message)
    for entity in doc.modelspace():
        if entity.has_xdata("BKSIM"):
            values = [decode_dxf_unicode(str(tag.value)) for tag in entity.get_xdata("BKSIM")]
            print("BKSIM", entity.dxftype(), *values, sep="|")


if __name__ == "__main__":
    paths = [Path(name) for name in sys.argv[1:]]
    for pair in zip(paths[::2], paths[1::2]):
        compare(*pair)
