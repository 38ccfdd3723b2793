"""Places of a glTF file's nodes, and vertices as morph targets and skins pose them (Khronos, ISO/IEC
12113:2022, 3.5 and 3.7)."""

import numpy as np

from renderer.scene.model_files.gltf_buffers import Attributes, Buffers
from renderer.scene.model_files.record import Unreadable


def node_matrix(node: dict) -> np.ndarray:
    """The transform (4, 4) of a node: its matrix, or scale, then rotation, then translation."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", [0, 0, 0, 1]), dtype=float)
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]), dtype=float)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def places_of_nodes(nodes: list[dict], chosen: list[int]) -> np.ndarray:
    """The transforms (k, 4, 4) from chosen nodes to the scene. Raises Unreadable."""
    parent = {child: k for k, node in enumerate(nodes) for child in node.get("children", [])}
    places = []
    for index in chosen:
        place, steps = node_matrix(nodes[index]), 0
        while index in parent:
            index, steps = parent[index], steps + 1
            if steps > len(nodes):
                raise Unreadable("has nodes that are their own children; export it again")
            place = node_matrix(nodes[index]) @ place
        places.append(place)
    return np.array(places)


def morphed(vertices: np.ndarray, primitive: dict, weights: list[float], buffers: Buffers) -> np.ndarray:
    """Vertices (n, 3) moved by a primitive's morph targets, each by its weight. Raises Unreadable."""
    for target, weight in zip(primitive.get("targets", []), weights, strict=False):
        if weight and "POSITION" in target:
            moved = buffers.accessor(target["POSITION"])
            if len(moved) != len(vertices):
                raise Unreadable("has a morph target with another number of vertices than its mesh; export "
                                 "it again")
            vertices = vertices + weight * moved
    return vertices


def skinned(vertices: np.ndarray, attributes: Attributes, joints: np.ndarray) -> tuple[np.ndarray, bool]:
    """Vertices (n, 3) placed by the joints (j, 4, 4) of a skin, not by the node of the mesh; and whether that
    mirrors them. Raises Unreadable."""
    blended, total, sets = np.zeros((len(vertices), 4, 4)), np.zeros(len(vertices)), 0
    while f"JOINTS_{sets}" in attributes:
        index, weight = attributes[f"JOINTS_{sets}"].astype(np.int64), attributes[f"WEIGHTS_{sets}"]
        if len(index) != len(vertices) or len(weight) != len(vertices):
            raise Unreadable("has a skin with another number of vertices than its mesh; export it again")
        if index[weight > 0].max(initial=0) >= len(joints):
            raise Unreadable("has a vertex whose joint is not in its skin; export it again")
        for k in range(4):
            blended += weight[:, k, None, None] * joints[np.where(weight[:, k] > 0, index[:, k], 0)]
        total, sets = total + weight.sum(axis=1), sets + 1
    blended = np.where(total[:, None, None] > 0, blended / np.where(total > 0, total, 1.0)[:, None, None],
                       joints[0])
    placed = np.einsum("nij,nj->ni", blended[:, :3, :3], vertices) + blended[:, :3, 3]
    return placed, bool(np.median(np.linalg.det(blended[:, :3, :3])) < 0)
