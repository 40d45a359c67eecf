#!/usr/bin/env python3
"""Makes a body for `kinora encode --body` of MakeHuman's base mesh, which is CC0.

usage: makehuman_body.py FOLDER OUT.npz [TARGET...]     (any Python 3, nothing else)

FOLDER holds base.obj.gz, rigs/rig.game_engine.json and rigs/weights.game_engine.json, as MakeHuman's assets do; a
TARGET is a file of vertex offsets (`index dx dy dz`, .target or .target.gz) that is applied to it. Joints are put into
SMPL's order; metres, y up.
"""
import gzip
import json
import pathlib
import struct
import sys
import zipfile

# SMPL's joints in order: the rig's bone at whose head each lies, and its parent.
JOINTS = (("pelvis", -1), ("thigh_l", 0), ("thigh_r", 0), ("spine_01", 0), ("calf_l", 1), ("calf_r", 2), ("spine_02", 3),
          ("foot_l", 4), ("foot_r", 5), ("spine_03", 6), ("ball_l", 7), ("ball_r", 8), ("neck_01", 9),
          ("clavicle_l", 9), ("clavicle_r", 9), ("head", 12), ("upperarm_l", 13), ("upperarm_r", 14),
          ("lowerarm_l", 16), ("lowerarm_r", 17), ("hand_l", 18), ("hand_r", 19))
METRES = 0.1  # of the mesh's decimetres


def read_obj(path):
    """Vertices, and for each group the corners of its faces."""
    vertices, groups, group = [], {}, None
    for line in gzip.open(path, "rt"):
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["g"]:
            group = groups.setdefault(words[1], [])
        elif words[:1] == ["f"]:
            group.append([int(word.split("/")[0]) - 1 for word in words[1:]])
    return vertices, groups


def apply_target(path, vertices):
    with (gzip.open(path, "rt") if path.endswith(".gz") else open(path)) as file:
        for line in file:
            words = line.split("#")[0].split()
            if words:
                for axis, offset in enumerate(words[1:4]):
                    vertices[int(words[0])][axis] += float(offset)


def npy(kind, rows, columns, values):
    header = f"{{'descr': '<{kind}', 'fortran_order': False, 'shape': ({rows}, {columns}), }}"
    header += " " * (-(len(header) + 11) % 64) + "\n"
    code = {"f4": "f", "i4": "i"}[kind]
    return (b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() +
            struct.pack(f"<{rows * columns}{code}", *values))


def main():
    folder, out, targets = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    vertices, groups = read_obj(folder / "base.obj.gz")
    for target in targets:
        apply_target(target, vertices)
    rig = json.loads((folder / "rigs/rig.game_engine.json").read_text())
    weights = json.loads((folder / "rigs/weights.game_engine.json").read_text())["weights"]
    index = {bone: i for i, (bone, _) in enumerate(JOINTS)}

    def joint_of(bone):
        while bone and bone not in index:
            bone = rig[bone]["parent"]
        return index.get(bone, 0)

    cubes = [sorted({v for face in groups[rig[bone]["head"]["cube_name"]] for v in face}) for bone, _ in JOINTS]
    faces = [corner for face in groups["body"] for i in range(1, len(face) - 1)
             for corner in (face[0], face[i], face[i + 1])]
    kept = sorted(set(faces).union(*cubes))
    place = {v: i for i, v in enumerate(kept)}
    count, joints = len(kept), len(JOINTS)
    table = [0.0] * (count * joints)
    for bone, pairs in weights.items():
        for vertex, weight in pairs:
            if vertex in place:
                table[place[vertex] * joints + joint_of(bone)] += weight
    for i in range(count):
        row = table[i * joints:(i + 1) * joints]
        total = sum(row)
        table[i * joints:(i + 1) * joints] = [w / total for w in row] if total > 0 else [1.0] + [0.0] * (joints - 1)
    regressor = [0.0] * (joints * count)
    for j, cube in enumerate(cubes):
        for v in cube:
            regressor[j * count + place[v]] = 1 / len(cube)
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("v_template.npy", npy("f4", count, 3, [METRES * x for v in kept for x in vertices[v]]))
        archive.writestr("f.npy", npy("i4", len(faces) // 3, 3, [place[v] for v in faces]))
        archive.writestr("weights.npy", npy("f4", count, joints, table))
        archive.writestr("J_regressor.npy", npy("f4", joints, count, regressor))
        archive.writestr("kintree_table.npy", npy("i4", 2, joints, [p for _, p in JOINTS] + list(range(joints))))


if __name__ == "__main__":
    main()
