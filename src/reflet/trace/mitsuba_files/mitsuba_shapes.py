"""Mitsuba's shapes as triangle meshes."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.scene.meshes.corners import corner_tangents, face_normals, weld
from reflet.scene.meshes.mesh import Mesh
from reflet.trace.mitsuba_files.mitsuba_nodes import Node

MESHES = ("ply", "obj", "serialized", "cube", "mesh")
STEPS = {"rectangle": (1, 1), "sphere": (96, 48), "disk": (1, 96), "cylinder": (96, 1)}  # triangles' columns and rows


def mesh_of(node: Node, name: str) -> Mesh:
    """The shape in the space it is put into: meshes as they are, curved shapes as fine grids with their exact normals.

    As in Mitsuba normals say where the front is, whatever way triangles go round, and ``flip_normals`` turns it over.
    Vertices without normals get those of their faces, unwelded. Raises RefletError for shapes that are not surfaces.
    """
    if node.plugin not in (*MESHES, *STEPS):
        known = ", ".join((*MESHES, *STEPS, "shapegroup", "instance", "merge"))
        raise RefletError(f"Shape {name} is of type {node.plugin}; those that can be read are {known}; make it a .ply.")
    flipped = bool(node.values.get("flip_normals", False))
    shape = node.built(f"shape {name}", children=False)
    mesh = _grid(node.plugin, shape) if node.plugin in STEPS else _mesh(shape)
    return _facing(replace(mesh, normals=-mesh.normals) if flipped else mesh)


def moved(mesh: Mesh, world_from_local: Float[np.ndarray, "4 4"]) -> Mesh:
    """The mesh of an instance."""
    linear = world_from_local[:3, :3]
    positions = mesh.positions.astype(np.float64) @ linear.T + world_from_local[:3, 3]
    a, b, c = linear  # cofactors, which exist for flat ones too: the inverse transpose times the determinant
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
    sign = -1.0 if np.linalg.det(linear) < 0.0 else 1.0
    normals = sign * mesh.normals.astype(np.float64) @ cofactors.T
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-30)
    tangents = None
    if mesh.tangents is not None:
        along = mesh.tangents[:, :3].astype(np.float64) @ linear.T
        along -= normals * np.einsum("vi,vi->v", along, normals)[:, None]
        along /= np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-30)
        tangents = np.column_stack([along, mesh.tangents[:, 3]]).astype(np.float32)
    turned = replace(mesh, positions=positions.astype(np.float32), normals=normals.astype(np.float32))
    return _facing(replace(turned, tangents=tangents))


def with_tangents(mesh: Mesh) -> Mesh:
    """The mesh, which has texture coordinates, with tangents along u. As in Mitsuba bitangents are normal × tangent,
    also where a picture lies mirrored."""
    corner = mesh.triangles.ravel()
    assert mesh.uv is not None
    at, normals, uv = mesh.positions[corner], mesh.normals[corner], mesh.uv[corner]
    tangents = corner_tangents(at, normals, uv)
    tangents[:, 3] = 1.0
    return weld(at, normals, uv, tangents)


def _facing(mesh: Mesh) -> Mesh:
    """The mesh with triangles counter-clockwise seen from where their normals point."""
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    backwards = np.einsum("ti,ti->t", across, mesh.normals[mesh.triangles].sum(1)) < 0.0
    return replace(mesh, triangles=np.where(backwards[:, None], mesh.triangles[:, ::-1], mesh.triangles))


def _mesh(shape: "mi.Mesh") -> Mesh:
    parameters = mi.traverse(shape)
    positions = np.array(parameters["vertex_positions"], np.float32).reshape(-1, 3)
    triangles = np.array(parameters["faces"], np.uint32).reshape(-1, 3)
    normals = np.array(parameters["vertex_normals"] if shape.has_vertex_normals() else [], np.float32).reshape(-1, 3)
    uv = np.array(parameters["vertex_texcoords"] if shape.has_vertex_texcoords() else [], np.float32).reshape(-1, 2)
    if not len(normals):
        corners = triangles.ravel()
        positions, uv = positions[corners], uv[corners] if len(uv) else uv
        triangles = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
        normals = np.repeat(face_normals(positions)[0], 3, axis=0).astype(np.float32)
    return Mesh(positions, normals, triangles, uv if len(uv) else None)


def _grid(plugin: str, shape: "mi.Shape") -> Mesh:
    columns, rows = STEPS[plugin]
    u = np.tile(np.linspace(0.0, 1.0, columns + 1), rows + 1)
    v = np.repeat(np.linspace(0.0, 1.0, rows + 1), columns + 1)
    local, local_normals = _unit_shape(plugin, u, v)
    world_from_local = np.array(mi.traverse(shape)["to_world"].matrix, np.float64).reshape(4, 4)
    positions = local @ world_from_local[:3, :3].T + world_from_local[:3, 3]
    normals = local_normals @ np.linalg.inv(world_from_local[:3, :3])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    first = np.stack([corner, corner + 1, corner + columns + 2], -1)
    second = np.stack([corner, corner + columns + 2, corner + columns + 1], -1)
    triangles = np.concatenate([first, second])
    edges = positions[triangles[:, 1:]] - positions[triangles[:, :1]]
    across = np.cross(edges[:, 0], edges[:, 1])
    size = float(np.ptp(positions, axis=0).max())
    # At poles one corner of a cell's two triangles falls on another: leave those without area out.
    kept = np.linalg.norm(across, axis=-1) > 1e-9 * size * size
    return Mesh(
        np.ascontiguousarray(positions, np.float32),
        np.ascontiguousarray(normals, np.float32),
        triangles[kept].astype(np.uint32),
        np.stack([u, v], -1).astype(np.float32),
    )


def _unit_shape(plugin: str, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals of Mitsuba's unit shapes at their texture coordinates."""
    zero, one = np.zeros_like(u), np.ones_like(u)
    match plugin:
        case "rectangle":
            return np.stack([2.0 * u - 1.0, 2.0 * v - 1.0, zero], -1), np.stack([zero, zero, one], -1)
        case "disk":
            phi = 2.0 * np.pi * v
            return np.stack([u * np.cos(phi), u * np.sin(phi), zero], -1), np.stack([zero, zero, one], -1)
        case "cylinder":
            phi = 2.0 * np.pi * u
            return np.stack([np.cos(phi), np.sin(phi), v], -1), np.stack([np.cos(phi), np.sin(phi), zero], -1)
    phi, theta = 2.0 * np.pi * u, np.pi * v
    sphere = np.stack([np.cos(phi) * np.sin(theta), np.sin(phi) * np.sin(theta), np.cos(theta)], -1)
    return sphere, sphere
