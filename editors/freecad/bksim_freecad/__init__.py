"""Mechanisms in FreeCAD documents, by the command `bksim`.

The modules, each using those above it:

- `values`: texts of values as they are typed, and as a model file has them
- `program`: the command `bksim`
- `kinds`: what can be added, with its keys, from `bksim schema`
- `geometry`: places, directions, frames and masses of what is drawn
- `elements`: bodies, joints, loads, ... as objects of a document
- `frames`: where bodies and places are in the drawn pose
- `marks`: how joints and loads are shown in the drawing
- `views`: icons in the tree
- `editing`: elements made and changed
- `model`: the model file of a document
- `motion`: runs, and parts that move by them
- `reading`: a model file or drawing as a document
- `operations`: what the commands do, without a window
- `dialog`, `panels`, `commands`: the window
"""
