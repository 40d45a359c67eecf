#!/usr/bin/env python3
"""Fits the table of body/pose_prior.cpp: how people hold an arm and a leg.

usage: fit_pose_prior.py MOCAP_CMU > table     (any Python 3, nothing else; seconds)
       fit_pose_prior.py MOCAP_CMU --poses MOTION STEP > poses
                                               (for bench_tracking_poses: each STEPth frame of 02_01, cmu_05_01, …)

Source: the CMU Graphics Lab Motion Capture Database (mocap.cs.cmu.edu), free for all uses; the motions themselves are
not part of Kinora. Read are asfamc/02.asf with its motions, and the BVH versions of 05_01, 49_04 and 102_01.

A limb's pose is four numbers, those of skeleton.h: the rotation vector of shoulder or hip against the chest or pelvis
where the limb is stretched sideways (an arm) or downwards (a leg), and how far elbow or knee is bent. Right limbs count
as mirror images of left ones. Every motion weighs the same, however long it is. To the samples a mixture of Gaussians
is fitted by expectation and maximisation (Dempster, Laird, Rubin, 1977).
"""
import gzip
import math
import pathlib
import random
import sys

COMPONENTS = 4
LEAST_DEVIATION = 0.12  # radians: what few people show of a pose is narrower than what all people do
SAMPLES = 300  # of a motion
BVH = ("cmu_05_01", "cmu_49_04", "cmu_102_01cc")


# Vectors and matrices: tuples of numbers, tuples of rows.
def multiply(a, b):
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def transpose(a):
    return tuple(zip(*a))


def apply(a, v):
    return tuple(sum(a[i][k] * v[k] for k in range(3)) for i in range(3))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def scaled(v, s):
    return tuple(x * s for x in v)


def unit(v):
    return scaled(v, 1 / math.sqrt(dot(v, v)))


def across(v, axis):
    return unit(tuple(x - dot(v, axis) * a for x, a in zip(v, axis)))


def columns(*vectors):
    return transpose(vectors)


IDENTITY = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def about(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return {"X": ((1, 0, 0), (0, c, -s), (0, s, c)), "Y": ((c, 0, s), (0, 1, 0), (-s, 0, c)),
            "Z": ((c, -s, 0), (s, c, 0), (0, 0, 1))}[axis]


def rotation_vector(r):
    """The shorter one."""
    trace = r[0][0] + r[1][1] + r[2][2]
    angle = math.acos(max(-1.0, min(1.0, (trace - 1) / 2)))
    v = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1])
    size = math.sqrt(dot(v, v))
    return (0.0, 0.0, 0.0) if size < 1e-9 else scaled(v, angle / size)


