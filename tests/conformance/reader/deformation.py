"""Deformations: the graph of a deforming layer and the states of its nodes, frame by frame."""
from __future__ import annotations

import struct
from typing import NamedTuple

from arithmetic import Decoder, IntegerModels, new_model, size_class
from matroska import Damaged

ONE = 2048  # the largest component of a rotation
FARTHEST = 1 << 27
Vector = tuple[int, ...]


class State(NamedTuple):
    position: Vector
    rotation: Vector


class Graph(NamedTuple):
    weight_radius: float
    influence_radius: float
    nodes: list[Vector]


class Frame(NamedTuple):
    health: int
    states: list[State]


def read_graph(data: bytes) -> Graph:
    if len(data) < 24 or data[:4] not in (b"\1\0\0\0", b"\2\0\0\0"):
        raise Damaged("version of a graph")
    count, weight, influence = struct.unpack_from("<Idd", data, 4)
    if not 1 <= count <= 16384 or (data[0] == 1 and len(data) != 24 + 12 * count):
        raise Damaged("number of nodes of a graph")
    if not (1e-4 <= weight <= 1e3 and 1e-4 <= influence <= 1e3):
        raise Damaged("radius of a graph")
    nodes = list(struct.iter_unpack("<3i", data[24:])) if data[0] == 1 else read_nodes(data[24:], count)
    if any(abs(x) > 1 << 30 for node in nodes for x in node):
        raise Damaged("a node is too far away")
    return Graph(weight, influence, nodes)


def read_nodes(data: bytes, count: int) -> list[Vector]:
    """Of version 2: each node from one before it."""
    decoder, back, axes = Decoder(data), IntegerModels(), [IntegerModels() for _ in range(3)]
    nodes: list[Vector] = []
    for i in range(count):
        start: Vector = (0, 0, 0)
        if i > 0:
            places = decoder.integer(back)
            if not 0 <= places < i:
                raise Damaged("a node lies beside none")
            start = nodes[i - 1 - places]
        nodes.append(tuple(x + decoder.integer(models) for x, models in zip(start, axes)))
    decoder.end()
    return nodes


