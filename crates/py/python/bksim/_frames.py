"""Tables of other packages as columns by name: pandas, Polars, xarray, Arrow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def columns_of(table: Any) -> Mapping[str, Any] | None:
    """The columns of a data frame, a dataset or an Arrow table, and of a mapping these of itself; ``None`` of anything else.

    Where the table knows the unit of a column, as those that bksim makes, its heading has it: ``theta [rad]``.
    """
    units: Mapping[str, str] = {}
    if hasattr(table, "to_dataframe"):
        # A dataset of xarray, whose coordinate is the index of the frame.
        variables = dict(table.variables)
        units = {str(name): str(of.attrs.get("units", "")) for name, of in variables.items()}
        table = table.to_dataframe()
    elif hasattr(table, "column_names") and hasattr(table, "schema"):
        fields = {field.name: field.metadata or {} for field in table.schema}
        units = {name: of.get(b"unit", b"").decode() for name, of in fields.items()}
        table = {name: table.column(name).to_pylist() for name in table.column_names}
    if hasattr(table, "reset_index"):
        units = units or getattr(table, "attrs", {}).get("units", {})
        if table.index.name is not None:
            table = table.reset_index()
    if not isinstance(table, Mapping):
        if not hasattr(table, "columns") or not hasattr(table, "__getitem__"):
            return None
        table = {str(name): table[name] for name in table.columns}
    return {f"{name} [{units[name]}]" if units.get(name) else name: of for name, of in table.items()}