# A motion: for each frame, for each bone, the rotation from where it is at rest; and the bones' directions at rest.
def read_amc(skeleton, motion, step=None):
    bones, children = {}, {}
    for block in skeleton.split(":bonedata")[1].split(":hierarchy")[0].split("begin")[1:]:
        words = {line.split()[0]: line.split()[1:] for line in block.splitlines() if line.split()}
        turn = IDENTITY  # about x, then y, then z, each fixed
        for axis, degrees in zip("XYZ", words["axis"]):
            turn = multiply(about(axis, float(degrees)), turn)
        bones[words["name"][0]] = (tuple(map(float, words["direction"])), turn, words.get("dof", []))
    for line in skeleton.split(":hierarchy")[1].splitlines():
        if line.split()[:1] and line.split()[0] not in ("begin", "end"):
            children[line.split()[0]] = line.split()[1:]
    frames = []
    for line in motion.splitlines():
        words = line.split()
        if len(words) == 1 and words[0].isdigit():
            frames.append({})
        elif frames:
            frames[-1][words[0]] = list(map(float, words[1:]))

    def place(frame):
        placed = {"root": euler("XYZ", frame["root"][3:])}
        waiting = ["root"]
        while waiting:
            bone = waiting.pop()
            for child in children.get(bone, []):
                _, axes, freedoms = bones[child]
                own = euler([f[1].upper() for f in freedoms], frame.get(child, []))
                placed[child] = multiply(placed[bone], multiply(multiply(axes, own), transpose(axes)))
                waiting.append(child)
        return placed

    def euler(axes, angles):
        turn = IDENTITY
        for axis, degrees in zip(axes, angles):
            turn = multiply(about(axis, degrees), turn)
        return turn

    names = {"pelvis": "root", "chest": "thorax"}
    for side in "lr":
        names.update({side + ours: side + theirs for ours, theirs in
                      (("shoulder", "humerus"), ("elbow", "radius"), ("hip", "femur"), ("knee", "tibia"))})
    step = step or max(1, len(frames) // SAMPLES)
    directions = {ours: bones[name][0] for ours, name in names.items() if name in bones}
    return [{ours: p[name] for ours, name in names.items()} for p in map(place, frames[::step])], directions


def read_bvh(text, step=None):
    order, parents, offsets, channels, stack = [], {}, {}, {}, []
    hierarchy, motion = text.split("MOTION")
    for line in hierarchy.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] in ("ROOT", "JOINT", "End"):
            name = words[1] if words[0] != "End" else "end" + str(len(order))
            parents[name] = stack[-1] if stack else None
            order.append(name)
            stack.append(name)
        elif words[0] == "}":
            stack.pop()
        elif words[0] == "OFFSET":
            offsets[stack[-1]] = tuple(map(float, words[1:]))
        elif words[0] == "CHANNELS":
            channels[stack[-1]] = words[2:]

    def place(values):
        placed, at = {}, 0
        for name in order:
            turn = placed[parents[name]] if parents[name] else IDENTITY
            for channel in channels.get(name, []):
                if channel.endswith("rotation"):
                    turn = multiply(turn, about(channel[0], values[at]))
                at += 1
            placed[name] = turn
        return placed

    names = {"pelvis": "hip", "chest": "chest"}
    directions = {}
    for side in "lr":
        for ours, theirs, end in (("shoulder", "shoulder", "elbow"), ("elbow", "elbow", "hand"), ("hip", "hip", "knee"),
                                  ("knee", "knee", "foot")):
            names[side + ours] = side + theirs
            directions[side + ours] = unit(offsets[side + end])
    lines = [list(map(float, line.split())) for line in motion.splitlines()[3:] if line.split()]
    step = step or max(1, len(lines) // SAMPLES)
    return [{ours: p[name] for ours, name in names.items()} for p in map(place, lines[::step])], directions


def limb_poses(frames, directions, side, upper, lower, trunk):
    """Four angles for each frame, as of the left side."""
    mirror = side == "r"

    def of(frame, bone):
        r = frame[bone]
        return tuple(tuple(r[i][j] * (-1 if mirror and (i == 0) != (j == 0) else 1) for j in range(3)) for i in range(3))

    def direction(bone):
        v = directions[side + bone]
        return (-v[0], v[1], v[2]) if mirror else v

    # What the lower bone turns about, at rest: one axis, whatever the motion's format says of it.
    turns = [rotation_vector(multiply(transpose(of(f, side + upper)), of(f, side + lower))) for f in frames]
    mean = tuple(sum(t[i] for t in turns) for i in range(3))
    along = unit(direction(upper))
    hinge = across(mean, along)
    # Our bones at rest: arms point along x and bend about −y, legs along −y and bend about x.
    if upper == "shoulder":
        y = scaled(hinge, -1)
        rest = columns(along, y, cross(along, y))
    else:
        y = scaled(along, -1)
        rest = columns(hinge, y, cross(hinge, y))
    rest_bend = dot(cross(along, unit(direction(lower))), hinge)
    poses = []
    for frame, turn in zip(frames, turns):
        ball = rotation_vector(multiply(multiply(transpose(of(frame, trunk)), of(frame, side + upper)), rest))
        poses.append(ball + (dot(turn, hinge) + math.asin(max(-1.0, min(1.0, rest_bend))),))
    return poses


def collect(folder, upper, lower, trunk):
    samples = []  # (pose, weight)
    skeleton = (folder / "asfamc" / "02.asf").read_text()
    motions = [read_amc(skeleton, gzip.open(path, "rt").read()) for path in sorted((folder / "asfamc").glob("*.amc.gz"))]
    motions += [read_bvh(gzip.open(folder / (name + ".bvh.gz"), "rt").read()) for name in BVH]
    for frames, directions in motions:
        for side in "lr":
            poses = limb_poses(frames, directions, side, upper, lower, trunk)
            samples += [(pose, 1 / len(poses)) for pose in poses]
    return samples


# Symmetric positive matrices of any size.
def cholesky(a):
    n = len(a)
    l = [[0.0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            s = a[i][j] - sum(l[i][k] * l[j][k] for k in range(j))
            l[i][j] = math.sqrt(s) if i == j else s / l[j][j]
    return l


def log_density(pose, mean, factor):
    z = []
    for i, row in enumerate(factor):
        z.append((pose[i] - mean[i] - sum(row[k] * z[k] for k in range(i))) / row[i])
    return -0.5 * dot(z, z) - sum(math.log(factor[i][i]) for i in range(len(z)))


def moments(samples, shares):
    total = sum(w * s for (_, w), s in zip(samples, shares))
    n = len(samples[0][0])
    mean = [sum(w * s * p[i] for (p, w), s in zip(samples, shares)) / total for i in range(n)]
    covariance = [[sum(w * s * (p[i] - mean[i]) * (p[j] - mean[j]) for (p, w), s in zip(samples, shares)) / total
                   for j in range(n)] for i in range(n)]
    for i in range(n):
        covariance[i][i] += LEAST_DEVIATION ** 2
    return total, mean, covariance


def fit_mixture(samples, count, rounds=60):
    choose = random.Random(1)
    everything = [1.0] * len(samples)
    _, _, spread = moments(samples, everything)
    centres = [choose.choice(samples)[0]]
    while len(centres) < count:  # each the farthest from those before, so that the result does not depend on luck
        centres.append(max((p for p, _ in samples), key=lambda p: min(
            sum((a - b) ** 2 / spread[i][i] for i, (a, b) in enumerate(zip(p, c))) for c in centres)))
    mixture = [(1 / count, list(c), spread) for c in centres]
    for _ in range(rounds):
        factors = [cholesky(c) for _, _, c in mixture]
        shares = []
        for pose, _ in samples:
            logs = [math.log(w) + log_density(pose, m, f) for (w, m, _), f in zip(mixture, factors)]
            most = max(logs)
            parts = [math.exp(x - most) for x in logs]
            shares.append([x / sum(parts) for x in parts])
        fitted = [moments(samples, [s[k] for s in shares]) for k in range(count)]
        whole = sum(t for t, _, _ in fitted)
        mixture = [(t / whole, m, c) for t, m, c in fitted]
    return sorted(mixture, reverse=True)


def print_poses(folder, motion, step):
    if (folder / (motion + ".bvh.gz")).exists():
        frames, directions = read_bvh(gzip.open(folder / (motion + ".bvh.gz"), "rt").read(), step)
    else:
        text = gzip.open(folder / "asfamc" / (motion + ".amc.gz"), "rt").read()
        frames, directions = read_amc((folder / "asfamc" / "02.asf").read_text(), text, step)
    limbs = []
    for bones in (("shoulder", "elbow", "chest"), ("hip", "knee", "pelvis")):
        limbs.append(limb_poses(frames, directions, "l", *bones))
        # The right side's angles are the left one's in a mirror.
        limbs.append([(a, -b, -c, bend) for a, b, c, bend in limb_poses(frames, directions, "r", *bones)])
    for frame in zip(*limbs):
        print(*(f"{angle:.5f}" for pose in frame for angle in pose))


def main():
    folder = pathlib.Path(sys.argv[1])
    if sys.argv[2:3] == ["--poses"]:
        print_poses(folder, sys.argv[3], int(sys.argv[4]))
        return
    for name, bones in (("Arms", ("shoulder", "elbow", "chest")), ("Legs", ("hip", "knee", "pelvis"))):
        samples = collect(folder, *bones)
        print(f"// {name}: {len(samples)} poses; 1 % and 99 % of each angle:", ", ".join(
            f"{sorted(p[i] for p, _ in samples)[len(samples) // 100]:.2f} to "
            f"{sorted(p[i] for p, _ in samples)[-len(samples) // 100]:.2f}" for i in range(4)))
        for weight, mean, c in fit_mixture(samples, COMPONENTS):
            lower = ", ".join(f"{c[i][j]:.4f}" for i in range(4) for j in range(i + 1))
            print(f"{{{weight:.3f}, {{{', '.join(f'{m:.3f}' for m in mean)}}}, {{{lower}}}}},")


if __name__ == "__main__":
    main()
