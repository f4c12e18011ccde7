#!/usr/bin/env python3
"""Reads the points of a .ply, .pcd, .obj, .off or .xyz file into arrays. The demo and the pictures use it;
the node and `simulate` have their own reader in C++."""
import re

import numpy as np

PLY_TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
             "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
             "double": "f8", "float64": "f8"}
PLY_FORMATS = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}


def read_points(path):
    """The coordinates of the points as an array (n x 3) of doubles, without those that are not finite. Raises ValueError with a
    sentence if the file is not one of the kinds accepted or does not hold what its header says."""
    points = read_rows(path)[0]
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        raise ValueError("%s: no finite point in it" % path)
    return points


def read_rows(path):
    """Coordinates (n x 3), normals (n x 3, or None where the file has none) and all columns by their names, of every point."""
    readers = {".ply": read_ply, ".pcd": read_pcd, ".obj": read_obj, ".off": read_off, ".xyz": read_xyz}
    suffix = path[path.rfind("."):].lower() if "." in path else ""
    if suffix not in readers:
        raise ValueError("%s: unknown kind of file '%s'; accepted: %s" % (path, suffix, ", ".join(sorted(readers))))
    with open(path, "rb") as stream:
        data = stream.read()
    try:
        columns = readers[suffix](data)
        triples = [np.stack([columns[name] for name in names], axis=1).astype(float)
                   for names in ("xyz", ("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z")) if names == "xyz" or names[0] in columns]
    except (KeyError, IndexError, ValueError) as error:
        raise ValueError("%s: %s" % (path, error if isinstance(error, ValueError) else "broken header near %s" % error))
    return triples[0], triples[1] if len(triples) > 1 else None, columns


def read_ply(data):
    end = re.search(rb"^end_header\r?\n", data, re.MULTILINE)
    if not data.startswith(b"ply") or not end:
        raise ValueError("not a PLY file: it lacks 'ply' or 'end_header'")
    form, count, names, types, element, before_vertices = "", 0, [], [], "", True
    for line in data[:end.start()].decode("ascii", "replace").splitlines():
        word = line.split()
        if not word:
            continue
        if word[0] == "format":
            form = word[1]
        elif word[0] == "element":
            element = word[1]
            if element == "vertex":
                count, before_vertices = int(word[2]), False
            elif before_vertices:
                raise ValueError("its first element is '%s'; accepted: vertex" % element)
        elif word[0] == "property" and element == "vertex":
            if word[1] == "list":
                raise ValueError("a list property of the vertices; accepted: plain numbers")
            names.append(word[2])
            types.append(PLY_TYPES[word[1]])
    if form not in PLY_FORMATS:
        raise ValueError("format '%s'; accepted: %s" % (form, ", ".join(PLY_FORMATS)))
    if PLY_FORMATS[form] is None:
        return read_table(data[end.end():].splitlines()[:count], count, names)
    record = np.dtype([(name, PLY_FORMATS[form] + kind) for name, kind in zip(names, types)])
    return read_records(data[end.end():], record, count)


def read_pcd(data):
    mark = re.search(rb"^DATA\s+(\w+)\r?\n", data, re.MULTILINE)
    if not mark:
        raise ValueError("not a PCD file: it lacks the line DATA")
    header = {}
    for line in data[:mark.start()].decode("ascii", "replace").splitlines():
        word = line.split()
        if word and not word[0].startswith("#"):
            header[word[0]] = word[1:]
    names, count = header["FIELDS"], int(header["POINTS"][0])
    repeats = [int(n) for n in header.get("COUNT", ["1"] * len(names))]
    kinds = [{"I": "i", "U": "u", "F": "f"}[kind] + size for kind, size in zip(header["TYPE"], header["SIZE"])]
    body, form = data[mark.end():], mark.group(1).decode()
    # Names of padding fields repeat, hence the number in front.
    keys = [name if names.index(name) == i else "%d_%s" % (i, name) for i, name in enumerate(names)]
    fields = [(key, "<" + kind, (n,)) if n > 1 else (key, "<" + kind) for key, kind, n in zip(keys, kinds, repeats)]
    if form == "ascii":
        each = [key if k == 0 else "%s_%d" % (key, k) for key, n in zip(keys, repeats) for k in range(n)]
        return read_table(body.splitlines()[:count], count, each)
    if form == "binary":
        return read_records(body, np.dtype(fields), count)
    if form == "binary_compressed":
        packed, unpacked = (int(n) for n in np.frombuffer(body, "<u4", 2))
        body, start, columns = decompress_lzf(body[8:8 + packed], unpacked), 0, {}
        for field in fields:  # one field after the other, each for all points
            kind = np.dtype([field])
            columns[field[0]] = np.frombuffer(body, kind, count, start)[field[0]]
            start += kind.itemsize * count
        return columns
    raise ValueError("DATA %s; accepted: ascii, binary, binary_compressed" % form)


def read_off(data):
    lines = [line for line in (raw.split(b"#")[0].strip() for raw in data.splitlines()) if line]
    if not lines or not re.match(rb"(C|N|ST|CN)*OFF", lines[0]):
        raise ValueError("not an OFF file: it does not begin with OFF")
    first = lines[0].split()[1:]
    rest = lines[1:] if first else lines[2:]
    count = int((first or lines[1].split())[0])
    return read_table(rest[:count], count, ["x", "y", "z"])


def read_obj(data):
    """The vertices; their normals, which belong to corners of faces and not to vertices, are left."""
    lines = [line.split(None, 1)[1] for line in data.splitlines() if re.match(rb"\s*v\s+\S", line)]
    if not lines:
        raise ValueError("no line that begins with 'v', a vertex")
    return read_table(lines, len(lines), ["x", "y", "z"])


def read_xyz(data):
    lines = [line for line in data.splitlines() if line.strip() and not line.lstrip().startswith(b"#")]
    has_normals = bool(lines) and len(lines[0].split()) >= 6
    return read_table(lines, len(lines), ["x", "y", "z"] + (["nx", "ny", "nz"] if has_normals else []))


def read_table(lines, count, names):
    if len(lines) < count:
        raise ValueError("%d points promised, %d lines found" % (count, len(lines)))
    rows = [line.split()[:len(names)] for line in lines]
    if any(len(row) < len(names) for row in rows):
        raise ValueError("a line of fewer numbers than its %d columns" % len(names))
    table = np.array([[float(word) for word in row] for row in rows]).reshape(-1, len(names))
    return dict(zip(names, table.T))


def read_records(data, record, count):
    if len(data) < record.itemsize * count:
        raise ValueError("%d points of %d bytes promised, %d bytes found" % (count, record.itemsize, len(data)))
    table = np.frombuffer(data, record, count)
    return {name: table[name] for name in record.names}


def decompress_lzf(data, size):
    """LZF, as PCD files use it: a control byte begins a run of literal bytes or a copy from the output so far."""
    out, i = bytearray(), 0
    while i < len(data):
        control = data[i]
        i += 1
        if control < 32:
            out += data[i:i + control + 1]
            i += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[i]
            i += 1
        start = len(out) - ((control & 31) << 8) - data[i] - 1
        i += 1
        if start < 0:
            raise ValueError("the compressed data is broken")
        for k in range(start, start + length + 2):  # byte by byte: the copy may overlap what it makes
            out.append(out[k])
    if len(out) != size:
        raise ValueError("the compressed data holds %d bytes, the header says %d" % (len(out), size))
    return bytes(out)


if __name__ == "__main__":
    raise SystemExit("point_files.py is a module of demo_client.py and draw_cloud.py; it does nothing by itself")