def quotient(a: int, b: int) -> int:
    """a / b to the nearest integer, halves up."""
    if b < 0:
        a, b = -a, -b
    return (a + b // 2) // b


def clamp(number: int, limit: int) -> int:
    return max(-limit, min(limit, number))


def product(a: Vector, b: Vector) -> Vector:
    """Of two quaternions."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw)


def first_largest(rotation: Vector) -> int:
    sizes = [abs(component) for component in rotation]
    return sizes.index(max(sizes))


def turned(u: Vector, d: Vector) -> Vector:
    """u d u⁻¹, rounded."""
    w, x, y, z = u
    dx, dy, dz = d
    length = x * x + y * y + z * z
    along = 2 * (x * dx + y * dy + z * dz)
    across = (y * dz - z * dy, z * dx - x * dz, x * dy - y * dx)
    return tuple(quotient((w * w - length) * d[i] + along * u[i + 1] + 2 * w * across[i], w * w + length) for i in range(3))


def order_of(nodes: list[Vector]) -> tuple[list[int], list[list[int]]]:
    """The order in which nodes are coded, and the neighbours of each."""
    def apart(a: int, b: int) -> int:
        return sum((x - y) ** 2 for x, y in zip(nodes[a], nodes[b]))

    order, neighbours = [0], [[] for _ in nodes]
    # For each node that is not coded yet, distance and number of the two nearest coded ones.
    nearest: dict[int, list[tuple[int, int]]] = {i: [(apart(0, i), 0)] for i in range(1, len(nodes))}
    while nearest:
        following = min(nearest, key=lambda i: (nearest[i][0][0], i))
        neighbours[following] = [order[place] for _, place in nearest.pop(following)]
        place = len(order)
        order.append(following)
        for i, found in nearest.items():
            found.append((apart(following, i), place))
            found.sort()
            del found[2:]
    return order, neighbours


class NodeModels:
    """Models of everything that is coded of a node."""

    def __init__(self) -> None:
        self.fine = new_model()
        self.numbers = [[IntegerModels() for _ in range(7)] for _ in range(6)]  # one of fine nodes, six activities
        self.expected_largest = new_model()
        self.largest = [new_model(), new_model(), new_model()]  # higher bit, lower one after 0 and after 1


class Deformations:
    """Reads the payloads of a motion track in the order of time."""

    def __init__(self, graph: Graph) -> None:
        self.order, self.neighbours = order_of(graph.nodes)
        self.rest = [State(tuple(quotient(x, 128) for x in node), (ONE, 0, 0, 0)) for node in graph.nodes]
        self.before: list[State] | None = None

    def read(self, payload: bytes, key: bool) -> Frame:
        if len(payload) < 2 or payload[0] not in (1, 2) or payload[1] > 2:
            raise Damaged("version or health of a deformation")
        if key:
            self.before = self.rest
            self.models = NodeModels()
            self.sizes = [[0] * 6 for _ in self.rest]
        if self.before is None:
            raise Damaged("a deformation refers to one that is not there")
        before, self.before = self.before, None
        decoder = Decoder(payload[2:])
        states: list[State] = list(before)
        for node in self.order:
            states[node] = self._node(decoder, node, before, states, payload[0] == 2)
        decoder.end()
        self.before = states
        return Frame(payload[1], states)

    def _expected(self, node: int, before: list[State], now: list[State]) -> tuple[Vector, list[Vector]]:
        """The position, and the rotations that the neighbours expect."""
        neighbours = self.neighbours[node]
        if not neighbours:
            return before[node].position, [before[node].rotation]
        positions, rotations = [], []
        for n in neighbours:
            w, x, y, z = before[n].rotation
            t = product(now[n].rotation, (w, -x, -y, -z))
            rotations.append(product(t, before[node].rotation))
            u = tuple(quotient(component, 512) for component in t)
            d = tuple(a - b for a, b in zip(before[node].position, before[n].position))
            positions.append([a + b for a, b in zip(now[n].position, turned(u, d))])
        position = tuple(clamp(quotient(sum(p[i] for p in positions), len(positions)), FARTHEST) for i in range(3))
        return position, rotations

    def _node(self, decoder: Decoder, node: int, before: list[State], now: list[State], steps: bool) -> State:
        models, neighbours = self.models, self.neighbours[node]
        position, rotations = self._expected(node, before, now)
        fine = not steps or bool(decoder.bit(models.fine))

        def number(kind: int, prediction: int, step: int, limit: int) -> int:
            activity = self.sizes[node][kind] + sum(self.sizes[n][kind] for n in neighbours)
            which = 0 if fine else 1 + min(5, size_class(activity))
            difference = decoder.integer(models.numbers[kind][which])
            self.sizes[node][kind] = abs(difference) // step if fine else abs(difference)
            value = difference + prediction if fine else (difference + quotient(prediction, step)) * step
            if abs(value) > limit:
                raise Damaged("a node's number is out of its range")
            return value

        place = tuple(number(i, position[i], 4, FARTHEST) for i in range(3))
        largest = first_largest(rotations[0])
        if not decoder.bit(models.expected_largest):
            high = decoder.bit(models.largest[0])
            largest = 2 * high + decoder.bit(models.largest[1 + high])
        rotation, kind = [0, 0, 0, 0], 3
        rotation[largest] = ONE
        for c in range(4):
            if c == largest:
                continue
            ratios = [clamp(quotient(ONE * r[c], r[largest]), ONE) if r[largest] else 0 for r in rotations]
            rotation[c] = number(kind, quotient(sum(ratios), len(ratios)), 8, ONE)
            kind += 1
        if first_largest(tuple(rotation)) != largest:
            raise Damaged("the largest component of a rotation is not the first")
        return State(place, tuple(rotation))
