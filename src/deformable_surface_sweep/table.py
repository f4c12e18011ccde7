"""The table of a sweep, one row per run in the order of the plan: CSV, and Parquet if pyarrow is installed."""
import csv
import io
import math
import os

from .documents import to_text
from .store import write_whole


def make_columns(plan):
    """Names of the columns, in order."""
    files = [name for name in ("final", "frames", "bag") if getattr(plan.keep, name)]
    return ["run"] + plan.varied + ["status", "problem"] + plan.keep.columns() + files + ["hash"]


def make_row(plan, run, name, record):
    """Cells as text or numbers; None if there is no value."""
    row = [name] + [value if isinstance(value, (int, float, str)) else to_text(value) for value in (run[key] for key in plan.varied)]
    row += [record["status"], record["problem"] or None]
    row += [record["values"].get(column) for column in plan.keep.columns()]
    for column in ("final", "frames", "bag"):
        if getattr(plan.keep, column):
            row.append(" ".join(record["files"].get(column, [])) or None)
    return row + [record["hash"] or None]


def write_table(plan, names, records, out):
    """table.csv, which pandas.read_csv reads, and table.parquet; only runs that have a record. Returns the files."""
    columns = make_columns(plan)
    rows = [make_row(plan, run, name, records[name]) for run, name in zip(plan.runs, names) if name in records]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow(["" if cell is None else repr(cell) if isinstance(cell, float) else cell for cell in row])
    written = [os.path.join(out, "table.csv")]
    write_whole(written[0], text.getvalue().encode())
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        return written
    numbers = set(plan.keep.columns())
    table = pyarrow.table({name: make_column(pyarrow, [row[i] for row in rows], name in numbers) for i, name in enumerate(columns)})
    buffer = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(table, buffer)
    written.append(os.path.join(out, "table.parquet"))
    write_whole(written[1], buffer.getvalue().to_pybytes())
    return written


def make_column(pyarrow, cells, is_number):
    """Doubles if all cells are numbers, else text."""
    if is_number or all(isinstance(cell, (int, float)) and not isinstance(cell, bool) for cell in cells):
        return pyarrow.array([math.nan if cell is None else float(cell) for cell in cells], pyarrow.float64())
    return pyarrow.array([None if cell is None else str(cell) for cell in cells], pyarrow.string())
