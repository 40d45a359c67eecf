"""The frames at which the nodes of a deforming layer are born."""
from __future__ import annotations

from arithmetic import Decoder, IntegerModels
from budget import Budget
from deformation import Vector, order_of
from matroska import Damaged

BYTES_OF_A_NODE = 4


def read_births(payload: bytes, nodes: list[Vector], frames: int, budget: Budget) -> list[int]:
    """For each node its frame; the number of frames where it is not born in the clip."""
    if not payload or payload[0] != 1:
        raise Damaged("version of births")
    budget.take(BYTES_OF_A_NODE * len(nodes))
    order, neighbours = order_of(nodes)
    decoder, sure, unsure = Decoder(payload[1:]), IntegerModels(), IntegerModels()
    births = [0] * len(nodes)
    for node in order:
        around = [births[neighbour] for neighbour in neighbours[node]]
        expected = around[0] if around else 0
        births[node] = expected + decoder.integer(sure if len(set(around)) < 2 else unsure)
        if not 0 <= births[node] <= frames:
            raise Damaged("a node is born outside of the clip")
    decoder.end()
    return births
