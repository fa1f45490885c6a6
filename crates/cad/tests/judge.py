"""Prints what an independent reader finds in a drawing, one fact a line.

usage: judge.py DRAWING
"""

import sys

import ezdxf

doc = ezdxf.readfile(sys.argv[1])
auditor = doc.audit()
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
        print("insert", entity.dxf.layer, entity.dxf.name, *values, sep="|")
    else:
        print("entity", entity.dxf.layer, entity.dxftype())
