"""Writes binary glTF 2.0: shared meshes, materials by name, nodes with transforms; puts pieces into it."""

import json
import struct

import numpy as np

from pictures import png

FLOAT, BYTES = 5126, {1: (5121, np.uint8), 2: (5123, np.uint16), 4: (5125, np.uint32)}
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


class Glb:
    def __init__(self, name, author_note, resolution):
        self.json = dict(
            asset=dict(version="2.0", generator="tools/scenes", copyright=author_note),
            scene=0, scenes=[dict(name=name, nodes=[])], nodes=[], meshes=[], materials=[], accessors=[],
            bufferViews=[], buffers=[], images=[], textures=[], cameras=[],
            samplers=[dict(magFilter=9729, minFilter=9729, wrapS=10497, wrapT=10497)],
            extensionsUsed=[], extras=dict(resolution=list(resolution)))
        self.bytes = bytearray()
        self.shared = {}
        self.meshes = {}

    def _append(self, key, item):
        self.json[key].append(item)
        return len(self.json[key]) - 1

    def _view(self, data, **more):
        self.bytes += bytes(-len(self.bytes) % 4)
        view = dict(buffer=0, byteOffset=len(self.bytes), byteLength=len(data), **more)
        self.bytes += data
        return self._append("bufferViews", view)

    def _vertices(self, values, kind, bounds=False):
        accessor = dict(bufferView=self._view(values.tobytes(), target=ARRAY_BUFFER), componentType=FLOAT,
                        count=len(values), type=kind)
        if bounds:
            accessor.update(min=values.min(0).tolist(), max=values.max(0).tolist())
        return self._append("accessors", accessor)

    def _geometry(self, m, textured):
        """Accessors of a mesh, written once for all materials that use it."""
        key = (id(m), textured)
        if key not in self.shared:
            attributes = dict(POSITION=self._vertices(m["positions"], "VEC3", bounds=True))
            if m["normals"] is not None:
                attributes["NORMAL"] = self._vertices(m["normals"], "VEC3")
            if m.get("tangents") is not None:
                attributes["TANGENT"] = self._vertices(m["tangents"], "VEC4")
            if textured and m["uvs"] is not None:
                attributes["TEXCOORD_0"] = self._vertices(m["uvs"], "VEC2")
            component, kind = BYTES[2 if len(m["positions"]) < 65535 else 4]
            data = m["triangles"].astype(kind).tobytes()
            indices = self._append("accessors", dict(
                bufferView=self._view(data, target=ELEMENT_ARRAY_BUFFER), componentType=component,
                count=m["triangles"].size, type="SCALAR"))
            self.shared[key] = (m, attributes, indices)  # keeps `m` alive, and so its id its own
        return self.shared[key][1:]

    def texture(self, name, picture):
        image = self._append("images", dict(name=name, mimeType="image/png", bufferView=self._view(png(picture))))
        return dict(index=self._append("textures", dict(sampler=0, source=image)))

    def material(self, name, base=(1, 1, 1), metallic=0.0, roughness=1.0, textures=None, extensions=None, **more):
        """`textures`: baseColorTexture; others (normalTexture, emissiveTexture) in `more`. Index of the material."""
        pbr = dict(baseColorFactor=[*map(float, base), 1.0], metallicFactor=metallic, roughnessFactor=roughness)
        if textures:
            pbr["baseColorTexture"] = textures
        material = dict(name=name, pbrMetallicRoughness=pbr, **more)
        if extensions:
            material["extensions"] = extensions
            used = self.json["extensionsUsed"]
            used.extend(e for e in extensions if e not in used)
        return self._append("materials", material)

    def add(self, name, m, material, offset=(0, 0, 0), turn_y=0.0, scale=1.0, rotation=None):
        """A node with that mesh; `rotation` is a quaternion x, y, z, w and goes instead of `turn_y` degrees."""
        key = (id(m), material)
        if key not in self.meshes:
            textured = "Texture\"" in json.dumps(self.json["materials"][material])
            attributes, indices = self._geometry(m, textured)
            primitive = dict(attributes=attributes, indices=indices, material=material)
            self.meshes[key] = self._append("meshes", dict(name=name, primitives=[primitive]))
        node = dict(name=name, mesh=self.meshes[key])
        if any(offset):
            node["translation"] = [round(float(v), 6) for v in offset]
        if rotation is None and turn_y:
            half = np.radians(turn_y) / 2
            rotation = (0.0, np.sin(half), 0.0, np.cos(half))
        if rotation is not None:
            node["rotation"] = [float(v) for v in rotation]
        if scale != 1.0:
            node["scale"] = [scale] * 3
        self.json["scenes"][0]["nodes"].append(self._append("nodes", node))

    def camera(self, name, position, target, yfov_degrees):
        """A camera node that looks from `position` at `target`, +y up."""
        position, target = np.asarray(position, float), np.asarray(target, float)
        back = (position - target) / np.linalg.norm(position - target)
        right = np.cross([0, 1, 0], back)
        right /= np.linalg.norm(right)
        columns = np.stack([right, np.cross(back, right), back, position])
        matrix = np.concatenate([columns, [[0], [0], [0], [1]]], 1)
        width, height = self.json["extras"]["resolution"]
        camera = dict(name=name, type="perspective", perspective=dict(
            yfov=float(np.radians(yfov_degrees)), aspectRatio=width / height, znear=0.01))
        node = dict(name=name, camera=self._append("cameras", camera), matrix=matrix.ravel().tolist())
        self.json["scenes"][0]["nodes"].append(self._append("nodes", node))

    def write(self, path):
        self.bytes += bytes(-len(self.bytes) % 4)
        self.json["buffers"] = [dict(byteLength=len(self.bytes))]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as file:
            file.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(self.bytes)))
            file.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
            file.write(struct.pack("<II", len(self.bytes), 0x004E4942) + bytes(self.bytes))


def place(glb, name, piece, materials, offset=(0, 0, 0), turn_y=0.0, scale=1.0):
    """Adds a piece: a dict of meshes by what they are made of, with materials by the same keys."""
    for part, m in piece.items():
        glb.add(f"{name} {part}", m, materials[part], offset, turn_y, scale)
