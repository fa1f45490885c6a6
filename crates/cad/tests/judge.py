"""Prints what an independent reader finds in drawings, one fact a line.

usage: judge.py DRAWING...
"""

import sys

import ezdxf


def judge(path):
    doc = ezdxf.readfile(path)
    auditor = doc.audit()
    print("drawing", path)
    print("version", doc.acad_release)
    print("units", doc.header.get("$INSUNITS", "none"))
    for fault in auditor.errors:
        print("error", fault.code, fault.message)
    for fix in auditor.fixes:
        print("fix", fix.code, fix.message)
    for layer in doc.layers:
        print("layer", layer.dxf.name)
    for block in doc.blocks:
        if block.name.upper().startswith("BK_"):
            tags = [e.dxf.tag for e in block if e.dxftype() == "ATTDEF"]
            print("block", block.name, len(block) - len(tags), *tags)
    for entity in doc.modelspace():
        if entity.dxftype() == "INSERT":
            values = [f"{a.dxf.tag}={a.dxf.text}" for a in entity.attribs if a.dxf.text]
            x, y, _ = entity.dxf.insert
            frame = f"at={x!r},{y!r},{entity.dxf.rotation!r}"
            print("insert", entity.dxf.layer, entity.dxf.name, *values, frame, sep="|")
        else:
            print("entity", entity.dxf.layer, entity.dxftype())


for path in sys.argv[1:]:
    judge(path)
