"""The addon in FreeCAD without a window: nothing to set up; `bksim_freecad` is on the path."""
